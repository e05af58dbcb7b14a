"""How this room's functions are compiled: as the constraint walkers' are, kept with all their sources."""

from pathlib import Path

from stages.analytic.compiled import SOURCES, kept_in
from stages.biped.machine_code import MachineCode

CODE = MachineCode("calibration", Path(__file__).parent / "observation", *SOURCES)
#: What is worth saying while nothing is compiled yet.
COMPILING = "compiling the equations of motion: about half a minute, once after an install or an edit"


compiled = kept_in(CODE)
