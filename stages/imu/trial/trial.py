"""One run: its sensors judged, turned into the body's axes, synchronised and cut at heel strikes."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from stages.biped.walk import SENSOR_SIGNALS
from stages.imu.clock.resample import resample
from stages.imu.errors import printable
from stages.imu.parameters import Limits, Parameters, Settings
from stages.imu.sources.schema import Device, Experiment, Recording
from stages.imu.trial.events import NO_STRIKES, HeelStrikes, StepFrequency, filled, find_heel_strikes, step_frequency
from stages.imu.trial.events import step_period as period_of
from stages.imu.trial.evidence import (
    Evidence,
    agreement_of,
    gravity_of,
    lever_of,
    skewness,
    spacing_of,
    symmetry_of,
    turning_of,
)
from stages.imu.trial.frames import Frame, find_frame
from stages.imu.trial.judgement import Refusal, Verdict, refusals_of, verdict_on
from stages.imu.trial.leg_motion import LegMotion, leg_angle, leg_motion, nothing
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
    leg: LegMotion
    evidence: Evidence
    verdict: Verdict

    @property
    def accepted(self) -> bool:
        """Whether the run is used, with or without remarks."""
        return self.verdict.accepted

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
            evidence=self.evidence,
            verdict=self.verdict.outcome,
            reason="; ".join(self.verdict.sentences(refused=True)),
            remarks=self.verdict.sentences(refused=False),
            not_trusted=self.verdict.not_trusted,
            accepted=self.accepted,
        )


def read_trial(
    experiment: Experiment, recordings: tuple[Recording, ...], parameters: Parameters
) -> Trial:
    """Take one run from raw rows to registered strides and a verdict."""
    settings, limits = parameters.settings, parameters.limits
    sensors: dict[str, BodySensor] = {}
    reports, left_out = [], []
    for recording in recordings:
        sensor, report, refusals = read_sensor(recording, settings, limits)
        reports.append(report)
        place = place_of(recording.device)
        if place not in PLACES:
            why = f"the sensor at {printable(recording.device.place)} is not used: not hip or foot"
            left_out.append(Refusal(False, why))
        elif place in sensors:
            left_out.append(Refusal(False, f"a second sensor at the {place} is not used"))
        elif sensor is None or not report.accepted:
            why = f"the {place}'s sensor is not used: {'; '.join(report.reasons)}"
            left_out.append(Refusal(any(one.meaning for one in refusals), why))
        else:
            sensors[place] = sensor
    lag, at_edge, lever, overlap = math.nan, False, math.nan, math.nan
    if len(sensors) == 2:
        lag, at_edge = foot_lag(sensors, settings)
        sensors["foot"] = dataclasses.replace(sensors["foot"], time=sensors["foot"].time - lag)
        if all(sensor.trace.clock.stamp != "none" for sensor in sensors.values()):
            overlap = overlap_of(sensors["hip"].time, sensors["foot"].time)
        lever = lever_arm(sensors, settings)
    strikes = strikes_of(sensors, settings)
    used = HeelStrikes(strikes.time[settings.skipped_steps :], strikes.leg[settings.skipped_steps :])
    bounds, frequency = stride_bounds(used), step_frequency(used)
    evidence = evidence_of(sensors, strikes, bounds, experiment, settings)
    judged = {place: (sensor.trace, sensor.frame) for place, sensor in sensors.items()}
    return Trial(
        experiment=experiment,
        sensors=sensors,
        reports=tuple(reports),
        foot_lag=lag,
        lever_arm=lever,
        overlap=overlap,
        strikes=strikes,
        frequency=frequency,
        bounds=bounds,
        strides=registered(sensors, bounds, settings),
        leg=leg_of(sensors, used, parameters),
        evidence=evidence,
        verdict=verdict_on(
            experiment, judged, left_out, overlap, lever, at_edge, len(strikes.time), frequency.value, evidence,
            settings, limits,
        ),
    )  # fmt: skip


def place_of(device: Device) -> str:
    """Where a sensor rides, in lower case."""
    return device.place.strip().lower()


def read_sensor(
    recording: Recording, settings: Settings, limits: Limits
) -> tuple[BodySensor | None, SensorReport, tuple[Refusal, ...]]:
    """One sensor in body axes (None where no frame can be found), with its report and what speaks against it."""
    missing = int((~np.isfinite(np.hstack((recording.acceleration, recording.angular_rate)))).sum())
    trace = trace_sensor(recording, settings)
    frame = frame_of(trace, settings)
    refusals = tuple(refusals_of(trace, frame, settings, limits))
    report = report_sensor(trace, frame, settings, refusals, recording.experiment.name, recording.rows, missing)
    if frame is None:
        return None, report, refusals
    rate = trace.angular_rate - trace.bias()
    turn = frame.rotation.T
    return BodySensor(trace, frame, trace.time, trace.specific_force @ turn, rate @ turn), report, refusals


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


def foot_lag(sensors: dict[str, BodySensor], settings: Settings) -> tuple[float, bool]:
    """How much later the foot's rate shows what the hip's shows [s], and whether that is more than was searched.

    Both ride on one leg and turn as one. Stamps first: only lags within half a step are tried. Least difference of the
    two, refined by a parabola where it lies between lags that were tried; at an end of the search it is left there.
    """
    grid = common_grid(sensors, settings)
    if len(grid) < 3 * settings.grid_rate_hz:
        return 0.0, False
    hip, foot = (filled(on_grid(sensors[place], grid, settings)[:, 3 + LATERAL]) for place in PLACES)
    dt = 1 / settings.grid_rate_hz
    period = period_of(hip, dt, (settings.slowest_step_hz, settings.fastest_step_hz))
    if not math.isfinite(period):
        return 0.0, False
    reach = max(2, int(0.5 * period / dt))
    lags = np.arange(-reach, reach + 1)
    inner = slice(reach, len(grid) - reach)
    error = np.array([np.mean((hip[inner] - np.roll(foot, -lag)[inner]) ** 2) for lag in lags])
    best = int(np.argmin(error))
    if not 0 < best < len(lags) - 1:
        return float(lags[best] * dt), True
    left, middle, right = error[best - 1 : best + 2]
    curvature = left - 2 * middle + right
    return float((lags[best] + (0.5 * (left - right) / curvature if curvature > 0 else 0.0)) * dt), False


def evidence_of(
    sensors: dict[str, BodySensor],
    strikes: HeelStrikes,
    bounds: np.ndarray,
    experiment: Experiment,
    settings: Settings,
) -> Evidence:
    """What the run's signals say about themselves."""
    agreement, ratio, direction, fit, scale = (math.nan,) * 5
    grid = common_grid(sensors, settings) if sensors else np.empty(0)
    seen = {place: on_grid(sensor, grid, settings) for place, sensor in sensors.items()}
    if len(sensors) == 2:
        agreement, ratio = agreement_of(*(seen[place][:, 3 + LATERAL] for place in PLACES))
        direction, fit, scale = lever_of(grid, seen["hip"], seen["foot"], strikes, settings.grid_rate_hz)
    turning, symmetry, gravity = {}, {}, {}
    for place, sensor in sensors.items():
        turning[place] = turning_of(sensor.force, sensor.rate, sensor.trace.rate_hz)
        if not len(bounds) or not len(grid):
            continue
        angle = angle_on(grid, place, seen, sensor, settings)
        symmetry[place] = symmetry_of(np.interp(strikes.time, grid, angle), strikes)
        size, downhill = gravity_of(grid, seen[place][:, :3], angle, (bounds[0, 0], bounds[-1, 1]))
        gravity[place] = size / settings.gravity, math.degrees(downhill) - (experiment.slope_deg or 0.0)
    first = next((place for place in PLACES if place in sensors), "")
    spacing, alternating = spacing_of(strikes)
    return Evidence(
        agreement=agreement,
        rate_ratio=ratio,
        lever_direction_deg=direction,
        lever_fit=fit,
        rate_scale=scale,
        third_moment=skewness(sensors[first].rate[~sensors[first].trace.rest, LATERAL]) if first else math.nan,
        hip_turning=turning.get("hip", math.nan),
        foot_turning=turning.get("foot", math.nan),
        strike_symmetry_deg=symmetry.get(first, math.nan),
        hip_gravity=gravity.get("hip", (math.nan, math.nan))[0],
        foot_gravity=gravity.get("foot", (math.nan, math.nan))[0],
        hip_gravity_deg=gravity.get("hip", (math.nan, math.nan))[1],
        foot_gravity_deg=gravity.get("foot", (math.nan, math.nan))[1],
        spacing=spacing,
        alternating=alternating,
    )


def leg_of(sensors: dict[str, BodySensor], strikes: HeelStrikes, parameters: Parameters) -> LegMotion:
    """The leg's motion from the rates of all sensors, where several see it from their mean."""
    settings = parameters.settings
    first = next((place for place in PLACES if place in sensors), None)
    grid = common_grid(sensors, settings) if sensors else np.empty(0)
    if first is None or len(grid) < 2:
        return nothing()
    seen = {place: on_grid(sensor, grid, settings) for place, sensor in sensors.items()}
    angles = [angle_on(grid, place, seen, sensor, settings) for place, sensor in sensors.items()]
    errors = [bias_error(sensor) for sensor in sensors.values()]
    return leg_motion(
        grid,
        np.mean(angles, axis=0),
        math.radians(settings.rest_leg_angle_deg),
        math.sqrt(sum(error**2 for error in errors)) / len(errors),
        len(sensors),
        strikes,
        parameters.drawing,
    )


def bias_error(sensor: BodySensor) -> float:
    """Standard error of a sensor's lateral bias, from the scatter of its still stand [rad/s]; 0 without one."""
    still = sensor.rate[sensor.trace.rest, LATERAL]
    still = still[np.isfinite(still)]
    return float(np.std(still) / math.sqrt(len(still))) if len(still) else 0.0


def angle_on(
    grid: np.ndarray, place: str, seen: dict[str, np.ndarray], sensor: BodySensor, settings: Settings
) -> np.ndarray:
    """The leg's angle on a grid (m,) [rad] from the rate at a place; the other place, on the same leg, fills holes."""
    rate = seen[place][:, 3 + LATERAL]
    for other in seen.values():
        rate = np.where(np.isfinite(rate), rate, other[:, 3 + LATERAL])
    still = sensor.time[sensor.trace.rest]
    rest = (grid >= still[0]) & (grid <= still[-1]) if len(still) else np.zeros(len(grid), dtype=bool)
    return leg_angle(grid, rate, rest, math.radians(settings.rest_leg_angle_deg))


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
