"""One step of DOP853 on a phase, its error estimate, and the next step's size."""

from __future__ import annotations

from stages.analytic.compiled import compiled
from stages.analytic.dop853_step import error_norm, take_step

__all__ = ["STAGES", "error_norm", "step_factor", "take_step"]

STAGES = 12


@compiled
def step_factor(error):
    """Factor for the next step's size from the error norm of this one."""
    if error == 0.0:
        return 6.0
    return min(6.0, max(0.2, 0.9 * error ** (-1.0 / 8.0)))
