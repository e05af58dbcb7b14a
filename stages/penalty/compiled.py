"""How this room's functions are compiled: as the constraint walkers' are, kept with all the sources they are made of.

What the engine does for a penalty walker is compiled from the engine's own functions, and kept here.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from stages.analytic.compiled import SOURCES, keeper
from stages.biped.machine_code import MachineCode

F = TypeVar("F", bound=Callable[..., Any])
FOLDER = Path(__file__).parent
CODE = MachineCode("penalty", FOLDER, *SOURCES)


def compiled(function: F) -> F:
    """The function as machine code."""
    made: F = keeper(CODE)(function)
    return made


def again(function: Any) -> Any:
    """A compiled function of the engine, once more, for the walkers of this room."""
    return compiled(function.py_func)
