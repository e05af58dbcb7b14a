"""One step of DOP853 and its error estimate, with all sums of the tableau written out, which is what makes it cheap."""

from __future__ import annotations

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.integration.dop853_tableau import E3, E5, A, B
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
    size = y.size'''

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


WRITTEN = Made(f"{__name__}.functions", source, compiled=compiled, flow=flow)
take_step, error_norm = WRITTEN.take_step, WRITTEN.error_norm
