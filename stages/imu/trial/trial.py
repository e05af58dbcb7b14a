"""One run: its sensors judged, turned into the body's axes, synchronised and cut at heel strikes."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from stages.imu.errors import printable
from stages.imu.judgement.of_run import verdict_on
from stages.imu.judgement.verdict import Refusal, Verdict
from stages.imu.parameters import Reading
from stages.imu.reports.run_report import Evidence, RunReport
from stages.imu.reports.sensor_report import SensorReport
from stages.imu.result import LegMotion
from stages.imu.sources.schema import Experiment, Recording
from stages.imu.strikes.landings import HeelStrikes, stride_bounds
from stages.imu.strikes.step_times import StepFrequency, step_frequency
from stages.imu.trial.own_clocks import brought_together, have_own_clocks
from stages.imu.trial.places import PLACES, BodySensor, foot_lag, lever_arm, overlap_of
from stages.imu.trial.sensor_on_body import place_of, read_sensor
from stages.imu.trial.trial_evidence import evidence_of
from stages.imu.trial.walking import leg_of, registered, strikes_of


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
            step_length=float(self.leg.step_length.mean()) if len(self.leg.step_length) else math.nan,
            step_length_error=float(self.leg.step_length_error.mean()) if len(self.leg.step_length) else math.nan,
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
    lag, at_edge, lever, overlap = math.nan, False, math.nan, math.nan
    if have_own_clocks(sensors):
        sensors = brought_together(sensors, settings)
    if len(sensors) == 2:
        lag, at_edge = foot_lag(sensors, settings)
        sensors["foot"] = dataclasses.replace(sensors["foot"], time=sensors["foot"].time - lag)
        if all(sensor.trace.clock.stamp != "none" for sensor in sensors.values()):
            overlap = overlap_of(sensors["hip"].time, sensors["foot"].time)
        lever = lever_arm(sensors, settings)
    strikes, corner = strikes_of(sensors, settings, parameters.quick)
    used = HeelStrikes(strikes.time[settings.skipped_steps :], strikes.leg[settings.skipped_steps :])
    bounds, frequency = stride_bounds(used), step_frequency(used)
    evidence = evidence_of(sensors, strikes, bounds, experiment, settings, parameters.quick)
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
        leg=leg_of(sensors, used, corner, parameters),
        evidence=evidence,
        verdict=verdict_on(
            experiment, judged, left_out, overlap, lever, at_edge, len(strikes.time), frequency.value, evidence,
            settings, limits,
        ),
    )  # fmt: skip
