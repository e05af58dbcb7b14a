"""Design for stability: least largest multiplier over chosen design parameters within bounds.

The largest of several multipliers is not smooth where two of them meet, and the optimum often lies there. Each
iteration therefore solves the linear programme  min t,  |mu_i| + g_i d <= t,  within a trust region, with targets
(speed, step length) as linear equations. The multipliers come from the exact derivative of the step map; their
gradients are differences of these exact values along the followed gait.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import describe
from stages.analytic.gait.poincare import FixedPoint, fixed_point
from stages.analytic.model.walker import Vector
from stages.biped.gait import Gait

#: Relative change of a parameter in the differences for the gradients.
DIFFERENCE = 1e-5
#: Price of missing a target, per unit of relative error: above any slope of the multipliers seen.
PENALTY = 10.0
TARGETS = ("speed_m_s", "step_length_m", "step_frequency_hz")


@dataclass(frozen=True)
class Candidate:
    """A design with its gait; `merit` is the largest multiplier plus the price of missed targets."""

    design: DesignPoint
    point: FixedPoint
    gait: Gait
    misses: Vector
    merit: float

    @property
    def largest_multiplier(self) -> float:
        """Largest multiplier in magnitude."""
        return float(np.abs(self.point.floquet_multipliers).max())


@dataclass(frozen=True)
class DesignSearch:
    """The best design, how it was reached, and whether the search converged or ran out of iterations."""

    start: Candidate
    best: Candidate
    history: tuple[float, ...]
    converged: bool


class Problem:
    """Parameters `names` in relative units x (1 = start value), with bounds and targets."""

    def __init__(
        self,
        design: DesignPoint,
        bounds: Mapping[str, tuple[float, float]],
        targets: Mapping[str, float],
        tolerance: float,
    ) -> None:
        self.names: Sequence[str] = list(bounds)
        self.design, self.targets, self.tolerance = design, dict(targets), tolerance
        self.scale = np.array([design.value(name) or 1.0 for name in self.names])
        self.lower = np.array([bounds[name][0] for name in self.names]) / self.scale
        self.upper = np.array([bounds[name][1] for name in self.names]) / self.scale

    def start(self) -> Vector:
        """The design's own values in relative units."""
        values: Vector = np.array([self.design.value(name) for name in self.names]) / self.scale
        return values

    def candidate(self, x: Vector, z: Vector) -> Candidate | None:
        """The gait near `z` of the design at `x`; None if the design is illegal or has no gait there."""
        design = self.design
        for name, value in zip(self.names, x * self.scale, strict=True):
            design = design.with_value(name, value)
        if not design.is_legal():
            return None
        walker = design.walker()
        point = fixed_point(walker, z, self.tolerance)
        if point is None:
            return None
        gait = describe(walker, point)
        misses = np.array([getattr(gait, name) / value - 1 for name, value in self.targets.items()])
        merit = float(np.abs(point.floquet_multipliers).max() + PENALTY * np.abs(misses).sum())
        return Candidate(design, point, gait, misses, merit)

    def gradients(self, x: Vector, here: Candidate) -> tuple[np.ndarray, np.ndarray] | None:
        """Gradients of the multipliers' magnitudes (j, n) and of the targets' misses (m, n) at `x`."""
        magnitudes, misses = [], []
        for index in range(len(x)):
            step = np.zeros_like(x)
            step[index] = DIFFERENCE
            beyond, before = (self.candidate(x + sign * step, here.point.z) for sign in (1, -1))
            if beyond is None or before is None:
                return None
            magnitudes.append(matched(beyond, here) - matched(before, here))
            misses.append(beyond.misses - before.misses)
        return np.array(magnitudes).T / (2 * DIFFERENCE), np.array(misses).reshape(len(x), -1).T / (2 * DIFFERENCE)


def matched(candidate: Candidate, reference: Candidate) -> np.ndarray:
    """Magnitudes of the candidate's multipliers in the order of the reference's, by nearest value."""
    left = list(candidate.point.floquet_multipliers)
    ordered = []
    for value in reference.point.floquet_multipliers:
        nearest = int(np.argmin([abs(value - other) for other in left]))
        ordered.append(abs(left.pop(nearest)))
    return np.array(ordered)


def linear_step(
    problem: Problem, x: Vector, here: Candidate, gradients: tuple[np.ndarray, np.ndarray], radius: float
) -> Vector:
    """Step d of the linear programme inside the box of half width `radius` and the bounds."""
    slopes, misses = gradients
    count, targets = len(x), len(here.misses)
    magnitudes = np.abs(here.point.floquet_multipliers)
    cost = np.concatenate([np.zeros(count), [1.0], PENALTY * np.ones(2 * targets)])
    rows = np.hstack([slopes, -np.ones((len(magnitudes), 1)), np.zeros((len(magnitudes), 2 * targets))])
    equal = np.hstack([misses, np.zeros((targets, 1)), -np.eye(targets), np.eye(targets)]) if targets else None
    box = np.column_stack([np.maximum(problem.lower - x, -radius), np.minimum(problem.upper - x, radius)])
    bounds = [*map(tuple, box), (0, None), *[(0, None)] * (2 * targets)]
    solution = linprog(cost, rows, -magnitudes, equal, -here.misses if targets else None, bounds)
    return np.zeros(count) if solution.x is None else solution.x[:count]


def search_design(
    design: DesignPoint,
    z: Vector,
    bounds: Mapping[str, tuple[float, float]],
    *,
    targets: Mapping[str, float] | None = None,
    tolerance: float = 1e-10,
    iterations: int = 60,
    progress: Callable[[int, float], None] = lambda iteration, merit: None,
) -> DesignSearch:
    """Minimise the largest multiplier from `design` with its gait at section coordinates `z`.

    `bounds` gives (lower, upper) of each parameter to vary, by its name in the parameter files; `targets` values of
    `speed_m_s`, `step_length_m` or `step_frequency_hz` to hold. Raises ValueError without a gait at `z`.
    """
    problem = Problem(design, bounds, targets or {}, tolerance)
    x, radius = np.clip(problem.start(), problem.lower, problem.upper), 0.05
    best = start = problem.candidate(x, z)
    if best is None or start is None:
        raise ValueError("the design has no gait to start the search from")
    history = [best.merit]
    gradients = problem.gradients(x, best)
    for iteration in range(iterations):
        if gradients is None or radius < 1e-7:
            break
        step = linear_step(problem, x, best, gradients, radius)
        trial = problem.candidate(x + step, best.point.z) if np.abs(step).max() > 1e-12 else None
        if trial is None or trial.merit >= best.merit - 1e-12:
            radius /= 3
            continue
        x, best, radius = x + step, trial, min(2 * radius, 0.3)
        history.append(best.merit)
        progress(iteration, best.merit)
        gradients = problem.gradients(x, best)
    return DesignSearch(start, best, tuple(history), radius < 1e-7)
