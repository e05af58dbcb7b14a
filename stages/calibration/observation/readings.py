"""What readings tell of Gaussian unknowns, one reading after another: the update of a Kalman filter."""

from __future__ import annotations

from math import sqrt

import numpy as np

from stages.analytic.model.walker import Vector
from stages.calibration.compiled import compiled


@compiled
def take_readings(
    mean: Vector, covariance: np.ndarray, left: Vector, rows: np.ndarray, variances: Vector, robust: float
) -> float:
    """Take readings (r,) less what they should have been for a mean of zero, in place; those of no finite variance not.

    `rows` (r, n) are their derivatives by the unknowns; `mean` (n,), `covariance` (n, n) what is known of these. What
    is more than `robust` standard deviations off pulls less: `variances` (r,) grow as Huber's estimate has it. Returns
    the sum of squares of the innovations in their standard deviations.
    """
    n, total = mean.size, 0.0
    across = np.empty(n)
    for r in range(left.size):
        if variances[r] == np.inf:
            continue
        innovation, expected = left[r], variances[r]
        for i in range(n):
            value = 0.0
            for j in range(n):
                value += covariance[i, j] * rows[r, j]
            across[i] = value
            innovation -= rows[r, i] * mean[i]
            expected += rows[r, i] * value
        size = abs(innovation) / sqrt(expected)
        total += size * size
        more = variances[r] * max(size / robust - 1.0, 0.0)
        variances[r] += more
        for i in range(n):
            gain = across[i] / (expected + more)
            mean[i] += gain * innovation
            for j in range(n):
                covariance[i, j] -= gain * across[j]
    return total
