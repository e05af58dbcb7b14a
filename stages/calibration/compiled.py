"""How this room's functions are compiled: as the constraint walkers' are, kept with all their sources."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from stages.analytic.compiled import SOURCES, keeper
from stages.biped.machine_code import MachineCode

F = TypeVar("F", bound=Callable[..., Any])
CODE = MachineCode("calibration", Path(__file__).parent / "motion", *SOURCES)
#: What is worth saying while nothing is compiled yet.
COMPILING = "compiling the equations of motion: about half a minute, once after an install or an edit"


def compiled(function: F) -> F:
    """The function as machine code."""
    made: F = keeper(CODE)(function)
    return made
