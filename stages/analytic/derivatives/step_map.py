"""The step map with its derivatives by section coordinates and by numbers of the walker, all exact.

Variational equations, shifts of the events (saltation) and impacts carry one column for each section coordinate and one
for each change of the numbers that is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.analytic.gait.poincare import Step, advance, start_state
from stages.analytic.model.kinds import Plain, directions, exchange
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.section import section_coordinates, section_derivative, section_tangent


@dataclass(frozen=True)
class StepTangents:
    """A step with derivatives, dimensionless: of the section coordinates after it, `by_state` (j, j), `along` (j, n),
    and of its period, `period_by_state` (j,), `period_along` (n,). Those `along` are for the n changes asked for.
    """

    step: Step
    by_state: np.ndarray
    along: np.ndarray
    period_by_state: Vector
    period_along: Vector


def step_tangents(walker: Walker, z: Vector, along: np.ndarray, tolerance: float) -> StepTangents:
    """One step from section coordinates `z` with all derivatives.

    `along` (n, fields of `walker.p`) are changes of the walker's numbers. Raises StepFailed like `poincare_map`.
    """
    z = np.asarray(z, dtype=float)
    start, size, free = start_state(walker, z), walker.size, z.size
    numbers = directions(along, free + len(along))
    y = np.concatenate([start, section_tangent(z, start, walker.p, numbers)])
    double, period, evaluations = advance(walker, y, tolerance, numbers)
    end = y[:size].copy()
    after = walker.exchanged.p
    step = Step(section_coordinates(end, after), end, period, double, evaluations)
    by, delays = section_derivative(y, after, numbers), numbers.delays
    return StepTangents(step, by[:, :free], by[:, free:], delays[:free], delays[free:])


@dataclass(frozen=True)
class WalkedTo:
    """A heel strike of a walk with derivatives, dimensionless: coordinates `z` just after it and its time.

    `by_start` (j, j) and `time_by_start` (j,) by the coordinates that the walk starts from, `along` (j, n) and
    `time_along` (n,) for the n changes of the numbers.
    """

    z: Vector
    time: float
    by_start: np.ndarray
    along: np.ndarray
    time_by_start: Vector
    time_along: Vector


def walk_derivatives(
    walker: Walker, z: Vector, along: np.ndarray, steps: int, tolerance: float
) -> tuple[WalkedTo, ...]:
    """Every heel strike of a walk of so many steps from section coordinates `z`, gait or not, with all derivatives.

    In the first step the legs are those of `walker`, and `along` are changes of its numbers.

    Raises StepFailed like `poincare_map`.
    """
    free, n = len(z), len(along)
    at = WalkedTo(np.asarray(z, dtype=float), 0.0, np.eye(free), np.zeros((free, n)), np.zeros(free), np.zeros(n))
    strikes = []
    for _ in range(steps):
        taken = step_tangents(walker, at.z, along, tolerance)
        at = WalkedTo(
            taken.step.z,
            at.time + taken.step.period,
            taken.by_state @ at.by_start,
            taken.by_state @ at.along + taken.along,
            at.time_by_start + taken.period_by_state @ at.by_start,
            at.time_along + taken.period_by_state @ at.along + taken.period_along,
        )
        strikes.append(at)
        walker, along = walker.exchanged, exchanged_rows(walker, along)
    return tuple(strikes)


def exchanged_rows(walker: Walker, along: np.ndarray) -> np.ndarray:
    """Changes (n, fields) of the walker's numbers as those of its numbers in the next step."""
    if isinstance(walker.p, Plain):
        return along
    order, hinge = exchange(walker.p._fields)
    rows = along[:, order]
    rows[:, hinge] *= -1.0
    return np.asarray(rows)
