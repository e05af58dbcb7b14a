"""A walk as every model reports it: one definition of its signals, so that models can be laid over each other.

A periodic gait is named as the command line prints it.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity

#: The planar signals of both sensors in the order of every table that holds them: specific force forward and up the
#: leg, then angular velocity, of the hip and of the foot.
SENSOR_SIGNALS = (
    "hip_forward_force",
    "hip_up_force",
    "hip_lateral_rate",
    "foot_forward_force",
    "foot_up_force",
    "foot_lateral_rate",
)

#: What stands along an axis of a signal, by the axis's name.
ALONG = {"leg": ("inner leg", "outer leg"), "direction": ("x", "y"), "body_axis": ("forward", "up the leg")}


@dataclass(frozen=True)
class Walk:
    """Sampled motion in the slope frame (x down-slope, y normal to the ground, z = x cross y).

    The legs are physical ones, by column: 0 is the inner leg, which carries both sensors and stands at the start;
    1 is the outer leg. `leg_angle` is positive with the foot ahead of the hip (psi of a swing leg, -theta of a
    stance leg), which makes it the right-handed rotation about z and continuous when the legs change roles.

    A sensor measures specific force, acceleration minus gravity, on the body axes of the inner leg:
    first forward (cos, sin)(leg_angle), then upward along the leg (-sin, cos)(leg_angle).

    Forces and sensors that a scene leaves out have no rows.
    """

    time: np.ndarray = quantity("s", "time, shape (n,)", symbol="t")
    hip_position: np.ndarray = quantity(
        "m", "hip position x, y, shape (n, 2)", symbol="x_hip, y_hip", dimensions=("time", "direction")
    )
    hip_velocity: np.ndarray = quantity(
        "m/s", "hip velocity x, y, shape (n, 2)", symbol="dx_hip/dt, dy_hip/dt", dimensions=("time", "direction")
    )
    leg_angle: np.ndarray = quantity(
        "rad", "angle of each leg from the slope normal, shape (n, 2)", symbol="phi", dimensions=("time", "leg")
    )
    leg_rate: np.ndarray = quantity(
        "rad/s", "rate of the leg angles, shape (n, 2)", symbol="dphi/dt", dimensions=("time", "leg")
    )
    leg_length: np.ndarray = quantity(
        "m", "length of each leg, hip to bottom of foot, shape (n, 2)", symbol="L", dimensions=("time", "leg")
    )
    leg_length_rate: np.ndarray = quantity(
        "m/s", "rate of the leg lengths, shape (n, 2)", symbol="dL/dt", dimensions=("time", "leg")
    )
    ground_reaction: np.ndarray = quantity(
        "N", "force of the ground on each leg's foot: tangential x, normal y, shape (n, 2 legs, 2)", symbol="F_T, F_N",
        dimensions=("time", "leg", "direction")
    )
    hip_specific_force: np.ndarray = quantity(
        "m/s^2", "specific force at the hip sensor, shape (n, 2)", symbol="f_hip", dimensions=("time", "body_axis")
    )
    hip_angular_velocity: np.ndarray = quantity("rad/s", "angular velocity at the hip sensor about z, shape (n,)")
    foot_specific_force: np.ndarray = quantity(
        "m/s^2", "specific force at the foot sensor, shape (n, 2)", symbol="f_foot", dimensions=("time", "body_axis")
    )
    foot_angular_velocity: np.ndarray = quantity("rad/s", "angular velocity at the foot sensor about z, shape (n,)")
    heel_strike_time: np.ndarray = quantity(
        "s", "times of heel strike, shape (s,)", symbol="t_HS", dimensions=("heel_strike",)
    )
    heel_strike_leg: np.ndarray = quantity(
        "1", "leg that lands at each heel strike, shape (s,)", dimensions=("heel_strike",)
    )
    toe_off_time: np.ndarray = quantity("s", "times of toe-off, shape (o,)", symbol="t_TO", dimensions=("toe_off",))
    toe_off_leg: np.ndarray = quantity(
        "1", "leg that leaves the ground at each toe-off, shape (o,)", dimensions=("toe_off",)
    )

    @property
    def standing_force(self) -> float:
        """Normal force on the leg that stands at the start [N]."""
        return float(self.ground_reaction[0, 0, 1])

    def double_stance(self, strikes: np.ndarray) -> float:
        """Mean time from some of the heel strikes to the other leg's toe-off [s], 0 if at once; NaN without one."""
        spans = []
        for strike in strikes:
            leg = self.heel_strike_leg[np.searchsorted(self.heel_strike_time, strike)]
            after = self.toe_off_time[(self.toe_off_time >= strike) & (self.toe_off_leg != leg)]
            if len(after):
                spans.append(after[0] - strike)
        return float(np.mean(spans)) if spans else float("nan")


class NotRecorded(ValueError):
    """A signal is read that the scene leaves out; the message says which, and where to name it."""


def require(scene: str, signals: Mapping[str, np.ndarray]) -> None:
    """Check that the signals of `scene` (the name of its stage) hold rows; keys are their names in its settings.

    Raises NotRecorded.
    """
    missing = [name for name, values in signals.items() if not len(values)]
    if missing:
        raise NotRecorded(f"{scene}.signals leaves out {', '.join(missing)}, which this stage reads; name it there")


@dataclass(frozen=True)
class StanceState:
    """State of the walker by role of the legs, eq. (2); angles: stance hip ahead, swing foot ahead, positive."""

    stance_angle: float = quantity("rad", "stance leg angle, hip ahead positive", symbol="theta")
    stance_length: float = quantity("m", "stance leg length", symbol="L_1")
    swing_angle: float = quantity("rad", "swing leg angle, foot ahead positive", symbol="psi")
    swing_length: float = quantity("m", "swing leg length", symbol="L_2")
    stance_rate: float = quantity("rad/s", "stance leg rate", symbol="dtheta/dt")
    stance_length_rate: float = quantity("m/s", "stance leg length rate", symbol="dL_1/dt")
    swing_rate: float = quantity("rad/s", "swing leg rate", symbol="dpsi/dt")
    swing_length_rate: float = quantity("m/s", "swing leg length rate", symbol="dL_2/dt")


@dataclass(frozen=True)
class Gait:
    """One periodic gait. A step runs from heel strike to heel strike of the other leg."""

    period_s: float = quantity("s", "duration of one step", symbol="T")
    step_frequency_hz: float = quantity("Hz", "steps per second", symbol="f")
    step_length_m: float = quantity("m", "advance of the hip in one step", symbol="s")
    speed_m_s: float = quantity("m/s", "mean walking speed", symbol="v")
    double_stance_s: float = quantity("s", "time with both feet on the ground in one step", symbol="t_DSP")
    floquet_multipliers: np.ndarray = quantity(
        "1", "multipliers of the step map, largest first, rows of real and imaginary part, shape (j, 2)",
        dimensions=("multiplier", "part"), unordered="eigenvalues")
    steps: int = quantity("1", "steps that these multipliers are of: two where the legs differ")
    stable: bool = quantity("1", "whether every multiplier lies inside the unit circle")
    fixed_point: StanceState = quantity("1", "state just after heel strike, legs already renamed")

    @property
    def largest_multiplier(self) -> float:
        """Magnitude of the largest multiplier, of one step."""
        return largest_of_a_step(self.floquet_multipliers, self.steps)


@dataclass(frozen=True)
class Limp:
    """How a gait of legs that differ limps: its two steps, first that in which the first leg stands."""

    period_s: np.ndarray = quantity("s", "duration of each of the two steps", dimensions=("step",))
    step_length_m: np.ndarray = quantity("m", "length of each of the two steps", dimensions=("step",))
    feet_apart_m: np.ndarray = quantity(
        "m", "how far ahead of the other foot each of the two lands", dimensions=("step",))
    limp: float = quantity("1", "difference of their durations, as part of the mean; zero does not limp")


def largest_of_a_step(multipliers: np.ndarray, steps: int) -> float:
    """Magnitude of the largest of multipliers (j, 2) of so many steps, largest first, of one step; NaN without any."""
    return float(np.hypot(*multipliers[0]) ** (1.0 / steps)) if len(multipliers) else float("nan")
