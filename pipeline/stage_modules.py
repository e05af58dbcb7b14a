"""The one place that imports by name: modules of the stages that dvc.yaml lists, each called by what it holds.

A stage is a folder of the package of stages. The engine knows these modules in it, and only `run`, `parameters` and
`result` must be there:

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

A stage is run once more at looser settings of its solvers (`pipeline.parameters.looser`), which gives each of its
numbers an error, unless its `run` says in `ONCE` why not.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from pipeline import AFRESH, spec_of
from pipeline.cache.fingerprint import installed
from pipeline.errors import StudyError
from pipeline.home import DISTRIBUTION, engine, program


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
    own = getattr(_about(package, home), "ATTRIBUTES", {})
    return {**own, "source": program(home / package, " ".join([DISTRIBUTION, *installed([DISTRIBUTION])]))}


def _about(package: str, home: Path) -> ModuleType | None:
    """What the package says of itself, if it does."""
    importable(package, home)
    full = f"{package}.about"
    return importlib.import_module(full) if importlib.util.find_spec(full) else None


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
