"""Newton's method on the step map from many starts, and which of the fixed points it comes to are gaits."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

import numpy as np

from stages.analytic.gait.poincare import FixedPoint, fixed_point
from stages.analytic.model.walker import Vector, Walker

#: Two fixed points closer than this are one.
DISTINCT = 1e-6
SEARCH_TOLERANCE = 1e-8
#: A correction smaller than this, which ends this much nearer to a fixed point than it is long, goes there.
NEAR, LEFT = 0.02, 0.03
#: Newton's method is tried from so many starts; when a stable gait is enough, from so few if they show one.
MOST_STARTS, FEW_STARTS = 80, 12
#: When a stable gait is enough, so many starts in a row that lead to nothing new are the last: the best came first.
#: Fewer are once a gait is known.
PATIENCE, LESS_PATIENCE = 16, 8


def is_new(found: list[FixedPoint], candidate: FixedPoint) -> bool:
    """Whether `candidate` is none of the fixed points found."""
    return all(np.abs(known.z - candidate.z).max() > DISTINCT for known in found)


def is_walking(point: FixedPoint) -> bool:
    """Whether a fixed point moves forward: the stance leg starts behind upright and every step takes time."""
    return bool(point.z[0] < -1e-4) and all(step.period > 1e-3 for step in point.steps)


def by_stability(point: FixedPoint) -> float:
    """Largest multiplier in magnitude."""
    return float(np.abs(point.floquet_multipliers).max())


def is_ahead(met: list[Vector], z: Vector, size: float) -> bool:
    """Whether Newton's method, which a correction of this size led to `z`, converges to one of the points met before.

    Near a fixed point the error that a correction leaves is a small part of it.
    """
    return size < NEAR and any(np.abs(known - z).max() <= LEFT * size for known in met)


def converge(
    walker: Walker, starts: Iterable[Vector], tolerance: float, *, unstable: bool, met: list[Vector] | None = None
) -> list[FixedPoint]:
    """Distinct gaits that Newton's method reaches from `starts`; only the first few if they show a stable one.

    Points in `met` are not gone to again; those that are reached are added to it.
    """
    found: list[FixedPoint] = []
    met, newest = [] if met is None else met, 0
    for count, start in enumerate(starts):
        if count >= MOST_STARTS:
            break
        if not unstable and count >= FEW_STARTS and any(by_stability(point) < 1 for point in found):
            break
        if not unstable and count > newest + (LESS_PATIENCE if met else PATIENCE):
            break
        point = fixed_point(walker, start, max(tolerance, SEARCH_TOLERANCE), known=partial(is_ahead, met))
        if point is not None:
            met.append(point.z)
            newest = count
        if point is None or not is_walking(point) or not is_new(found, point):
            continue
        point = fixed_point(walker, point.z, tolerance)
        if point is not None and is_walking(point) and is_new(found, point):
            found.append(point)
    return found


def first_gait(walker: Walker, starts: Iterable[Vector]) -> FixedPoint | None:
    """The first gait that Newton's method reaches from a few of `starts`."""
    for _, start in zip(range(FEW_STARTS), starts, strict=False):
        point = fixed_point(walker, start, SEARCH_TOLERANCE)
        if point is not None and is_walking(point):
            return point
    return None
