"""Levenberg and Marquardt's method for problems that say their own normal equations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from stages.analytic.model.walker import Vector

State = TypeVar("State")
#: Damping at first, its factors, and from which on a step is given up as hopeless.
FIRST, EASED, HARDENED, HOPELESS = 1e-3, 0.1, 10.0, 1e8
#: A fit has come to its end where half the sum of squares would fall by less than this, times the mean square residual
#: where that is larger than noise would have it: intervals are wider by as much, so it is the same part of them.
ENOUGH = 1e-3
MOST_ITERATIONS = 60


@dataclass(frozen=True)
class Point(Generic[State]):
    """Where the method stands: unknowns `x` (n,), half the sum of squares, its equations (matrix (n, n), right side
    (n,)), and what the problem keeps of it; `spread` is the mean square residual, one where noise is all that is left.
    """

    x: Vector
    cost: float
    matrix: np.ndarray
    right: Vector
    state: State
    spread: float = 1.0


@dataclass(frozen=True)
class Ended(Generic[State]):
    """Where the method ended, after how many evaluations, and whether it came to rest; if not, why."""

    point: Point[State]
    evaluations: int
    converged: bool
    why: str


def least_squares(
    evaluate: Callable[[Vector], Point[State] | None], begin: Vector, sizes: Vector, low: Vector,
    most: int = MOST_ITERATIONS, enough: float = ENOUGH,
) -> Ended[State]:
    """Bring the cost down from `begin` (n,) until it rests.

    `evaluate` gives the point at some unknowns, None where there is none. `sizes` (n,) are changes that are neither
    large nor small; no unknown goes below `low` (n,).
    """
    at = evaluate(begin)
    if at is None:
        raise ValueError("no value at the start")
    damping, evaluations = FIRST, 1
    while evaluations < most:
        if _step(at, sizes, low, 0.0)[1] < enough * max(at.spread, 1.0):
            return Ended(at, evaluations, True, "")
        step, foreseen = _step(at, sizes, low, damping)
        tried = evaluate(np.maximum(at.x + step, low))
        evaluations += 1
        if tried is not None and tried.cost < at.cost + 1e-9 * abs(at.cost):
            gain = (at.cost - tried.cost) / max(foreseen, 1e-300)
            at = tried
            if gain > 0.25:
                damping = max(damping * EASED, 1e-9)
            continue
        damping *= HARDENED
        if damping > HOPELESS:
            return Ended(at, evaluations, False, "no step brings the residuals down")
    return Ended(at, evaluations, False, f"{most} evaluations were not enough")


def _step(at: Point[State], sizes: Vector, low: Vector, damping: float) -> tuple[Vector, float]:
    """The damped step of all unknowns that are free to move, and by how much the cost should fall with it."""
    free = ~((at.x <= low) & (at.right <= 0.0))
    unit = sizes[free]
    matrix = at.matrix[np.ix_(free, free)] * unit * unit[:, None]
    right = at.right[free] * unit
    diagonal = np.diag(matrix)
    damped = matrix + np.diag(damping * diagonal + 1e-9)
    equal = 1.0 / np.sqrt(np.diag(damped))
    move = np.linalg.lstsq(damped * equal * equal[:, None], right * equal, rcond=1e-15)[0] * equal
    step = np.zeros(len(at.x))
    step[free] = move * unit
    return step, float(move @ right - 0.5 * move @ matrix @ move)
