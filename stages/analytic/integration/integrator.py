"""One step of the integrator that suits the legs: DOP853, or Radau IIA where their springs and dampers are stiff."""

from __future__ import annotations

from collections.abc import Callable

from stages.analytic.compiled import ByKind, compiled
from stages.analytic.integration import dop853_step, radau
from stages.analytic.model.kinds import Kind, Stiff

#: Stages of DOP853, and rows of the array that a step works in.
STAGES = 12


#: Advance `y` by `h` into `new`; how often the rates were evaluated:
#: take_step(phase, y, h, p, stages, new, directions). `stages` (12, size) holds dy/dt at `y` in its first row; the
#: other rows are overwritten.
take_step: Callable[..., int] = ByKind({Stiff: radau.take_step, Kind: dop853_step.take_step})
#: Estimated error of the step just taken, in units of the tolerance; NaN if it is not finite:
#: error_norm(y, new, h, p, stages, tolerance).
error_norm: Callable[..., float] = ByKind({Stiff: radau.error_norm, Kind: dop853_step.error_norm})


@compiled
def step_factor(error: float) -> float:
    """Factor for the next step's size from the error norm of this one: both estimates are of order 7."""
    if error == 0.0:
        return 6.0
    return min(6.0, max(0.2, 0.9 * float(error ** (-1.0 / 8.0))))
