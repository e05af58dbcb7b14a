"""One run: its sensors judged, turned into the body's axes, synchronised and cut at heel strikes."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from stages.imu.clock.resample import resample
from stages.imu.errors import printable
from stages.imu.judgement.evidence import (
    agreement_of,
    axis_turn_of,
    gravity_of,
    lever_of,
    skewness,
    spacing_of,
    symmetry_of,
)
from stages.imu.judgement.of_run import verdict_on
from stages.imu.judgement.rolling_stance import confirmed, swept
from stages.imu.judgement.verdict import Refusal, Verdict
from stages.imu.parameters import Reading
from stages.imu.reports.run_report import Evidence, RunReport
from stages.imu.reports.sensor_report import SensorReport
from stages.imu.result import LegMotion
from stages.imu.sources.schema import Experiment, Recording
from stages.imu.strikes.heel_strikes import PULSE_S, SHIFTS_S, in_hole
from stages.imu.strikes.step_times import HeelStrikes, StepFrequency, stances_of, step_frequency, stride_bounds
from stages.imu.trial.places import (
    FORWARD,
    LATERAL,
    PLACES,
    BodySensor,
    angle_on,
    common_grid,
    longest_step,
    on_grid,
    overlap_of,
)
from stages.imu.trial.sensor_on_body import place_of, read_sensor
from stages.imu.trial.two_clocks import brought_together
from stages.imu.trial.walking import leg_of, registered, strikes_of


def evidence_of(
    sensors: dict[str, BodySensor],
    strikes: HeelStrikes,
    bounds: np.ndarray,
    experiment: Experiment,
    parameters: Reading,
) -> Evidence:
    """What the run's signals say about themselves, by all strikes and the strides between these bounds."""
    settings, drawing, quick = parameters.settings, parameters.drawing, parameters.quick
    found = dict.fromkeys((field.name for field in fields(Evidence)), math.nan)
    grid = common_grid(sensors, settings) if sensors else np.empty(0)
    seen = {place: on_grid(sensor, grid, settings) for place, sensor in sensors.items()}
    if len(sensors) == 2:
        found["agreement"], found["rate_ratio"] = agreement_of(*(seen[place][:, 3 + LATERAL] for place in PLACES))
        names = ("lever_arm", "lever_direction_deg", "forward_gain", "hip_turning", "foot_turning", "rate_lag")
        found |= zip(names, lever_of(grid, seen["hip"], seen["foot"], strikes, settings.grid_rate_hz, quick))
    first = next((place for place in PLACES if place in sensors), "")
    slope, stances = math.radians(experiment.slope_deg or 0.0), stances_of(strikes)
    for place, sensor in sensors.items():
        found[f"{place}_axis_deg"] = axis_turn_of(sensor.rate[~sensor.trace.rest])
        if not len(bounds) or not len(grid):
            continue
        angle = angle_on(grid, place, seen, sensor, settings)
        arm = drawing.leg_length - (parameters.limits.lever_arm if place == "foot" else drawing.sag)
        gain, error, height, apart = swept(
            grid, seen[place][:, FORWARD], seen[place][:, 3 + LATERAL], angle, stances, slope, settings.gravity, arm,
            drawing.foot_radius, quick)  # fmt: skip
        size, downhill = gravity_of(grid, seen[place][:, :3], angle, (bounds[0, 0], bounds[-1, 1]))
        own = {"gain": gain, "gain_error": error, "arm": height / arm, "pitch_deg": math.degrees(apart),
               "gravity": size / settings.gravity, "gravity_deg": math.degrees(downhill - slope)}  # fmt: skip
        found |= {f"{place}_{name}": value for name, value in own.items()}
        if place == first:
            found["strike_symmetry_deg"] = symmetry_of(np.interp(strikes.time, grid, angle), strikes)
    found["spacing"], found["alternating"] = spacing_of(strikes)
    if first:
        sensor = sensors[first]
        found["third_moment"] = skewness(sensor.rate[~sensor.trace.rest, LATERAL])
        # Among samples that are there: one at full scale shows a strike.
        there = resample(sensor.time, np.zeros((len(sensor.time), 1)), grid, longest_step(sensor, settings))
        reach = max(1, round((0.75 * PULSE_S + SHIFTS_S[-1]) / quick * settings.grid_rate_hz))  # as far as one is moved
        hidden = in_hole(there, np.searchsorted(grid, strikes.time), reach)
        found["hidden_strikes"] = float(hidden.mean()) if len(hidden) else math.nan
    return Evidence(**found)


@dataclass(frozen=True)
class Trial:
    """One run, ready to be compared.

    `foot_lag` is what the foot's stamps were late against the hip's [s], taken out (`two_clocks.py`),
    NaN without both sensors.
    `strides` (s, p, 6) are the registered signals in the order of `SENSOR_SIGNALS`.
    """

    experiment: Experiment
    sensors: dict[str, BodySensor]
    reports: tuple[SensorReport, ...]
    foot_lag: float
    foot_lag_error: float
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
            foot_lag_error=self.foot_lag_error,
            heel_strikes=len(self.strikes.time),
            strides=len(self.strides),
            step_frequency=self.frequency.value,
            step_frequency_error=self.frequency.standard_error,
            step_length=float(self.leg.step_length.mean()) if len(self.leg.step_length) else math.nan,
            step_length_error=float(self.leg.step_length_error.mean()) if len(self.leg.step_length) else math.nan,
            step_length_drawing_error=(
                float(self.leg.step_length_drawing_error.mean()) if len(self.leg.step_length) else math.nan),
            times=self.leg.times,
            evidence=self.evidence,
            verdict=self.verdict.outcome,
            reason="; ".join(self.verdict.sentences(refused=True)),
            remarks=self.verdict.sentences(refused=False),
            not_trusted=self.verdict.not_trusted,
            accepted=self.accepted,
        )


def read_trial(
    experiment: Experiment, recordings: tuple[Recording, ...], parameters: Reading
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
    overlap = math.nan
    together = brought_together(sensors, settings, limits)
    sensors = together.sensors
    if len(sensors) == 2 and all(sensor.trace.clock.stamp != "none" for sensor in sensors.values()):
        overlap = overlap_of(sensors["hip"], sensors["foot"])
    strikes, corner = strikes_of(sensors, settings, parameters.quick)
    used = HeelStrikes(strikes.time[settings.skipped_steps :], strikes.leg[settings.skipped_steps :])
    bounds, frequency = stride_bounds(used), step_frequency(used)
    evidence = evidence_of(sensors, strikes, bounds, experiment, parameters)
    judged = {place: (sensor.trace, sensor.frame) for place, sensor in sensors.items()}
    return Trial(
        experiment=experiment,
        sensors=sensors,
        reports=tuple(reports),
        foot_lag=together.lag,
        foot_lag_error=together.lag_error,
        overlap=overlap,
        strikes=strikes,
        frequency=frequency,
        bounds=bounds,
        strides=registered(sensors, bounds, settings),
        leg=leg_of(sensors, used, corner, confirmed(evidence, parameters), parameters),
        evidence=evidence,
        verdict=verdict_on(
            experiment, judged, left_out, overlap, together.at_edge, together.other_lag, len(strikes.time),
            frequency.value, evidence, parameters,
        ),
    )  # fmt: skip
