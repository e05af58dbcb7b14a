"""One walk of the twin, with a still stand and a push before it, as its two sensors measure it.

Runs differ by the push, the ramp, the outsole and the built machine. Before the walk the robot is held still with its
legs together, then rocked back and pushed by hand. The inner leg, which carries the sensors, stands on its round foot
and rolls. Its angle follows a quintic from rest to the angle, rate and acceleration with which the walk begins.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BPoly

from stages.biped.accuracy.scales import scales_of
from stages.biped.between_steps import uniform_times
from stages.biped.design import Biped
from stages.biped.walk import StanceState, Walk, require
from stages.campaign.parameters import Parameters, RunSettings
from stages.campaign.result import LegTruth
from stages.campaign.virtual_sensor import SensorMotion
from stages.ground.slope import Slope
from stages.twin.machine.machine import Build
from stages.twin.machine.projection import machine_of
from stages.twin.parameters import IMU_IN_SPACE
from stages.twin.result import Signals
from stages.twin.walking.record import sample
from stages.twin.walking.simulate import rolling_start, simulate_twin


@dataclass(frozen=True)
class Variation:
    """What is different in one run.

    Factors on the rates of stance and swing leg at the start, the true and the read inclination [deg], the angle of
    the still stand from the slope normal [rad], and the machine's departure from its drawing.
    """

    stance_push: float
    swing_push: float
    slope_deg: float
    slope_read_deg: float
    stand_angle: float
    build: Build

    def start(self, state: StanceState) -> StanceState:
        """The state in which the hand lets go."""
        return replace(
            state, stance_rate=state.stance_rate * self.stance_push, swing_rate=state.swing_rate * self.swing_push
        )


def generator(seed: int, run: int, stream: int) -> np.random.Generator:
    """Random numbers of one stream of one run, independent of the order in which runs are computed."""
    return np.random.default_rng([seed, run, stream])


def draw_variation(settings: RunSettings, slope: Slope, rng: np.random.Generator) -> Variation:
    """One draw of everything that differs."""
    tolerance = settings.tolerance_sd
    true_slope = slope.slope_deg + settings.slope_sd_deg * rng.normal()
    return Variation(
        stance_push=1 + settings.push_sd * rng.normal(),
        swing_push=1 + settings.push_sd * rng.normal(),
        slope_deg=true_slope,
        slope_read_deg=round(true_slope + settings.slope_reading_sd_deg * rng.normal(), 2),
        stand_angle=np.deg2rad(settings.stance_sd_deg) * rng.normal(),
        build=Build(
            body_mass=tuple(1 + tolerance * rng.normal(size=6)),
            stiffness=tuple(1 + tolerance * rng.normal(size=4)),
            damping=tuple(1 + tolerance * rng.normal(size=4)),
            leg_length=tuple(settings.length_sd * rng.normal(size=4)),
            outsole=max(0.0, settings.outsole + settings.outsole_sd * rng.normal()),
        ),
    )


def quintic(duration: float, end: tuple[float, float, float], time: np.ndarray) -> np.ndarray:
    """Value, rate and acceleration (3, n) of the quintic from rest at `end`'s zero to `end` at t = duration.

    `end` is (value, rate, acceleration); the quintic starts at zero with zero rate and acceleration.
    """
    curve = BPoly.from_derivatives([0.0, duration], [(0.0, 0.0, 0.0), end])
    return np.stack([curve(time, order) for order in range(3)])


def first_motion(angle: np.ndarray, rate: np.ndarray, grid: float, blow: float) -> tuple[float, float, float]:
    """Angle [rad], rate and acceleration with which a walk begins, of a leg's angle and rate (n,) on a grid [s].

    The acceleration is that of the first step of the grid, or the mean over a `blow` [s] if that is longer: a hand
    does not follow a jump of the rate.
    """
    end = max(1, round(blow / grid))
    return float(angle[0]), float(rate[0]), float((rate[end] - rate[0]) / (end * grid))


def stand_and_push(
    rest_angle: float, end: tuple[float, float, float], rest_s: float, push_s: float, grid: float
) -> tuple[np.ndarray, np.ndarray]:
    """Time (n,) [s], negative up to but without 0, and leg angle, rate, acceleration (3, n).

    rest_angle [rad] is held for `rest_s`; `end` is (angle, rate, acceleration) at time 0; `grid` is the time step [s].
    """
    count = round((rest_s + push_s) / grid)
    time = (np.arange(count) - count) * grid
    angle, rate, acceleration = end
    pushing = quintic(push_s, (angle - rest_angle, rate, acceleration), np.maximum(time + push_s, 0.0))
    pushing[0] += rest_angle
    return time, pushing


def rolling_leg(
    leg: tuple[np.ndarray, np.ndarray, np.ndarray], biped: Biped, slope: Slope, time: np.ndarray
) -> tuple[SensorMotion, SensorMotion]:
    """What hip and foot sensor measure while the leg rolls on its foot at its natural length.

    `leg` is angle, rate, acceleration (n,) of the leg, foot ahead positive [rad, s]. Rolling: the foot's centre moves
    by -r phi; the hip sits L - r from it (eq. 3, with theta = -phi).
    """
    phi, rate, acceleration = leg
    forward = np.stack([np.cos(phi), np.sin(phi)], axis=1)
    up = np.stack([-np.sin(phi), np.cos(phi)], axis=1)
    above_centre, apart = biped.leg_length - biped.foot_radius, biped.leg_length - biped.foot_com
    turn, pull = acceleration[:, None] * forward, (rate**2)[:, None] * up
    hip = -above_centre * turn - above_centre * pull
    hip[:, 0] -= biped.foot_radius * acceleration
    foot = hip + apart * turn + apart * pull
    gravity = np.array(slope.gravity_vector)

    def sensed(movement: np.ndarray) -> SensorMotion:
        force = movement - gravity
        on_body = np.stack([(force * forward).sum(axis=1), (force * up).sum(axis=1), np.zeros(len(phi))], axis=1)
        return SensorMotion(time, on_body, np.stack([np.zeros(len(phi)), np.zeros(len(phi)), rate], axis=1))

    return sensed(hip), sensed(foot)


def joined(before: SensorMotion, after: SensorMotion) -> SensorMotion:
    """Two motions on the same grid, one after the other."""
    return SensorMotion(
        np.concatenate((before.time, after.time)),
        np.concatenate((before.specific_force, after.specific_force)),
        np.concatenate((before.angular_velocity, after.angular_velocity)),
    )


MOST_ATTEMPTS = 10
TRUTH_RATES = 2.0  # of a sensor, at which the true angle is kept
BLOW = 0.1  # pendulum times, by which the blow is over in which a rigid leg takes its load


class NoWalk(RuntimeError):
    """The twin falls however often it is pushed."""


@dataclass(frozen=True)
class TwinRun:
    """What the two sensors measure in one run, the true heel strikes, and what was different.

    The walk begins at time 0; `attempts` counts the pushes it took.
    """

    hip: SensorMotion
    foot: SensorMotion
    heel_strike_time: np.ndarray
    heel_strike_leg: np.ndarray
    leg: LegTruth
    variation: Variation
    attempts: int


def first_state(walk: Walk) -> tuple[StanceState, float]:
    """State of the twin's walk at its first sample, by role of the legs, and the normal force [N] on the inner leg.

    Raises NotRecorded.
    """
    require("twin", {"ground_reaction": walk.ground_reaction})
    state = StanceState(
        stance_angle=-float(walk.leg_angle[0, 0]),
        stance_length=float(walk.leg_length[0, 0]),
        swing_angle=float(walk.leg_angle[0, 1]),
        swing_length=float(walk.leg_length[0, 1]),
        stance_rate=-float(walk.leg_rate[0, 0]),
        stance_length_rate=float(walk.leg_length_rate[0, 0]),
        swing_rate=float(walk.leg_rate[0, 1]),
        swing_length_rate=float(walk.leg_length_rate[0, 1]),
    )
    return state, walk.standing_force


def walk_twin(
    number: int, state: StanceState, normal_force: float, parameters: Parameters, *, bare: bool = False
) -> TwinRun:
    """Run `number` of the campaign, or that without the outsole: push until the twin walks to the end of the ramp.

    Raises NoWalk.
    """
    settings = parameters.runs.of(parameters.biped)
    for attempt in range(MOST_ATTEMPTS):
        variation = draw_variation(settings, parameters.slope, generator(settings.seed, number, attempt))
        if bare:
            variation = replace(variation, build=replace(variation.build, outsole=0.0))
        slope = replace(parameters.slope, slope_deg=variation.slope_deg)
        signals = _signals(variation, slope, state, normal_force, parameters)
        if signals is not None:
            hip, foot = _with_stand(signals, variation, slope, parameters)
            walk = signals.walk
            strikes, legs = walk.heel_strike_time, walk.heel_strike_leg
            truth = leg_truth(walk, TRUTH_RATES * parameters.sensor.rate_hz)
            return TwinRun(hip, foot, strikes, legs, truth, variation, attempt + 1)
    raise NoWalk(f"synthetic run {number}: the twin fell after each of {MOST_ATTEMPTS} pushes")


def leg_truth(walk: Walk, rate_hz: float) -> LegTruth:
    """What the ingest will be held against, from a walk's own motion."""
    time = uniform_times(float(walk.time[-1]), rate_hz)
    hip = [np.interp(walk.heel_strike_time, walk.time, axis) for axis in walk.hip_position.T]
    return LegTruth(
        time=time,
        angle=np.interp(time, walk.time, walk.leg_angle[:, 0]),
        hip_at_strike=np.column_stack(hip),
        toe_off_time=walk.toe_off_time,
        toe_off_leg=walk.toe_off_leg,
    )


def _signals(
    variation: Variation, slope: Slope, state: StanceState, normal_force: float, parameters: Parameters
) -> Signals | None:
    """The twin's walk on a fine grid, or None if it did not reach the end."""
    twin = parameters.twin.with_tolerance(parameters.runs.solver_tolerance)
    twin = replace(twin, signals=(IMU_IN_SPACE,))
    machine = machine_of(parameters.biped, twin, variation.build)
    start = rolling_start(machine, parameters.contact, variation.start(state), normal_force)
    record = simulate_twin(machine, slope, parameters.contact, start, twin, steps=parameters.runs.steps)
    if not record.completed:
        return None
    times = uniform_times(float(record.time[-1]), parameters.runs.motion_rate_hz)
    return sample(record, times, twin)


def _with_stand(
    signals: Signals, variation: Variation, slope: Slope, parameters: Parameters
) -> tuple[SensorMotion, SensorMotion]:
    """Both sensors' motion from the still stand to the end of the walk."""
    settings, walk = parameters.runs, signals.walk
    grid = 1 / settings.motion_rate_hz
    blow = BLOW * scales_of(parameters.biped, slope.gravity).time if parameters.biped.legs == "rigid" else 0.0
    end = first_motion(walk.leg_angle[:, 0], walk.leg_rate[:, 0], grid, blow)
    time, leg = stand_and_push(variation.stand_angle, end, settings.rest_s, parameters.push_s, grid)
    before = rolling_leg((leg[0], leg[1], leg[2]), parameters.biped, slope, time)
    after = (
        SensorMotion(walk.time, signals.hip_imu_specific_force, signals.hip_imu_angular_velocity),
        SensorMotion(walk.time, signals.foot_imu_specific_force, signals.foot_imu_angular_velocity),
    )
    return joined(before[0], after[0]), joined(before[1], after[1])
