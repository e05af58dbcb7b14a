"""The study this program comes with: the checkout it runs from, or what was installed with it; and which code it is."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

from pipeline.cache import disk
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

    The digest tells a checkout that was edited: that of the commit itself is what its unchanged files say.
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
