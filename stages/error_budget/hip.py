"""The hip's motion (x, y, and their rates) of both models at given times: rows of x, y [m] and rates [m/s]."""

from __future__ import annotations

import numpy as np

from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.flow import RIGID, SINGLE_STANCE
from stages.analytic.walk.recording import Segment, crossing_state, is_last, record
from stages.analytic.walk.sampling import signals_at
from stages.biped.design import Biped
from stages.biped.gait import StanceState
from stages.ground.friction_coefficients import Friction
from stages.ground.slope import Slope
from stages.planar.trajectory import Trajectory


class ConstraintWalk:
    """Two steps of the constraint model from a mid-stance state, by default that of a gait, whose period is told."""

    def __init__(self, walker: Walker, point: FixedPoint, tolerance: float, start: Vector | None = None) -> None:
        self.walker, self.point = walker, point
        self.start = crossing_state(walker, point.z, tolerance) if start is None else start
        phase = RIGID if walker.rigid else SINGLE_STANCE
        self.segments: list[Segment] = record(walker, self.start, 2, tolerance, phase)

    @property
    def mid_stance(self) -> StanceState:
        """State at the start."""
        return self.walker.stance_state(self.start)

    @property
    def period(self) -> float:
        """Step period of the gait [s]."""
        return float(self.point.steps[0].period * self.walker.time)

    @property
    def heel_strikes(self) -> np.ndarray:
        """Times of both heel strikes [s]."""
        ends = [segment.start + segment.duration for segment in self.segments if is_last(segment)]
        return np.array(ends) * self.walker.time

    @property
    def standing_force(self) -> float:
        """Normal force on the standing foot at the start [N]."""
        return float(signals_at(self.walker, self.segments[:1], np.zeros(1))["ground_reaction"][0, 0, 1])

    def hip(self, time: np.ndarray) -> np.ndarray:
        """Hip at times [s] from the start, (n, 4); at heel strike the velocity after it."""
        order, last = np.argsort(time, kind="stable"), self.segments[-1]
        at = np.minimum(time[order] / self.walker.time, last.start + last.duration)
        found = signals_at(self.walker, self.segments, at)
        rows = np.column_stack([found["hip_position"], found["hip_velocity"]])
        return np.asarray(rows[np.argsort(order)])


def constraint_gait(
    biped: Biped, slope: Slope, tolerance: float, friction: Friction | None = None
) -> ConstraintWalk:
    """The gait. Raises NoGait or StepFailed."""
    return ConstraintWalk(*find_gait(biped, slope, tolerance, friction), tolerance)


def penalty_hip(trajectory: Trajectory, time: np.ndarray) -> np.ndarray:
    """Hip of a run of the penalty model at times [s], (n, 4)."""
    position, velocity = trajectory.at(time)
    return np.column_stack([position[:, :2], velocity[:, :2]])
