"""The study in a notebook: load a result, compute a gait of another design, walk it, plot it.

    import bipedstudy as bs

    bs.gait(hip_mass=0.4).gait.period_s                   # another design's gait [s]
    walk = bs.walk("ground.slope_deg=3", steps=6)         # a walk of the constraint model
    bs.array(walk, "hip_position")                        # its values with name, unit, symbol, dimensions
    bs.plot(walk, "hip_position", "leg_angle")            # a Matplotlib figure, axes labelled
    bs.dataset(walk)                                      # the same for xarray, where it is installed
    bs.load("twin").settling.step_frequency_hz            # a stage's stored result [Hz]
    bs.ask("step_frequency", within="1%", hip_mass=0.4)   # every question of the command line: map, design, ...

The study is the one around the working folder, else the one this package brings. Import this before NumPy: it then
computes with the kernels and the one thread of the stored results, and gives the same bits.
"""

import base64
import hashlib
import importlib
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import Any

_HERE = Path(__file__).resolve().parent
_HOME = _HERE.parents[2] if _HERE.parent.name == "face" else _HERE.parent
_OWN = ("pipeline", "stages")
__all__ = ["Array", "StudyError", "array", "arrays", "dataset", "gait", "load", "parameters", "plot", "stages", "walk"]


class _Own(MetaPathFinder):
    """Finds this distribution's own packages where they lie, whatever is called the same in the working folder."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return PathFinder.find_spec(fullname, [str(_HOME)]) if fullname in _OWN else None


def _own_packages_first() -> None:
    for name in _OWN:
        place = getattr(sys.modules.get(name), "__file__", None)
        if place is not None and Path(place).resolve().parent.parent != _HOME:
            raise ImportError(f"bipedstudy needs its own package {name}, but {place} was imported before; "
                              "import bipedstudy first")  # fmt: skip
    if not any(isinstance(finder, _Own) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Own())


def _in_our_place() -> str:
    """Which package of this wheel another distribution put its own in the place of; nothing in a checkout."""
    for record in _HOME.glob("bipedstudy-*.dist-info/RECORD"):
        installed = record.read_text(encoding="utf-8")
        for place in (_HOME / package / "__init__.py" for package in _OWN):
            here = hashlib.sha256(place.read_bytes()).digest() if place.is_file() else b""
            digest = base64.urlsafe_b64encode(here).decode().rstrip("=")
            if f"\n{place.parent.name}/__init__.py,sha256={digest}," not in f"\n{installed}":
                return (f"{place} is not the file that was installed with bipedstudy: another distribution has a "
                        "package of that name; install bipedstudy in an environment of its own")  # fmt: skip
    return ""


_own_packages_first()
#: Why this program cannot run, said by every command; nothing as a rule.
broken = _in_our_place()

if not broken:
    from pipeline.cache import processor

    processor.take()


def __getattr__(name: str) -> Any:
    if broken:
        raise ImportError(broken)
    if name in __all__:
        return getattr(importlib.import_module("bipedstudy.results"), name)
    if not name.startswith("_"):
        try:
            return importlib.import_module("bipedstudy.questions").named(name)
        except KeyError:
            pass
    raise AttributeError(f"module 'bipedstudy' has no attribute {name!r}; it has {', '.join(__dir__())}")


def __dir__() -> list[str]:
    return sorted({*__all__, *importlib.import_module("bipedstudy.questions").names()})
