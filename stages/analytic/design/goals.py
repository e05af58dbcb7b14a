"""What a design can be searched for: measures of a gait with exact gradients by the design's parameters.

A goal is the largest of its parts, each of which is smooth by itself: of the multipliers' magnitudes, of the values at
the start, inside and at the end of each phase of single stance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stages.analytic.derivatives.gait import VariedGait
from stages.analytic.derivatives.multipliers import APART, LEADING, eigensystem, matrix_slope
from stages.analytic.design.stance_extremes import Quantity, extreme_derivatives, extremes, friction_ratio, scuff_depth
from stages.analytic.gait.gait_search import step_length
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model.walker import Vector, Walker

#: Share of a parameter over which the exact monodromy matrix is differenced along the gaits' exact tangent.
MATRIX_SHARE = 2e-5


@dataclass(frozen=True)
class Goal:
    """Parts (m,) of a gait's value, SI, at a tolerance, and their derivatives (m, n) for whole shares of parameters."""

    title: str
    unit: str
    part: str
    parts: Callable[[Walker, FixedPoint, float], Vector]
    slopes: Callable[[VariedGait, float], np.ndarray]


def magnitudes(walker: Walker, point: FixedPoint, tolerance: float) -> Vector:
    """Magnitudes of the multipliers in the order of their real parts, in which they stay as they pass each other's."""
    sizes: Vector = np.abs(np.sort_complex(point.floquet_multipliers))
    return sizes


def magnitude_slopes(gait: VariedGait, tolerance: float) -> np.ndarray:
    """Derivatives of `magnitudes`; zero for the small ones.

    Two that have met have none of their own: they share that of their mean.
    """
    values, left, right = eigensystem(gait.by_state)
    slopes = np.zeros((len(values), len(gait.changes.names)))
    leading = np.abs(values) >= LEADING * np.abs(values).max()
    for row in range(slopes.shape[1]):
        moves = np.einsum("ij,jk,ki->i", left, matrix_slope(gait, row, MATRIX_SHARE), right)
        for index in np.flatnonzero(leading):
            met = leading & (np.abs(values - values[index]) < APART)
            slopes[index, row] = np.real(np.conj(values[index]) * moves[met].mean()) / np.abs(values[index])
    return slopes[np.lexsort((values.imag, values.real))]


def speed(walker: Walker, point: FixedPoint, tolerance: float) -> Vector:
    """Speed, (1,)."""
    return np.array([step_length(walker, point) / point.period * walker.length / walker.time])


def speed_slopes(gait: VariedGait, tolerance: float) -> np.ndarray:
    """Derivatives of `speed`."""
    slopes: np.ndarray = speed(gait.walker, gait.point, tolerance)[:, None] * gait.elasticities()["speed_m_s"]
    return slopes


def _over_stance(title: str, unit: str, quantity: Quantity, length: Callable[[Walker], float]) -> Goal:
    """The largest value of a quantity in single stance."""
    def parts(walker: Walker, point: FixedPoint, tolerance: float) -> Vector:
        return length(walker) * extremes(walker, point, quantity, tolerance)

    def slopes(gait: VariedGait, tolerance: float) -> np.ndarray:
        return length(gait.walker) * extreme_derivatives(gait, quantity, tolerance)

    return Goal(title, unit, "values in single stance", parts, slopes)


GOALS = {
    "multiplier": Goal("largest multiplier", "1", "multipliers", magnitudes, magnitude_slopes),
    "speed": Goal("speed", "m/s", "speeds", speed, speed_slopes),
    "friction": _over_stance("friction needed in single stance", "1", friction_ratio, lambda walker: 1.0),
    "scuff": _over_stance("deepest scuff", "m", scuff_depth, lambda walker: walker.length),
}
