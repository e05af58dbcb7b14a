"""One step of DOP853 on a phase, and its error estimate."""

from __future__ import annotations

import numpy as np
from stages.analytic.compiled import compiled

from stages.analytic.dop853_tableau import A, B, E3, E5
from stages.analytic.flow import flow

STAGES = 12


@compiled
def take_step(phase, y, h, p, stages, new):
    """Advance `y` by `h` into `new`. `stages[0]` must hold dy/dt at `y`; the other rows are overwritten."""
    size = y.size
    for i in range(1, STAGES):
        for n in range(size):
            total = 0.0
            for j in range(i):
                total += A[i, j] * stages[j, n]
            new[n] = y[n] + h * total
        flow(phase, new, p, stages[i])
    for n in range(size):
        total = 0.0
        for j in range(STAGES):
            total += B[j] * stages[j, n]
        new[n] = y[n] + h * total


@compiled
def error_norm(y, new, h, stages, tolerance):
    """Estimated error of the step in units of the tolerance (absolute and relative alike); NaN if it is not finite."""
    fifth, third = 0.0, 0.0
    for n in range(y.size):
        scale = tolerance * (1.0 + max(abs(y[n]), abs(new[n])))
        e5, e3 = 0.0, 0.0
        for j in range(STAGES):
            e5 += E5[j] * stages[j, n]
            e3 += E3[j] * stages[j, n]
        fifth += (e5 / scale) ** 2
        third += (e3 / scale) ** 2
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return abs(h) * fifth / np.sqrt((fifth + 0.01 * third) * y.size)


@compiled
def step_factor(error):
    """Factor for the next step's size from the error norm of this one."""
    if error == 0.0:
        return 6.0
    return min(6.0, max(0.2, 0.9 * error ** (-1.0 / 8.0)))
