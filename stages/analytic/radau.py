"""One step of Radau IIA, order 13, on a phase: for springs and dampers so stiff that explicit steps would be tiny.

The stages' equations are solved by Newton's method with the exact Jacobian at the step's start, to round-off: a stiff
spring turns an error of its length into a force. Variations ride along, each with the same matrices.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.flow import flow, size_of
from stages.analytic.radau_tableau import (
    A_INVERSE,
    ESTIMATE,
    PAIR_COLUMNS,
    PAIR_ROWS,
    PAIR_VALUES,
    REAL_COLUMN,
    REAL_ROW,
    REAL_VALUE,
    STAGES,
)

ITERATIONS = 50
#: A correction of the state this small may be round-off; larger ones must shrink by this factor, or the step fails.
SMALL, SLOWEST = 1e-11, 0.7
#: What round-off may leave in a variation: a stiff spring multiplies that of a length of order one by its stiffness.
SMALL_VARIATION = 1e-6


@compiled
def jacobian(phase, y, p):
    """d(dy/dt)/dy of a phase at the state, shape (n, n), by unit variations."""
    n = size_of(phase)
    augmented, rates = np.zeros(n * (n + 1)), np.empty(n * (n + 1))
    augmented[:n] = y[:n]
    for i in range(n):
        augmented[n * (i + 1) + i] = 1.0
    flow(phase, augmented, p, rates)
    return rates[n:].reshape(n, n).T.copy()


@compiled
def apply(matrix, vector, n, result):
    """result = matrix times each n-block of a vector."""
    for start in range(0, vector.size, n):
        for i in range(n):
            total = matrix[i, 0] * vector[start]
            for j in range(1, n):
                total += matrix[i, j] * vector[start + j]
            result[start + i] = total


@compiled
def solve_stages(phase, y, h, p, real_inverse, pair_inverses):
    """Increments z of the stages, z = h A f(y + z), shape (s, size), and the iterations; z[0, 0] is NaN on failure."""
    n, size = size_of(phase), y.size
    z, rates = np.zeros((STAGES, size)), np.empty((STAGES, size))
    point, real, real_step = np.empty(size), np.empty(size), np.empty(size)
    pair, pair_step = np.empty(size, np.complex128), np.empty(size, np.complex128)
    change, residual = np.empty((STAGES, size)), np.empty((STAGES, size))
    last = 1e300
    for iteration in range(ITERATIONS):
        for i in range(STAGES):
            point[:] = y + z[i]
            flow(phase, point, p, rates[i])
        for i in range(STAGES):
            for m in range(size):
                total = 0.0
                for j in range(STAGES):
                    total += A_INVERSE[i, j] * z[j, m]
                residual[i, m] = rates[i, m] - total / h
        for m in range(size):
            total = 0.0
            for j in range(STAGES):
                total += REAL_ROW[j] * residual[j, m]
            real[m] = total
        apply(real_inverse, real, n, real_step)
        for i in range(STAGES):
            for m in range(size):
                change[i, m] = REAL_COLUMN[i] * real_step[m]
        for k in range(PAIR_VALUES.size):
            for m in range(size):
                value = 0.0j
                for j in range(STAGES):
                    value += PAIR_ROWS[k, j] * residual[j, m]
                pair[m] = value
            apply(pair_inverses[k], pair, n, pair_step)
            for i in range(STAGES):
                for m in range(size):
                    change[i, m] += 2.0 * (PAIR_COLUMNS[i, k] * pair_step[m]).real
        largest, of_variations = 0.0, 0.0
        for i in range(STAGES):
            for m in range(size):
                z[i, m] += change[i, m]
                relative = abs(change[i, m]) / (1.0 + abs(y[m]))
                if m < n:
                    largest = max(largest, relative)
                else:
                    of_variations = max(of_variations, relative)
        settled = largest <= 2e-16 or (largest <= SMALL and largest >= SLOWEST * last)
        if settled and of_variations <= SMALL_VARIATION:
            return z, iteration + 1
        if not largest < 1e10 or (iteration >= 2 and largest > SLOWEST * last and not settled):
            break
        last = largest
    z[0, 0] = np.nan
    return z, ITERATIONS


@compiled
def take_step(phase, y, h, p, stages, new):
    """Advance `y` by `h` into `new`, and its estimated error into `stages[1]`; returns the evaluations of the rates.

    `stages[0]` must hold dy/dt at `y`. A step whose equations cannot be solved ends in NaN.
    """
    n, size = size_of(phase), y.size
    if h == 0.0:  # an event at the start of a step
        new[:] = y
        stages[1, :] = 0.0
        return 0
    matrix, unit = jacobian(phase, y, p), np.eye(n)
    if not np.isfinite(matrix).all():
        new[:] = np.nan
        stages[1, :] = np.nan
        return n
    real_inverse = np.linalg.inv(unit * (REAL_VALUE / h) - matrix)
    pair_inverses = np.empty((PAIR_VALUES.size, n, n), np.complex128)
    for k in range(PAIR_VALUES.size):
        pair_inverses[k] = np.linalg.inv(unit * (PAIR_VALUES[k] / h) - matrix)
    z, iterations = solve_stages(phase, y, h, p, real_inverse, pair_inverses)
    if np.isnan(z[0, 0]):
        new[:] = np.nan
        stages[1, :] = np.nan
        return STAGES * iterations
    new[:] = y + z[STAGES - 1]
    # embedded formula, filtered twice so that stiff components do not spoil the estimate (Hairer and Wanner, IV.8.20)
    gap, error, rates = np.empty(size), np.empty(size), np.empty(size)
    for m in range(size):
        total = 0.0
        for j in range(STAGES):
            total += ESTIMATE[j] * z[j, m]
        gap[m] = total * REAL_VALUE / h
    apply(real_inverse, gap + stages[0], n, error)
    flow(phase, y + error, p, rates)
    apply(real_inverse, gap + rates, n, error)
    stages[1, :] = error
    return STAGES * iterations + 2


@compiled
def error_norm(phase, y, new, stages, tolerance):
    """Estimated error of the step in units of the tolerance (absolute and relative alike); NaN if it is not finite.

    Only the state counts: its variations are those of the computed steps, whatever their size. In a stiff spring a unit
    of length makes them so large that their round-off would rule the step size.
    """
    n = size_of(phase)
    total = 0.0
    for m in range(n):
        total += (stages[1, m] / (1.0 + max(abs(y[m]), abs(new[m])))) ** 2
    return sqrt(total / n) / tolerance
