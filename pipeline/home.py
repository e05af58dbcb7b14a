"""The study this program comes with: the checkout it runs from, or what was installed with it."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from pipeline.errors import StudyError

DISTRIBUTION = "bipedstudy"
_ENGINE = Path(__file__).resolve().parent
_MARK = "dvc.yaml"


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


def check_one_program(root: Path) -> None:
    """Raise `StudyError` where a study brings an engine of its own, which is not the one that runs: they never mix."""
    own = root / _ENGINE.name / Path(__file__).name
    if own.is_file() and not own.samefile(__file__):
        raise StudyError(f"{root} is computed by its own program, and this one is that of {_ENGINE.parent}; run make "
                         f"install in {root}, then {root / '.venv' / 'bin' / DISTRIBUTION}")  # fmt: skip
