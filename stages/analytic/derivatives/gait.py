"""Exact derivatives of a gait by the parameters of its design.

A gait P(z, p) = z moves by dz = (1 - dP/dz)^-1 dP/dp; its period and step length move with z and with p. All are
carried by the step map: by one step, or the two of a stride where the legs differ. Variational equations, shifts of the
events (saltation) and impacts carry one column for each section coordinate and one for each change of the numbers that
is requested. Multipliers are in `multipliers`.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from stages.analytic.derivatives.numbers import Changes, changes_of
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import step_length
from stages.analytic.gait.poincare import FixedPoint, start_state, step_from
from stages.analytic.model.kinds import Plain, directions, exchange, natural_lengths, radii
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.section import section_derivative, section_state, section_tangent


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


def step_tangents(walker: Walker, z: Vector, along: np.ndarray, tolerance: float) -> WalkedTo:
    """The heel strike that ends one step from section coordinates `z`, with all derivatives.

    `along` (n, fields of `walker.p`) are changes of the walker's numbers. Raises StepFailed like `poincare_map`.
    """
    z = np.asarray(z, dtype=float)
    start, free = start_state(walker, z), z.size
    numbers = directions(along, free + len(along))
    y = np.concatenate([start, section_tangent(z, start, walker.p, numbers)])
    step = step_from(walker, y, tolerance, numbers)
    by, delays = section_derivative(y, walker.exchanged.p, numbers), numbers.delays
    return WalkedTo(step.z, step.period, by[:, :free], by[:, free:], delays[:free], delays[free:])


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
            taken.z,
            at.time + taken.time,
            taken.by_start @ at.by_start,
            taken.by_start @ at.along + taken.along,
            at.time_by_start + taken.time_by_start @ at.by_start,
            at.time_along + taken.time_by_start @ at.along + taken.time_along,
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


@dataclass(frozen=True)
class GaitTangents:
    """A gait and its derivatives for whole shares of the parameters in `changes`, dimensionless.

    `by_state` (j, j) is its monodromy matrix. Derivatives: `z` (j, n) of the section coordinates, `state` (size, n) of
    the state just after heel strike, `period` (n,) and `step_length` (n,), means of its steps, in the units of the
    design's own walker.
    """

    walker: Walker
    point: FixedPoint
    changes: Changes
    by_state: np.ndarray
    z: np.ndarray
    state: np.ndarray
    period: Vector
    step_length: Vector

    def elasticities(self) -> dict[str, Vector]:
        """Shares by which measures change for a share of each parameter, d ln measure / d ln parameter, (n,) each.

        For a parameter that is zero a whole share is its `scale`.
        """
        period = self.period / self.point.period
        length = self.step_length / step_length(self.walker, self.point)
        return {"period_s": period, "step_length_m": length, "speed_m_s": length - period, "step_frequency_hz": -period}

    def rows(self, names: Collection[str]) -> list[int]:
        """Places of some of the parameters."""
        return [row for row, name in enumerate(self.changes.names) if name in names]

    def only(self, names: Collection[str]) -> GaitTangents:
        """The same by some of the parameters."""
        rows = self.rows(names)
        return replace(self, changes=self.changes.only(rows), z=self.z[:, rows], state=self.state[:, rows],
                       period=self.period[rows], step_length=self.step_length[rows])


def gait_derivatives(design: DesignPoint, point: FixedPoint, names: tuple[str, ...], tolerance: float) -> GaitTangents:
    """Derivatives of the design's gait `point` by the parameters `names`.

    Raises KeyError for a name that the design's gait does not depend on, StepFailed like `poincare_map`, LinAlgError on
    a fold of the gait's family, where there are none.
    """
    design = design.having(names)
    walker, changes = design.walker(), changes_of(design, names)
    tolerance, steps = attainable_tolerance(walker.p, tolerance), len(point.steps)
    strikes = walk_derivatives(walker, point.z, changes.along, steps, tolerance)
    last = strikes[-1]
    dz = np.linalg.solve(np.eye(point.z.size) - last.by_start, last.along)
    period = (last.time_along + last.time_by_start @ dz) / steps
    y, dy = moved_state(walker, point.z, dz, changes.along)
    lengths = step_length_change(walker, y, dy, changes.along) / steps
    standing, along = walker, changes.along
    for strike in strikes[:-1]:
        standing, along = standing.exchanged, exchanged_rows(standing, along)
        start = moved_state(standing, strike.z, strike.by_start @ dz + strike.along, along)
        lengths += step_length_change(standing, *start, along) / steps
    return GaitTangents(walker, point, changes, last.by_start, dz, dy, period, lengths)


def moved_state(walker: Walker, z: Vector, dz: np.ndarray, along: np.ndarray) -> tuple[Vector, np.ndarray]:
    """The state on the section at coordinates `z`, and its derivatives (size, n) where these have `dz` (j, n)."""
    y, size = section_state(z, walker.p), walker.size
    tangents = section_tangent(z, y, walker.p, directions(along, len(along))).reshape(-1, size)
    return y, tangents[: z.size].T @ dz + tangents[z.size :].T


def step_length_change(walker: Walker, y: Vector, dy: np.ndarray, along: np.ndarray) -> Vector:
    """Derivatives (n,) of the length of the step that leads to state `y`, which moves by `dy` (size, n).

    See `gait_search.step_lengths`.
    """
    numbers = dict(zip(walker.p._fields, along.T, strict=True))
    (radius, trailing), dr = radii(walker.p), numbers["r"]
    dtrailing = numbers.get("r_2", dr)
    if walker.rigid:
        (theta, psi), (dtheta, dpsi) = y[:2], dy[:2]
        stance, swing = natural_lengths(walker.p)
        dstance = numbers["L_nat"]
        dswing = numbers.get("L_nat_2", dstance)
    else:
        (theta, stance, psi, swing), (dtheta, dstance, dpsi, dswing) = y[:4], dy[:4]
    change: Vector = (
        -(stance - radius) * np.cos(theta) * dtheta - (dstance - dr) * np.sin(theta)
        - (swing - trailing) * np.cos(psi) * dpsi - (dswing - dtrailing) * np.sin(psi)
        - radius * (dtheta + dpsi) - dr * (theta + psi)
        - (trailing - radius) * dpsi - (dtrailing - dr) * psi
    )  # fmt: skip
    return change
