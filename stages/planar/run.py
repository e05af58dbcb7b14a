"""A run of a planar walker on penalty ground, whatever integrates it: its state, what was recorded, why it ended.

The motion is recorded at every solver step: events, energy and what is sampled are computed from it. A signal that is
not named has no sensor in Exudyn and no rows in the result.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from stages.biped.accuracy.scales import scales_of
from stages.biped.between_steps import acting, hermite, hermite_from
from stages.biped.design import Biped
from stages.biped.quantity import LEFT, quantity
from stages.biped.walk import StanceState
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import static_penetration
from stages.ground.slope import Slope

#: Coulomb's friction at the hip is proportional to the hip's rate below this rate, in the design's scales, or it
#: would jump: a hip that should stick creeps, at this rate at most.
HIP_CREEP = 2e-4


def hip_creep(biped: Biped, slope: Slope) -> float:
    """That rate [rad/s]."""
    return HIP_CREEP / scales_of(biped, slope.gravity).time


@dataclass(frozen=True)
class PlanarState:
    """Hip point and both legs in the slope frame; SI units; leg 0 is the inner leg.

    Angles are positive with the foot ahead of the hip. `in_play` shows for each leg whether the ground acts on its
    foot, see `stages.multibody.walking.watch`.
    """

    hip_position: tuple[float, float]
    hip_velocity: tuple[float, float]
    leg_angle: tuple[float, float]
    leg_rate: tuple[float, float]
    leg_length: tuple[float, float]
    leg_length_rate: tuple[float, float]
    in_play: tuple[bool, bool]


def rolling_state(biped: Biped, contact: ContactLaw, stance: StanceState, normal_force: float) -> PlanarState:
    """State with leg 0 standing: rolling without slip, pressed into the ground by `normal_force` [N], eqs. (7) and (8).

    The foot's centre lies at x = r theta, so that the foot stands at x = 0 when the leg is upright. The swing foot is
    out of play. Velocities are those of the rolling foot on rigid ground: the penetration starts at rest.
    """
    r = biped.foot_radius
    theta, length = stance.stance_angle, stance.stance_length
    rate, length_rate = stance.stance_rate, stance.stance_length_rate
    sine, cosine = math.sin(theta), math.cos(theta)
    sunk = static_penetration(contact, max(normal_force, 0.0))
    return PlanarState(
        hip_position=(r * theta + (length - r) * sine, r + (length - r) * cosine - sunk),
        hip_velocity=(
            r * rate + length_rate * sine + rate * (length - r) * cosine,
            length_rate * cosine - rate * (length - r) * sine,
        ),
        leg_angle=(-theta, stance.swing_angle),
        leg_rate=(-rate, stance.swing_rate),
        leg_length=(length, stance.swing_length),
        leg_length_rate=(length_rate, stance.swing_length_rate),
        in_play=(True, False),
    )


@dataclass(frozen=True)
class Recorded:
    """Motion at the solver's own steps: times (n,) [s]; coordinates, their rates and accelerations, each (n, k).

    `in_play_at_start` shows for each leg (in the twin: pair of legs) whether the ground acted on its foot at first;
    `switches` lists the changes: (time, leg, in play); `blocks` from when on a leg has a block of this height: (time,
    leg, height [m]). Accelerations that are not exact ring, as those of an implicit solver do.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    in_play_at_start: tuple[bool, bool]
    switches: tuple[tuple[float, int, bool], ...]
    blocks: tuple[tuple[float, int, float], ...] = field(default=(), kw_only=True)
    exact_acceleration: bool = field(default=True, kw_only=True)

    def in_play(self, time: np.ndarray) -> np.ndarray:
        """Whether the ground acts on each foot at the given times, shape (n, 2)."""
        return acting(self.in_play_at_start, self.switches, time)

    def under(self, time: np.ndarray) -> np.ndarray:
        """Heights of the ground under each foot at the given times, (n, 2) [m]."""
        heights = np.zeros((len(time), 2))
        for moment, leg, height in self.blocks:
            heights[time >= moment, leg] = height
        return heights

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates at the given times [s], each (n, k), by Hermite interpolation between the steps.

        Quintic when the accelerations are exact, cubic when they ring.
        """
        return hermite(self.time, self.position, self.velocity, self.known_acceleration, time)

    def after(self, row: int) -> Callable[[float], tuple[np.ndarray, np.ndarray]]:
        """The same at one time after another between a row and the next, each (k,)."""
        return hermite_from(row, self.time, self.position, self.velocity, self.known_acceleration)

    @property
    def known_acceleration(self) -> np.ndarray | None:
        """The accelerations, if they are exact."""
        return self.acceleration if self.exact_acceleration else None


@dataclass(frozen=True)
class Trajectory(Recorded):
    """A planar walk in the slope frame.

    The columns of `position`, `velocity` and `acceleration` are hip x, hip y, angles of leg 0 and 1, lengths of leg 0
    and 1. `ground_reaction` is (n, 2 legs, 2), `foot_acceleration` that of the inner foot's mass centre, (n, 2);
    (n, 0, 2) and (n, 0) where they are not among the signals recorded.
    """

    foot_acceleration: np.ndarray
    ground_reaction: np.ndarray

    def state_at(self, time: float) -> PlanarState:
        """State at a time [s] within the record."""
        position, velocity = (row[0].tolist() for row in self.at(np.array([time])))
        held = self.in_play(np.array([time]))[0]
        return PlanarState(
            hip_position=(position[0], position[1]),
            hip_velocity=(velocity[0], velocity[1]),
            leg_angle=(position[2], position[3]),
            leg_rate=(velocity[2], velocity[3]),
            leg_length=(position[4], position[5]),
            leg_length_rate=(velocity[4], velocity[5]),
            in_play=(bool(held[0]), bool(held[1])),
        )


def foot_kinematics(
    position: np.ndarray, velocity: np.ndarray, leg: int, radius: float, ground: np.ndarray | float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Penetration [m], its rate [m/s] and slip velocity [m/s] of one leg's foot from columns as in `Trajectory`, or one
    of their rows; `ground`: the height of what it is over [m].
    """
    angle, rate = position[..., 2 + leg], velocity[..., 2 + leg]
    reach, reach_rate = position[..., 4 + leg] - radius, velocity[..., 4 + leg]
    sine, cosine = np.sin(angle), np.cos(angle)
    penetration = radius - (position[..., 1] - ground - reach * cosine)
    penetration_rate = -(velocity[..., 1] - reach_rate * cosine + reach * rate * sine)
    centre_velocity = velocity[..., 0] + reach_rate * sine + reach * rate * cosine
    return penetration, penetration_rate, centre_velocity + radius * rate


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
    def completed(self) -> bool:
        """Whether the walker walked as long as requested."""
        return self.outcome == COMPLETED


@dataclass(frozen=True)
class LimitCycle:
    """A gait at mid-stance; rows and columns are the numbers of `section_numbers`.

    Where the legs differ, derivative and multipliers are those of two steps, period and length the means of both.
    """

    section_state: np.ndarray = quantity(
        "m, rad, m/s, rad/s", "hip y, swing angle, both lengths, then the rates, (10,)", dimensions=("coordinate",)
    )
    period_s: float = quantity("s", "duration of one step", symbol="T")
    step_length_m: float = quantity("m", "advance of the hip in one step", symbol="s")
    monodromy_matrix: np.ndarray = quantity("-", "derivative of the step map in those units, shape (10, 10)")
    floquet_multipliers: np.ndarray = quantity(
        "1", "eigenvalues, largest first, real and imaginary part, (10, 2)",
        dimensions=("multiplier", "part"), unordered="eigenvalues")
    residual: float = quantity(
        "1", "how far the fixed point moves in one step, in the scales of the section", without_error=LEFT)
    solver_steps: int = quantity("1", "solver steps of one step")
    steps_walked: int = quantity("1", "steps walked to find the gait and its derivative")

    @property
    def stable(self) -> bool:
        """Whether every multiplier lies inside the unit circle."""
        return bool(np.hypot(*self.floquet_multipliers[0]) < 1.0)
