"""What the sensors of a run say of the walk: heel strikes, the leg's motion, and its strides laid over each other."""

from __future__ import annotations

import math

import numpy as np

from stages.biped.walk import SENSOR_SIGNALS
from stages.imu.clock.resample import resample
from stages.imu.judgement.rolling_stance import Confirmed
from stages.imu.parameters import Reading, Settings
from stages.imu.result import LegMotion
from stages.imu.strikes.heel_strikes import NO_STRIKES, find_heel_strikes
from stages.imu.strikes.impact_onset import Samples, at_onsets, lift_after
from stages.imu.strikes.step_times import OUTER, HeelStrikes, step_times
from stages.imu.trial.leg_motion import leg_motion, nothing
from stages.imu.trial.places import (
    FORWARD,
    LATERAL,
    PLACES,
    UP,
    BodySensor,
    angle_on,
    bias_error,
    common_grid,
    longest_step,
    on_grid,
)
from stages.imu.trial.sensor import filter_delay


def register(time: np.ndarray, signals: np.ndarray, bounds: np.ndarray, points: int, longest_step: float) -> np.ndarray:
    """Signals (n, k) at times (n,) cut into strides (s, 2) and stretched to `points` phases: (s, points, k).

    Holes longer than `longest_step` [s] stay NaN. Each column has its own holes.
    """
    phase = np.linspace(0.0, 1.0, points)
    grid = bounds[:, :1] + (bounds[:, 1:] - bounds[:, :1]) * phase
    columns = [resample(time, signals[:, [i]], grid.ravel(), longest_step)[:, 0] for i in range(signals.shape[1])]
    return np.stack(columns, axis=-1).reshape(len(bounds), points, signals.shape[1])


def strikes_of(
    sensors: dict[str, BodySensor], settings: Settings, quick: float = 1.0
) -> tuple[HeelStrikes, float]:
    """Heel strikes of the run, and the corner of the low pass they show [Hz], NaN if they show none.

    From the hip sensor, which seldom clips, with the foot's help; else from the foot's. They are found in the time of a
    robot that is so `quick` as Table 1's, for which windows were chosen.
    """
    present = [place for place in PLACES if place in sensors]
    if not present:
        return NO_STRIKES, math.nan
    first, *rest = present
    grid = common_grid({first: sensors[first]}, settings)
    values = on_grid(sensors[first], grid, settings)
    others = [values[:, [3 + LATERAL]]]
    others += [on_grid(sensors[place], grid, settings)[:, [FORWARD, UP, 3 + LATERAL]] for place in rest]
    band = (settings.slowest_step_hz / quick, settings.fastest_step_hz / quick)
    found = find_heel_strikes(quick * grid, values[:, [FORWARD, UP]], values[:, 3 + LATERAL], np.hstack(others), band)
    begun, corner = at_onsets(found, samples_of(sensors[first], [FORWARD, UP], quick), settings.skipped_steps)
    return HeelStrikes(begun.time / quick, begun.leg), corner * quick


def samples_of(sensor: BodySensor, axes: list[int], quick: float) -> Samples:
    """The sensor's samples of the force on these axes, in the time of a robot that is so `quick` as Table 1's."""
    taken = filter_delay(sensor.trace.indexed.recording.device.bandwidth_hz)
    return Samples(quick * sensor.time, sensor.force[:, axes], sensor.trace.rate_hz / quick, quick * taken)


def leg_of(
    sensors: dict[str, BodySensor], strikes: HeelStrikes, corner_hz: float, confirmed: Confirmed, parameters: Reading
) -> LegMotion:
    """The leg's motion from the rates of all sensors, where several see it from their mean; toe-off from the foot's."""
    settings, quick = parameters.settings, parameters.quick
    first = next((place for place in PLACES if place in sensors), None)
    grid = common_grid(sensors, settings) if sensors else np.empty(0)
    if first is None or len(grid) < 2:
        return nothing()
    seen = {place: on_grid(sensor, grid, settings) for place, sensor in sensors.items()}
    angles = [angle_on(grid, place, seen, sensor, settings) for place, sensor in sensors.items()]
    errors = [bias_error(sensor) for sensor in sensors.values()]
    lift = math.nan
    if "foot" in sensors:
        landed = quick * strikes.time[strikes.leg == OUTER]
        lift = lift_after(landed, samples_of(sensors["foot"], [UP], quick), corner_hz / quick) / quick
    return leg_motion(
        grid,
        np.mean(angles, axis=0),
        math.radians(settings.rest_leg_angle_deg),
        math.sqrt(sum(error**2 for error in errors)) / len(errors),
        confirmed,
        strikes,
        step_times(strikes, lift, parameters.drawing),
        parameters.drawing,
        quick,
    )


def registered(sensors: dict[str, BodySensor], bounds: np.ndarray, settings: Settings) -> np.ndarray:
    """Signals of all strides (s, p, 6) in the order of `SENSOR_SIGNALS`; NaN for a sensor that is missing."""
    strides = np.full((len(bounds), settings.phase_points, len(SENSOR_SIGNALS)), np.nan)
    for first, place in ((0, "hip"), (3, "foot")):
        if place in sensors and len(bounds):
            sensor = sensors[place]
            signals = np.column_stack((sensor.force[:, [FORWARD, UP]], sensor.rate[:, LATERAL]))
            strides[:, :, first : first + 3] = register(
                sensor.time, signals, bounds, settings.phase_points, longest_step(sensor, settings)
            )
    return strides
