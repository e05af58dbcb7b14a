"""One walk of the twin, with a still stand and a push before it, as its two sensors feel it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from stages.biped.accuracy.scales import scales_of
from stages.biped.between_steps import uniform_times
from stages.biped.gait import StanceState
from stages.biped.walk import Walk, require
from stages.campaign.parameters import Parameters
from stages.campaign.result import LegTruth
from stages.campaign.standing import first_motion, joined, rolling_leg, stand_and_push
from stages.campaign.variation import Variation, draw_variation, generator
from stages.campaign.virtual_sensor import SensorMotion
from stages.ground.slope import Slope
from stages.twin.machine.machine import build
from stages.twin.parameters import IMU_IN_SPACE
from stages.twin.result import Signals
from stages.twin.walking.signals import sample
from stages.twin.walking.simulate import rolling_start, simulate_twin

MOST_ATTEMPTS = 10
TRUTH_RATES = 2.0  # of a sensor, at which the true angle is kept
BLOW = 0.1  # pendulum times, by which the blow is over in which a rigid leg takes its load


class NoWalk(RuntimeError):
    """The twin falls however often it is pushed."""


@dataclass(frozen=True)
class TwinRun:
    """What the two sensors feel in one run, the true heel strikes, and what was different.

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
            variation = dataclasses.replace(variation, build=dataclasses.replace(variation.build, outsole=0.0))
        slope = dataclasses.replace(parameters.slope, slope_deg=variation.slope_deg)
        signals = _signals(variation, slope, state, normal_force, parameters)
        if signals is not None:
            hip, foot = _with_stand(signals, variation, slope, parameters)
            walk = signals.walk
            strikes, legs = walk.heel_strike_time, walk.heel_strike_leg
            truth = leg_truth(walk, TRUTH_RATES * parameters.sensor.rate_hz)
            return TwinRun(hip, foot, strikes, legs, truth, variation, attempt + 1)
    raise NoWalk(f"synthetic run {number}: the twin fell after each of {MOST_ATTEMPTS} pushes; try a smaller push_sd")


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
    twin = dataclasses.replace(twin, signals=(IMU_IN_SPACE,))
    machine = build(parameters.biped, twin, variation.build)
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
