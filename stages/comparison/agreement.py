"""How far the models agree: the constraint model with Exudyn's (figure 8), the simple model with the twin."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stages.analytic.result import Result as Analytic
from stages.biped.between_steps import largest_magnitudes, sampled_at, time_above
from stages.biped.quantity import quantity
from stages.biped.walk import Walk
from stages.comparison.claims.paper import ACCELEROMETER_G, STANDARD_GRAVITY
from stages.comparison.stride import Stride, normalised_rms
from stages.multibody.result import Result as Multibody
from stages.twin.result import Result as Twin


@dataclass(frozen=True)
class HipDifference:
    """Largest differences of hip position and velocity, multibody minus analytic, x and y."""

    position: np.ndarray = quantity("m", "largest hip position difference in x and y, shape (2,)")
    velocity: np.ndarray = quantity("m/s", "largest hip velocity difference in x and y, shape (2,)")


def overlay(analytic: Walk, multibody: Walk, duration: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (n,) of the analytic walk within `duration` [s] of the walks' common start, and the differences of hip
    position and velocity (n, 2) there, multibody minus analytic."""
    end = min(duration, analytic.time[-1], multibody.time[-1])
    time = analytic.time[analytic.time <= end]
    count = len(time)

    def difference(name: str) -> np.ndarray:
        ours, theirs = getattr(analytic, name)[:count], getattr(multibody, name)
        return np.column_stack([np.interp(time, multibody.time, theirs[:, i]) - ours[:, i] for i in (0, 1)])

    return time, difference("hip_position"), difference("hip_velocity")


def farthest(analytic: Walk, multibody: Walk, duration: float) -> np.ndarray:
    """Largest distances of the hips in x and y [m], (2,), over `duration` [s] from the common start, with its end."""
    time, position, _ = overlay(analytic, multibody, duration)
    end = min(duration, analytic.time[-1], multibody.time[-1])
    events = [times for walk in (analytic, multibody) for times in (walk.heel_strike_time, walk.toe_off_time)]
    times = np.unique(np.append(time, end))
    return largest_magnitudes(*sampled_at(time, position, np.concatenate(events), times))


def from_same_start(analytic: Walk, multibody: Walk, duration: float) -> HipDifference:
    """Largest differences over `duration` [s] when both start from the same mid-stance state.

    Velocities are compared at the samples, but for those between the heel strikes of the two models: there one has had
    its jump, not both.
    """
    time, _, velocity = overlay(analytic, multibody, duration)
    apart = np.zeros(len(time), dtype=bool)
    for pair in zip(analytic.heel_strike_time, multibody.heel_strike_time):
        apart |= (time >= min(pair)) & (time <= max(pair))
    return HipDifference(farthest(analytic, multibody, duration), np.abs(velocity[~apart]).max(axis=0))


def between_cycles(analytic: Stride, multibody: Stride) -> HipDifference:
    """Largest differences of the settled cycles at equal phase."""
    position = np.abs(multibody.hip_position - analytic.hip_position)
    return HipDifference(position.max(axis=0), np.abs(multibody.hip_velocity - analytic.hip_velocity).max(axis=0))


#: Full scale of the paper's accelerometer [m/s^2].
FULL_SCALE = ACCELEROMETER_G * STANDARD_GRAVITY


@dataclass(frozen=True)
class ModelAgreement:
    """Constraint model against the penalty model."""

    same_start: HipDifference = quantity("-", "largest difference over one step from the same mid-stance state")
    same_start_median_velocity: np.ndarray = quantity("m/s", "median velocity difference over that step, shape (2,)")
    settled: HipDifference = quantity("-", "largest difference of the settled cycles at equal phase")
    period_difference: float = quantity("s", "step period of the penalty model minus the constraint model's")
    step_length_difference: float = quantity("m", "step length of the penalty model minus the constraint model's")
    creep_velocity: float = quantity(
        "m/s", "mean slip velocity of the loaded foot in the penalty model's single stance"
    )
    energy_residual: float = quantity("1", "what the penalty model's energy balance does not close")


def compare_models(analytic: Analytic, multibody: Multibody, strides: Mapping[str, Stride]) -> ModelAgreement:
    """Agreement of the results of the analytic and the multibody stage, given the last stride of each by name."""
    period = analytic.gait.period_s
    _, _, velocity = overlay(analytic.walk, multibody.walk, period)
    return ModelAgreement(
        same_start=from_same_start(analytic.walk, multibody.walk, period),
        same_start_median_velocity=np.median(np.abs(velocity), axis=0),
        settled=between_cycles(strides["analytic"], strides["multibody"]),
        period_difference=multibody.cycle.period_s - period,
        step_length_difference=multibody.cycle.step_length_m - analytic.gait.step_length_m,
        creep_velocity=creep_velocity(multibody.walk, multibody.slip_velocity),
        energy_residual=multibody.energy.relative_residual,
    )


def creep_velocity(walk: Walk, slip: np.ndarray) -> float:
    """Mean slip speed [m/s] of the one foot on the ground, from the slip velocities (n, 2) of both."""
    loaded = walk.ground_reaction[:, :, 1] > 0
    alone = loaded.sum(axis=1) == 1
    return float(np.abs(np.where(loaded, slip, 0.0).sum(axis=1))[alone].mean()) if alone.any() else 0.0


@dataclass(frozen=True)
class TwinAgreement:
    """The twin against the simple (planar multibody) model."""

    steps_to_settle: int = quantity("1", "steps until period and length stay within 1 %; -1 if never")
    step_frequency: float = quantity("Hz", "step frequency of the twin's last four steps")
    normalised_rms: np.ndarray = quantity("1", "rms difference over range of six sensor signals at equal phase, (6,)")
    peak_specific_force: float = quantity("m/s^2", "largest specific force at the twin's hip sensor, last stride")
    peak_foot_specific_force: float = quantity("m/s^2", "largest specific force at the twin's foot sensor, last stride")
    peak_rate: float = quantity("rad/s", "largest angular velocity of the twin's sensors, last stride")
    time_above_range: float = quantity("s", "time a step that a component of the twin's specific force is above 4 g")


def compare_twin(twin: Twin, strides: Mapping[str, Stride]) -> TwinAgreement:
    """Agreement of the twin's result and the multibody model, given the last stride of each by name."""
    walk, start = twin.walk, twin.walk.heel_strike_time[-3]
    last = walk.time >= start
    hip, foot = (np.abs(force[last]).max(axis=1) for force in (walk.hip_specific_force, walk.foot_specific_force))
    sensed = np.column_stack([walk.hip_specific_force, walk.foot_specific_force, walk.hip_angular_velocity])
    peaks = largest_magnitudes(walk.time[last], sensed[last])
    steps = int((walk.heel_strike_time >= start).sum()) - 1
    return TwinAgreement(
        steps_to_settle=twin.settling.steps_to_settle,
        step_frequency=twin.settling.step_frequency_hz,
        normalised_rms=normalised_rms(strides["twin"].signals, strides["multibody"].signals),
        peak_specific_force=float(peaks[:2].max()),
        peak_foot_specific_force=float(peaks[2:4].max()),
        peak_rate=float(peaks[4]),
        time_above_range=time_above(walk.time[last], np.maximum(hip, foot), FULL_SCALE) / steps,
    )
