"""One step of the integrator that suits the legs: DOP853, or Radau IIA where their springs and dampers are stiff.

All sums of DOP853's tableau are written out, which is what makes it cheap.
"""

from collections.abc import Callable

import numpy as np

from stages.analytic.compiled import ByKind, compiled, uncounted
from stages.analytic.integration import radau
from stages.analytic.integration.dop853_tableau import E3, E5, A, B
from stages.analytic.model.kinds import Kind, Stiff
from stages.analytic.model.made import Made
from stages.analytic.phases.motion import flow

STEP_HEADER = '''from __future__ import annotations

from math import sqrt


@compiled
def take_step(
    phase: int, y: Vector, h: float, p: Kind, stages: np.ndarray, new: Vector, directions: Directions | None = None
) -> int:
    """Advance `y` by `h` into `new`; returns how often the rates were evaluated.

    `stages[0]` must hold dy/dt at `y`; the other rows are overwritten.
    """
    size, y, stages, new = y.size, uncounted(y), uncounted(stages), uncounted(new)'''

ERROR_HEADER = '''@compiled
def error_norm(y: Vector, new: Vector, h: float, p: Kind, stages: np.ndarray, tolerance: float) -> float:
    """Estimated error of the step in units of the tolerance (absolute and relative alike); NaN if it is not finite."""
    fifth, third = 0.0, 0.0
    for n in range(y.size):
        scale = 1.0 / (1.0 + max(abs(y[n]), abs(new[n])))'''

ERROR_END = '''        fifth += (e5 * scale) ** 2
        third += (e3 * scale) ** 2
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return abs(h) * fifth / (tolerance * sqrt((fifth + 0.01 * third) * y.size))
'''


def combination(weights: np.ndarray) -> str:
    """Source of a weighted sum of the stages of component n, without its zeros."""
    return " + ".join(f"{float(weight)!r} * stages[{j}, n]" for j, weight in enumerate(weights) if weight)


def source() -> str:
    """The text of both functions."""
    lines = [STEP_HEADER]
    for stage in range(1, 12):
        lines += ["    for n in range(size):", f"        new[n] = y[n] + h * ({combination(A[stage, :stage])})",
                  f"    flow(phase, new, p, stages[{stage}], directions)"]
    lines += ["    for n in range(size):", f"        new[n] = y[n] + h * ({combination(B)})",
              f"    return {len(B)}", "", "", ERROR_HEADER]
    lines += [f"        e5 = {combination(E5)}", f"        e3 = {combination(E3)}", ERROR_END]
    return "\n".join(lines)


DOP853 = Made(f"{__name__}.dop853", source, compiled=compiled, uncounted=uncounted, flow=flow)
#: Stages of DOP853, and rows of the array that a step works in.
STAGES = 12
#: Advance `y` by `h` into `new`; how often the rates were evaluated:
#: take_step(phase, y, h, p, stages, new, directions). `stages` (12, size) holds dy/dt at `y` in its first row; the
#: other rows are overwritten.
take_step: Callable[..., int] = ByKind({Stiff: radau.take_step, Kind: DOP853.take_step})
#: Estimated error of the step just taken, in units of the tolerance; NaN if it is not finite:
#: error_norm(y, new, h, p, stages, tolerance).
error_norm: Callable[..., float] = ByKind({Stiff: radau.error_norm, Kind: DOP853.error_norm})


@compiled
def step_factor(error: float) -> float:
    """Factor for the next step's size from the error norm of this one: both estimates are of order 7."""
    if error == 0.0:
        return 6.0
    return min(6.0, max(0.2, 0.9 * float(error ** (-1.0 / 8.0))))
