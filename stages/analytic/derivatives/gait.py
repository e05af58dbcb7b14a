"""Exact derivatives of a gait by the parameters of its design.

A gait P(z, p) = z moves by dz = (1 - dP/dz)^-1 dP/dp; its period and step length move with z and with p. All are
carried by the one step that `step_map` takes. Multipliers are in `multipliers`.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from stages.analytic.derivatives.numbers import Changes, changes_of
from stages.analytic.derivatives.section import section_change
from stages.analytic.derivatives.step_map import VariedStep, varied_step
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import step_length
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.model.varied import varied
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.section import section_state, section_tangent


@dataclass(frozen=True)
class VariedGait:
    """A gait of one step and its derivatives for whole shares of the parameters in `changes`, dimensionless.

    `z` (j, n) of the section coordinates, `state` (size, n) of the state just after heel strike, `period` (n,) and
    `step_length` (n,), in the units of the design's own walker.
    """

    walker: Walker
    point: FixedPoint
    changes: Changes
    step: VariedStep
    z: np.ndarray
    state: np.ndarray
    period: Vector
    step_length: Vector

    def elasticities(self) -> dict[str, Vector]:
        """Shares by which measures change for a share of each parameter, d ln measure / d ln parameter, (n,) each.

        For a parameter that is zero a whole share is its `scale`.
        """
        period = self.period / self.point.steps[0].period
        length = self.step_length / step_length(self.walker, self.point)
        return {"period_s": period, "step_length_m": length, "speed_m_s": length - period, "step_frequency_hz": -period}

    def rows(self, names: Collection[str]) -> list[int]:
        """Places of some of the parameters."""
        return [row for row, name in enumerate(self.changes.names) if name in names]

    def only(self, names: Collection[str]) -> VariedGait:
        """The same by some of the parameters."""
        rows = self.rows(names)
        return replace(self, changes=self.changes.only(rows), z=self.z[:, rows], state=self.state[:, rows],
                       period=self.period[rows], step_length=self.step_length[rows])


def gait_derivatives(design: DesignPoint, point: FixedPoint, names: tuple[str, ...], tolerance: float) -> VariedGait:
    """Derivatives of the design's gait `point`, of one step, by the parameters `names`.

    Raises KeyError for a name that the design's gait does not depend on, StepFailed like `poincare_map`, LinAlgError on
    a fold of the gait's family, where there are none.
    """
    walker, changes = design.walker(), changes_of(design, names)
    step = varied_step(walker, point.z, changes.along, attainable_tolerance(walker.p, tolerance))
    dz = np.linalg.solve(np.eye(point.z.size) - step.by_state, step.along)
    period = step.period_along + step.period_by_state @ dz
    y, size = section_state(point.z, walker.p), walker.size
    tangent = section_tangent(point.z, y, walker.p).reshape(-1, size)
    own = section_change(y, varied(walker.p, changes.along, len(changes.along))).reshape(-1, size)
    dy = tangent.T @ dz + own.T
    return VariedGait(walker, point, changes, step, dz, dy, period, step_length_change(walker, y, dy, changes.along))


def step_length_change(walker: Walker, y: Vector, dy: np.ndarray, along: np.ndarray) -> Vector:
    """Derivatives (n,) of the step length of a gait that starts at state `y`, which moves by `dy` (size, n).

    See `gait_search.step_length`.
    """
    numbers = dict(zip(walker.p._fields, along.T, strict=True))
    radius, dr = walker.p.r, numbers["r"]
    if walker.rigid:
        (theta, psi), (dtheta, dpsi) = y[:2], dy[:2]
        stance = swing = walker.p.L_nat
        dstance = dswing = numbers["L_nat"]
    else:
        (theta, stance, psi, swing), (dtheta, dstance, dpsi, dswing) = y[:4], dy[:4]
    change: Vector = (
        -(stance - radius) * np.cos(theta) * dtheta - (dstance - dr) * np.sin(theta)
        - (swing - radius) * np.cos(psi) * dpsi - (dswing - dr) * np.sin(psi)
        - radius * (dtheta + dpsi) - dr * (theta + psi)
    )  # fmt: skip
    return change
