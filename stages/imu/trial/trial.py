"""One run: its sensors judged, turned into the body's axes, synchronised and cut at heel strikes."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stages.imu.judgement.evidence import confirmed, evidence_of
from stages.imu.judgement.rules import against_sensor, verdict_on
from stages.imu.judgement.sensor_evidence import (
    batch_sizes,
    dead_axes,
    declared_rate_unit,
    leg_sweep,
    quantisation_step,
)
from stages.imu.judgement.verdict import Finding, Verdict
from stages.imu.parameters import Limits, Parameters, Settings
from stages.imu.result import Evidence, FrameFit, LegMotion, RunReport, SensorReport
from stages.imu.sources.opening import printable
from stages.imu.sources.schema import Experiment, Recording
from stages.imu.sources.units import implied_acceleration_unit, implied_angular_rate_unit
from stages.imu.strikes.step_times import HeelStrikes, step_frequency, stride_bounds
from stages.imu.trial.body import PLACES, BodySensor, frame_of, grid_signals
from stages.imu.trial.sensor import SensorTrace, part_of, trace_sensor, walks_in
from stages.imu.trial.two_clocks import Together, brought_together, overlap_of
from stages.imu.trial.walk import at_slowest, leg_of, registered, strikes_of


def read_sensor(
    trace: SensorTrace, settings: Settings, limits: Limits
) -> tuple[BodySensor | None, SensorReport, tuple[Finding, ...]]:
    """One sensor in body axes (None where no frame can be found), with its report and what speaks against it."""
    recording = trace.indexed.recording
    missing = int((~np.isfinite(np.hstack((recording.acceleration, recording.angular_rate)))).sum())
    frame = frame_of(trace, settings)
    indexed, clock, device = trace.indexed, trace.clock, trace.indexed.recording.device
    reading, batches = trace.static_reading(), batch_sizes(indexed)
    report = SensorReport.of(
        indexed, clock, frame or FrameFit(math.nan, math.nan, math.nan),
        run=indexed.recording.experiment.name,
        place=device.place,
        bandwidth_hz=math.nan if device.bandwidth_hz is None else device.bandwidth_hz,
        rows=recording.rows + indexed.exact_duplicates + indexed.sent_again + indexed.key_duplicates
        + indexed.unusable_rows,
        smallest_batch=int(batches.min(initial=indexed.batch_size)),
        largest_batch=int(batches.max(initial=0)),
        clock_settings=len(clock.settings),
        missing_values=missing,
        dead_axes=dead_axes(trace),
        clipped_acceleration=trace.clipped_acceleration,
        clipped_angular_rate=trace.clipped_angular_rate,
        acceleration_step=quantisation_step(indexed.recording.acceleration) * trace.scale.acceleration,
        angular_rate_step=quantisation_step(indexed.recording.angular_rate) * trace.scale.angular_rate,
        rest_s=float(trace.rest.sum() / clock.rate_hz) if clock.rate_hz > 0 else math.nan,
        static_reading=reading,
        static_gain=reading * trace.scale.acceleration / settings.gravity,
        acceleration_unit=implied_acceleration_unit(reading, device, settings.gravity),
        angular_rate_unit=implied_angular_rate_unit(
            leg_sweep(trace, settings.slowest_stride_hz), declared_rate_unit(device.gyroscope_unit)),
        accepted=False,
        reasons=(),
    )
    against = against_sensor(trace, report, settings, limits)
    why = tuple(one.sentence for one in against)
    if frame is None:
        why = why or ("no still stand: the frame cannot be found",)
        return None, replace(report, reasons=why), against
    turn = frame.rotation.T
    rate = (trace.angular_rate - trace.bias()) @ turn
    sensor = BodySensor(trace, frame, trace.time, trace.specific_force @ turn, rate)
    return sensor, replace(report, accepted=not why, reasons=why), against


@dataclass(frozen=True)
class Trial:
    """One run, ready to be compared.

    `together` says by how much the foot's stamps were late against the hip's, which is taken out; `frequency` is that
    of the steps, with its standard error [Hz].
    `strides` (s, p, 6) are the registered signals in the order of `SENSOR_SIGNALS`.
    """

    experiment: Experiment
    sensors: dict[str, BodySensor]
    reports: tuple[SensorReport, ...]
    together: Together
    overlap: float
    strikes: HeelStrikes
    frequency: tuple[float, float]
    strides: np.ndarray
    leg: LegMotion
    evidence: Evidence
    verdict: Verdict = Verdict()

    @property
    def accepted(self) -> bool:
        """Whether the run is used, with or without remarks."""
        return self.verdict.accepted

    def report(self) -> RunReport:
        """What the run is worth."""
        slope, leg, none = self.experiment.slope_deg, self.leg, not len(self.leg.step_length)
        return RunReport(
            name=self.experiment.name,
            origin=self.experiment.origin,
            slope_deg=math.nan if slope is None else slope,
            overlap=self.overlap,
            foot_lag=self.together.lag,
            foot_lag_error=self.together.lag_error,
            heel_strikes=len(self.strikes.time),
            strides=len(self.strides),
            step_frequency=self.frequency[0],
            step_frequency_error=self.frequency[1],
            step_length=math.nan if none else float(leg.step_length.mean()),
            step_length_error=math.nan if none else float(leg.step_length_error.mean()),
            step_length_drawing_error=math.nan if none else float(leg.step_length_drawing_error.mean()),
            times=leg.times,
            evidence=self.evidence,
            verdict=self.verdict.outcome,
            reason="; ".join(self.verdict.sentences(refused=True)),
            remarks=self.verdict.sentences(refused=False),
            not_trusted=self.verdict.not_trusted,
            accepted=self.accepted,
        )


def read_trials(
    experiment: Experiment, recordings: tuple[Recording, ...], parameters: Parameters
) -> Iterator[Trial]:
    """Take each walk of a run from raw rows to registered strides and a verdict.

    Sensors may have clocks of their own, so that the first walk of one is the first of the other.
    """
    settings = parameters.settings
    traces = [trace_sensor(recording, settings) for recording in recordings]
    walks = [walks_in(trace, settings, parameters.limits) for trace in traces]
    count = max(map(len, walks), default=0)
    if count > 1 and any(len(one) not in (0, count) for one in walks):
        counts = " and ".join(str(len(one)) for one in walks)
        uneven = f"the sensors show {counts} walks: give each walk a run of its own"
        yield _trial(experiment, traces, parameters, [Finding(True, (), uneven)])
        return
    for number in range(max(count, 1)):
        name = f"{experiment.name}, walk {number + 1} of {count}" if count > 1 else experiment.name
        mine = replace(experiment, name=name)
        parts = [part_of(trace, one[number] if one else slice(None), mine, settings)
                 for trace, one in zip(traces, walks)]
        out = max((1.0 - len(part.time) / len(trace.time) for part, trace in zip(parts, traces) if len(trace.time)),
                  default=0.0)
        why = f"{out:.0%} of the recording is left out, as not of this walk and the stand before it"
        yield _trial(mine, parts, parameters, [Finding(False, (), why)] if out > 0.0 else [])


def _trial(
    experiment: Experiment, traces: Sequence[SensorTrace], parameters: Parameters, left_out: list[Finding]
) -> Trial:
    """One walk, from what its sensors show, and what is known against it."""
    settings, limits = parameters.settings, parameters.limits
    sensors: dict[str, BodySensor] = {}
    reports: list[SensorReport] = []
    for trace in traces:
        sensor, report, against = read_sensor(trace, settings, limits)
        reports.append(report)
        place, believed = trace.indexed.recording.device.place.strip().lower(), True
        if place not in PLACES:
            why = f"the sensor at {printable(trace.indexed.recording.device.place)} is not used: not hip or foot"
        elif place in sensors:
            why = f"a second sensor at the {place} is not used"
        elif sensor is None or not report.accepted:
            why = f"the {place}'s sensor is not used: {'; '.join(report.reasons)}"
            believed = not any(one.refused for one in against)
        else:
            sensors[place] = sensor
            continue
        left_out.append(Finding(not believed, (), why))
    together = brought_together(sensors, settings, limits)
    sensors = together.sensors
    timed = len(sensors) == 2 and all(sensor.trace.clock.stamp != "none" for sensor in sensors.values())
    strikes, corner = strikes_of(sensors, settings, parameters.quick)
    used = HeelStrikes(strikes.time[settings.skipped_steps :], strikes.leg[settings.skipped_steps :])
    bounds, common = stride_bounds(used), grid_signals(sensors, settings)
    dated_by = next((sensors[place].trace.rate_error for place in PLACES if place in sensors), 0.0)
    evidence = evidence_of(sensors, common, strikes, bounds, experiment.slope_deg, parameters)
    drawing = at_slowest(sensors, parameters, evidence.hidden_strikes)
    trial = Trial(
        experiment=experiment,
        sensors=sensors,
        reports=tuple(reports),
        together=together,
        overlap=overlap_of(sensors["hip"], sensors["foot"]) if timed else math.nan,
        strikes=strikes,
        frequency=step_frequency(used, drawing.strike_scatter_s, dated_by),
        strides=registered(sensors, bounds, settings),
        leg=leg_of(sensors, common, used, corner, confirmed(evidence, parameters), drawing, parameters),
        evidence=evidence,
    )
    return replace(trial, verdict=verdict_on(trial, left_out, parameters))
