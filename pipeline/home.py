"""Where code is: this program with the study it comes with, and the modules of the stages that dvc.yaml lists.

This is the one place that imports by name. A stage is a folder of the package of stages. The engine knows these modules
in it, and only `run`, `parameters` and `result` must be there:

`parameters` (class `Parameters`), `result` (class `Result`), `run` (class `Inputs` if it reads results, function
`run`), `questions` (a folder: each file is a `QUESTION` for the command line), `request` (an option that asks
something of several stages), `warnings` (sentences about parameters before a run), `compiled` (`CODE`, its
machine code on disk: `folder`, `refusal` (why none can be kept, or nothing), `is_cold()` (whether it must be compiled
first), `old(keep)` (folders of old code but the last used); `COMPILING`: what to say where it is cold).

The stage that makes results/figures has `drawn`, so that a figure can be drawn alone: the `NAMES` of all,
`figure(name).inputs` (the results that it shows, by the stems of their files), and `draw(name, parameters, results,
said)`, which gives its files, by path in the results folder, and its caption; what is `said` of the results, if
anything, stands in the picture. The package itself may have
`about`: the `ATTRIBUTES` of all files (title, license, references), which are part of no key.

A stage is run once more at closer settings of its solvers (`pipeline.cache.differences`), which gives each of its
numbers an error, unless its `run` says in `ONCE` why not. Where beginning anew would be wasteful it has a function
`again(parameters, inputs, result)`, which gives the closer result from the one that was found; or, over fewer points,
two, the first as the one that was found; or why there is none. A stage that has both is made again where something
above it is closer. Inputs that have a field `closer` are given to it as they are.
"""

import importlib.util
import json
import sys
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from pipeline import AFRESH, spec_of
from pipeline.cache import disk
from pipeline.cache.fingerprint import installed
from pipeline.errors import StudyError

DISTRIBUTION = "bipedstudy"
_ENGINE = Path(__file__).resolve().parent
_MARK = "dvc.yaml"
#: What a package is made of, beside what was compiled of it.
_SOURCES, _COMPILED = (".py", ".html", ".json", ".mplstyle", ".sql", ".txt"), {"__pycache__", "shipped"}


@cache
def home() -> Path:
    """Folder that holds dvc.yaml, params/ and requirements/. Raises `StudyError` if the installation is incomplete."""
    if (_ENGINE.parent / _MARK).is_file():
        return _ENGINE.parent
    import importlib.metadata

    recorded = [Path(str(file.locate())) for file in importlib.metadata.files(DISTRIBUTION) or () if file.name == _MARK]
    beside = _ENGINE.parent / "share" / DISTRIBUTION / _MARK  # where pip --target puts it, whatever its record says
    for place in (*recorded, beside):
        if place.is_file():
            return place.resolve().parent
    raise StudyError(f"{_ENGINE.parent}: holds no {_MARK}, nor does the installation; install {DISTRIBUTION} anew")


def face() -> Path:
    """Folder of the package that people import, with the texts that `init` writes."""
    inside = _ENGINE / "face" / DISTRIBUTION
    return inside if inside.is_dir() else _ENGINE.parent / DISTRIBUTION


def engine() -> Path:
    """Folder to put on the path of a process that runs the engine."""
    return _ENGINE.parent


def code_of(package: Path) -> dict[str, str]:
    """What a package is made of, the face apart: file -> digest, whatever ends its lines."""
    found = {path.relative_to(package.parent): path for path in package.rglob("*") if path.suffix in _SOURCES}
    return {name.as_posix(): disk.digest(path.read_bytes().replace(b"\r\n", b"\n"))[:16]
            for name, path in sorted(found.items()) if not _COMPILED & {*name.parts} and "face" not in name.parts[1:2]}


def program(package: Path, version: str) -> str:
    """Version, commit and digest of all code that computes the stages of a package; no commit outside of a checkout.

    The digest shows a checkout that was edited: that of the commit itself is what its unchanged files say.
    """
    files = code_of(_ENGINE) | code_of(face()) | code_of(package)
    said = f"{version}, commit {commit}" if (commit := _commit()) else version
    return f"{said}, code {disk.digest(json.dumps(files, sort_keys=True).encode())[:16]}"


def _commit() -> str:
    """The commit of this checkout, read without git, which other users' checkouts are closed to; none: nothing."""
    try:
        place = engine() / ".git"
        if place.is_file():  # a further work tree
            place = engine() / place.read_text().removeprefix("gitdir:").strip()
        ref, shared = (place / "HEAD").read_text().strip(), place / "commondir"
        if not ref.startswith("ref: "):
            return ref
        ref, common = ref.removeprefix("ref: "), place / shared.read_text().strip() if shared.is_file() else place
        if (common / ref).is_file():
            return (common / ref).read_text().strip()
        packed = (common / "packed-refs").read_text().split()
        return packed[packed.index(ref) - 1]
    except (OSError, ValueError):
        return ""


def check_one_program(root: Path) -> None:
    """Raise `StudyError` where a study brings an engine of its own, which is not the one that runs: they never mix."""
    own = root / _ENGINE.name / Path(__file__).name
    if own.is_file() and not own.samefile(__file__):
        raise StudyError(f"{root} is computed by its own program, and this one is that of {_ENGINE.parent}; run make "
                         f"install in {root}, then {root / '.venv' / 'bin' / DISTRIBUTION}")  # fmt: skip


def stage_module(package: str, stage: str, name: str) -> ModuleType:
    """The module `name` of a stage. Raises what its import raises."""
    return importlib.import_module(f"{package}.{stage}.{name}")


def named(module: str, name: str) -> Any:
    """A function by its module and name. Raises what the import raises."""
    return getattr(importlib.import_module(module), name)


def result_class(package: str, stage: str) -> Any:
    """The class of a stage's result."""
    return stage_module(package, stage, "result").Result


def study_attributes(package: str, home: Path) -> dict[str, str]:
    """What every file of a study says of itself: the `ATTRIBUTES` of the package's module `about`, and this program."""
    importable(package, home)
    full = f"{package}.about"
    own = getattr(importlib.import_module(full), "ATTRIBUTES", {}) if importlib.util.find_spec(full) else {}
    return {**own, "source": program(home / package, " ".join([DISTRIBUTION, *installed([DISTRIBUTION])]))}


def home_of(package: str, code_root: Path | None) -> Path:
    """The folder that holds the package: `code_root`, or else this program's, or where it is. Raises `StudyError`."""
    for folder in (code_root, engine()):
        if folder is not None and (folder / package).is_dir():
            return folder
    spec = importlib.util.find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise StudyError(f'{code_root or "here"}: there is no package "{package}" to take the stages from')
    return Path(next(iter(spec.submodule_search_locations))).parent


def importable(package: str, home: Path) -> None:
    """Let the package under `home` be imported, and no other of its name. Raises `StudyError` if another one was."""
    if home != engine():
        AFRESH.add(package)
    if _is_found(package, home):
        return
    if package in sys.modules:
        raise StudyError(f"{home / package}: another {package} was imported before, from "
                         f"{home_of(package, None) / package}; one process computes with one of them")  # fmt: skip
    sys.path.insert(0, str(home))
    importlib.invalidate_caches()
    if not _is_found(package, home):  # the face, which a notebook has, finds this program's own before all others
        spec = spec_of(package, [str(home)])
        assert spec is not None and spec.loader is not None
        sys.modules[package] = module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)


def _is_found(package: str, home: Path) -> bool:
    spec = importlib.util.find_spec(package)
    return spec is not None and str(home / package) in (spec.submodule_search_locations or ())
