"""One run: its sensors judged, turned into the body's axes, synchronised and cut at heel strikes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.biped.walk import SENSOR_SIGNALS
from stages.imu.clock.resample import resample
from stages.imu.parameters import Settings
from stages.imu.sources.schema import Experiment, Recording
from stages.imu.trial.events import NO_STRIKES, HeelStrikes, StepFrequency, filled, find_heel_strikes, step_frequency
from stages.imu.trial.events import step_period as period_of
from stages.imu.trial.frames import Frame, find_frame
from stages.imu.trial.registration import register, stride_bounds
from stages.imu.trial.report import SensorReport, report_sensor
from stages.imu.trial.run_report import RunReport
from stages.imu.trial.sensor import SensorTrace, trace_sensor

PLACES = ("hip", "foot")
FORWARD, UP, LATERAL = 0, 1, 2


@dataclass(frozen=True)
class BodySensor:
    """A sensor in body axes: time (n,) [s], force (n, 3) [m/s^2], rate (n, 3) [rad/s] without bias."""

    trace: SensorTrace
    frame: Frame
    time: np.ndarray
    force: np.ndarray
    rate: np.ndarray


@dataclass(frozen=True)
class Trial:
    """One run, ready to be compared.

    `foot_lag` is what the foot's stamps were late against the hip's [s], found by cross-correlation and taken out;
    `lever_arm` the distance of the foot sensor below the hip sensor the signals imply [m]; NaN without both sensors.
    `strides` (s, p, 6) are the registered signals in the order of `SENSOR_SIGNALS`.
    """

    experiment: Experiment
    sensors: dict[str, BodySensor]
    reports: tuple[SensorReport, ...]
    foot_lag: float
    lever_arm: float
    overlap: float
    strikes: HeelStrikes
    frequency: StepFrequency
    bounds: np.ndarray
    strides: np.ndarray
    accepted: bool
    reason: str

    def report(self) -> RunReport:
        """What the run is worth."""
        slope = self.experiment.slope_deg
        return RunReport(
            name=self.experiment.name,
            origin=self.experiment.origin,
            slope_deg=math.nan if slope is None else slope,
            overlap=self.overlap,
            foot_lag=self.foot_lag,
            lever_arm=self.lever_arm,
            heel_strikes=len(self.strikes.time),
            strides=len(self.strides),
            step_frequency=self.frequency.value,
            step_frequency_error=self.frequency.standard_error,
            accepted=self.accepted,
            reason=self.reason,
        )


def read_trial(experiment: Experiment, recordings: tuple[Recording, ...], settings: Settings) -> Trial:
    """Take one run from raw rows to registered strides, or to the reason why not."""
    sensors: dict[str, BodySensor] = {}
    reports = []
    for recording in recordings:
        sensor, report = read_sensor(recording, settings)
        reports.append(report)
        place = recording.device.place
        if sensor is not None and report.accepted and place in PLACES and place not in sensors:
            sensors[place] = sensor
    lag, lever, overlap = math.nan, math.nan, math.nan
    if len(sensors) == 2:
        lag = foot_lag(sensors, settings)
        foot = sensors["foot"]
        sensors["foot"] = BodySensor(foot.trace, foot.frame, foot.time - lag, foot.force, foot.rate)
        if all(sensor.trace.clock.stamp != "none" for sensor in sensors.values()):
            overlap = overlap_of(sensors["hip"].time, sensors["foot"].time)
        lever = lever_arm(sensors, settings)
    strikes = strikes_of(sensors, settings)
    used = HeelStrikes(strikes.time[settings.skipped_steps :], strikes.leg[settings.skipped_steps :])
    bounds = stride_bounds(used)
    reason = _refusal(sensors, lever, strikes, settings)
    return Trial(
        experiment=experiment,
        sensors=sensors,
        reports=tuple(reports),
        foot_lag=lag,
        lever_arm=lever,
        overlap=overlap,
        strikes=strikes,
        frequency=step_frequency(used),
        bounds=bounds,
        strides=registered(sensors, bounds, settings),
        accepted=not reason,
        reason=reason,
    )


def read_sensor(recording: Recording, settings: Settings) -> tuple[BodySensor | None, SensorReport]:
    """One sensor in body axes with its report; None where no frame can be found."""
    missing = int((~np.isfinite(np.hstack((recording.acceleration, recording.angular_rate)))).sum())
    trace = trace_sensor(recording, settings)
    frame = frame_of(trace, settings)
    report = report_sensor(trace, frame, settings, recording.experiment.name, recording.rows, missing)
    if frame is None:
        return None, report
    rate = trace.angular_rate - trace.bias()
    turn = frame.rotation.T
    return BodySensor(trace, frame, trace.time, trace.specific_force @ turn, rate @ turn), report


def frame_of(trace: SensorTrace, settings: Settings) -> Frame | None:
    """The frame of a sensor; None without a still stand or without motion after it."""
    if not trace.rest.any():
        return None
    moving = ~trace.rest & np.isfinite(trace.angular_rate).all(axis=1)
    static = trace.static_force()
    if moving.sum() < 3 or not np.linalg.norm(static) > 0:
        return None
    slope = trace.indexed.recording.experiment.slope_deg or 0.0
    return find_frame(
        static,
        trace.angular_rate[moving] - trace.bias(),
        trace.indexed.recording.device,
        math.radians(slope),
        math.radians(settings.rest_leg_angle_deg),
    )


def longest_step(sensor: BodySensor, settings: Settings) -> float:
    """Longest time between two samples that is interpolated [s]."""
    return settings.bridged_samples / sensor.trace.rate_hz


def on_grid(sensor: BodySensor, grid: np.ndarray, settings: Settings) -> np.ndarray:
    """Force and rate (m, 6) on a grid (m,); force and rate keep holes of their own."""
    step = longest_step(sensor, settings)
    return np.hstack([resample(sensor.time, part, grid, step) for part in (sensor.force, sensor.rate)])


def common_grid(sensors: dict[str, BodySensor], settings: Settings) -> np.ndarray:
    """Even grid over the time all sensors cover."""
    first = max(sensor.time[0] for sensor in sensors.values())
    last = min(sensor.time[-1] for sensor in sensors.values())
    count = max(0, int((last - first) * settings.grid_rate_hz) + 1)
    return np.asarray(first + np.arange(count) / settings.grid_rate_hz)


def overlap_of(first: np.ndarray, second: np.ndarray) -> float:
    """Share of the longer recording that both cover."""
    both = min(first[-1], second[-1]) - max(first[0], second[0])
    return float(max(0.0, both) / max(np.ptp(first), np.ptp(second), 1e-9))


def foot_lag(sensors: dict[str, BodySensor], settings: Settings) -> float:
    """How much later the foot's rate shows what the hip's shows [s]: both ride on one leg and turn as one.

    Stamps first: only lags within half a step are tried. Peak of the cross-correlation, refined by a parabola.
    """
    grid = common_grid(sensors, settings)
    if len(grid) < 3 * settings.grid_rate_hz:
        return 0.0
    hip, foot = (filled(on_grid(sensors[place], grid, settings)[:, 3 + LATERAL]) for place in PLACES)
    dt = 1 / settings.grid_rate_hz
    period = period_of(hip, dt, (settings.slowest_step_hz, settings.fastest_step_hz))
    if not math.isfinite(period):
        return 0.0
    reach = max(2, int(0.5 * period / dt))
    lags = np.arange(-reach, reach + 1)
    inner = slice(reach, len(grid) - reach)
    error = np.array([np.mean((hip[inner] - np.roll(foot, -lag)[inner]) ** 2) for lag in lags])
    best = int(np.clip(np.argmin(error), 1, len(lags) - 2))
    left, middle, right = error[best - 1 : best + 2]
    curvature = left - 2 * middle + right
    return float((lags[best] + (0.5 * (left - right) / curvature if curvature > 0 else 0.0)) * dt)


def lever_arm(sensors: dict[str, BodySensor], settings: Settings) -> float:
    """Distance of the foot sensor below the hip sensor [m], from f_foot - f_hip = d (omega' forward + omega^2 up).

    Negative where the two sensors are named the wrong way round.
    """
    grid = common_grid(sensors, settings)
    if len(grid) < 10:
        return math.nan
    hip, foot = (on_grid(sensors[place], grid, settings) for place in PLACES)
    rate = 0.5 * (hip[:, 3 + LATERAL] + foot[:, 3 + LATERAL])
    expected = np.column_stack((np.gradient(rate, grid), rate**2))
    difference = (foot - hip)[:, [FORWARD, UP]]
    known = np.isfinite(expected).all(axis=1) & np.isfinite(difference).all(axis=1)
    # Impacts shake the sensors: trimmed to the smoother nine tenths of the motion.
    size = np.abs(expected[:, 0])
    known &= size < np.nanquantile(size, 0.9) if known.any() else known
    power = float(np.sum(expected[known] ** 2))
    return float(np.sum(expected[known] * difference[known]) / power) if power > 0 else math.nan


def strikes_of(sensors: dict[str, BodySensor], settings: Settings) -> HeelStrikes:
    """Heel strikes of the run from the hip sensor, which seldom clips, with the foot's help; else from the foot's."""
    present = [place for place in PLACES if place in sensors]
    if not present:
        return NO_STRIKES
    first, *rest = present
    grid = common_grid({first: sensors[first]}, settings)
    values = on_grid(sensors[first], grid, settings)
    others = [values[:, [3 + LATERAL]]]
    others += [on_grid(sensors[place], grid, settings)[:, [FORWARD, UP, 3 + LATERAL]] for place in rest]
    band = (settings.slowest_step_hz, settings.fastest_step_hz)
    return find_heel_strikes(grid, values[:, [FORWARD, UP]], values[:, 3 + LATERAL], np.hstack(others), band)


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


def _refusal(sensors: dict[str, BodySensor], lever: float, strikes: HeelStrikes, settings: Settings) -> str:
    if not sensors:
        return "no usable sensor at hip or foot"
    if lever < 0:
        return f"hip and foot are swapped: the foot sensor would sit {-lever:.2f} m above the hip sensor"
    if len(strikes.time) < settings.fewest_steps:
        return f"only {len(strikes.time)} heel strikes"
    return ""
