"""A run of a planar walker on penalty ground, whatever integrates it: why it ended, what was recorded, what it cost."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stages.ground.slope import Slope
from stages.planar.state import PlanarState
from stages.planar.trajectory import Trajectory

COMPLETED = "completed"
RUNNING = "running"
FELL = "fell"
STALLED = "stalled"
DIVERGED = "diverged"
STEP_FLOOR = "step floor"
SOLVER_FAILED = "solver failed"

#: Hip height, in leg lengths, under which the walker has fallen.
FALLEN = 0.5
#: Time without a heel strike, that of three usual steps, after which a walk has stalled, in pendulum times.
PATIENCE = 8.0


def patience(longest_step: float | None, leg_length: float, slope: Slope) -> float:
    """Time without a heel strike after which a walk has stalled [s]: of a leg length [m], or as set [s]."""
    return longest_step or PATIENCE * math.sqrt(leg_length / slope.gravity)


@dataclass(frozen=True)
class Run:
    """A finished run: why it ended, what was recorded, what it cost in steps and in evaluations of the rates,
    or of the residuals of implicit steps."""

    outcome: str
    message: str
    trajectory: Trajectory
    heel_strikes: int
    solver_steps: int
    evaluations: int
    joint_drift: float

    @property
    def last_state(self) -> PlanarState:
        """The last valid state."""
        return self.trajectory.state_at(float(self.trajectory.time[-1]))

    @property
    def completed(self) -> bool:
        """Whether the walker walked as long as it was asked to."""
        return self.outcome == COMPLETED
