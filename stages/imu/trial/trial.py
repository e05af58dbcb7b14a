"""One run: its sensors judged, turned into the body's axes, synchronised and cut at heel strikes."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from stages.biped.walk import SENSOR_SIGNALS
from stages.imu.errors import printable
from stages.imu.judgement.evidence import (
    Evidence,
    agreement_of,
    gravity_of,
    lever_of,
    skewness,
    spacing_of,
    symmetry_of,
    turning_of,
)
from stages.imu.judgement.of_run import verdict_on
from stages.imu.judgement.of_sensor import refusals_of
from stages.imu.judgement.verdict import Refusal, Verdict
from stages.imu.parameters import Limits, Parameters, Settings
from stages.imu.sources.schema import Device, Experiment, Recording
from stages.imu.trial.events import NO_STRIKES, HeelStrikes, StepFrequency, find_heel_strikes, step_frequency
from stages.imu.trial.frames import Frame, find_frame
from stages.imu.trial.leg_motion import LegMotion, leg_motion, nothing
from stages.imu.trial.places import (
    FORWARD,
    LATERAL,
    PLACES,
    UP,
    BodySensor,
    angle_on,
    bias_error,
    common_grid,
    foot_lag,
    lever_arm,
    longest_step,
    on_grid,
    overlap_of,
)
from stages.imu.trial.registration import register, stride_bounds
from stages.imu.trial.report import SensorReport, report_sensor
from stages.imu.trial.run_report import RunReport
from stages.imu.trial.sensor import SensorTrace, trace_sensor


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
