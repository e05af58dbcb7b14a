"""Exudyn, loaded so that it is fast, opens no window, prints nothing and reads no settings from the user's home folder.

Everything of Exudyn is imported through this module, because how it loads is decided at its first import. Its fast
build, without range checks, takes the same steps in 0.7 times the time; where the processor has no AVX2 Exudyn loads
the other one by itself. A test walks with both.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
from typing import Any

os.environ.setdefault("EXUDYN_NO_USER_SETTINGS", "1")  # such settings would make runs differ between machines
if not hasattr(sys, "exudynFast"):
    sys.exudynFast = True  # type: ignore[attr-defined]

with contextlib.redirect_stdout(io.StringIO()):  # the fast build says its name, settings or not
    import exudyn
    from exudyn import itemInterface as items
    from exudyn.utilities import CreateSymbolicUserFunction

exudyn.config.printToConsole = False
exudyn.special.userInterface.SuppressAll(True)  # its renderer aborts a process that has no display

symbolic: Any = exudyn.symbolic
#: What a solver raises; the checked build wraps a watch's RuntimeError, the fast one hands it on.
SOLVER_ERRORS = (exudyn.ExudynError, RuntimeError)
#: Version and build, as artefacts tell them.
VERSION = f"{exudyn.__version__} ({'fast' if 'exudyn.exudynCPPfast' in sys.modules else 'checked'} build)"

__all__ = ["SOLVER_ERRORS", "VERSION", "CreateSymbolicUserFunction", "exudyn", "items", "symbolic"]
