"""How this room's functions are compiled: as the constraint walkers' are, kept with all the sources they are made of.

What the engine does for a penalty walker is compiled from the engine's own functions, and kept here.
"""

from pathlib import Path
from typing import Any

from stages.analytic.compiled import SOURCES, kept_in
from stages.biped.machine_code import MachineCode

FOLDER = Path(__file__).parent
CODE = MachineCode("penalty", FOLDER, *SOURCES)


compiled = kept_in(CODE)


def again(function: Any) -> Any:
    """A compiled function of the engine, once more, for the walkers of this room."""
    return compiled(function.py_func)
