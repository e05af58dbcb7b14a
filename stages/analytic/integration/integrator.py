"""One step of the integrator that suits the legs: DOP853, or Radau IIA where their springs and dampers are stiff."""

from __future__ import annotations

import numpy as np

from stages.analytic.compiled import Numbers, compiled, inlined
from stages.analytic.integration import dop853_step, radau
from stages.analytic.model.walker import Vector

#: Stages of DOP853, and rows of the array that a step works in.
STAGES = 12

_explicit_step, _explicit_error = dop853_step.take_step, dop853_step.error_norm
_implicit_step, _implicit_error = radau.take_step, radau.error_norm


@inlined
def take_step(implicit: bool, phase: int, y: Vector, h: float, p: Numbers, stages: np.ndarray, new: Vector) -> int:
    """Advance `y` by `h` into `new`; returns how often the rates were evaluated.

    `stages` (12, size) holds dy/dt at `y` in its first row; the other rows are overwritten.
    """
    if implicit:
        return _implicit_step(phase, y, h, p, stages, new)
    _explicit_step(phase, y, h, p, stages, new)
    return STAGES


@inlined
def error_norm(
    implicit: bool, phase: int, y: Vector, new: Vector, h: float, stages: np.ndarray, tolerance: float
) -> float:
    """Estimated error of the step just taken, in units of the tolerance; NaN if it is not finite."""
    if implicit:
        return _implicit_error(phase, y, new, stages, tolerance)
    return _explicit_error(y, new, h, stages, tolerance)


@compiled
def step_factor(error: float) -> float:
    """Factor for the next step's size from the error norm of this one: both estimates are of order 7."""
    if error == 0.0:
        return 6.0
    return min(6.0, max(0.2, 0.9 * float(error ** (-1.0 / 8.0))))
