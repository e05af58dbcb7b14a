"""One sensor of a run judged and turned into the body's axes."""

from __future__ import annotations

import math

import numpy as np

from stages.imu.judgement.of_sensor import refusals_of
from stages.imu.judgement.sensor_evidence import (
    angular_rate_unit,
    batch_sizes,
    dead_axes,
    quantisation_step,
    static_reading,
)
from stages.imu.judgement.verdict import Refusal
from stages.imu.parameters import Limits, Settings
from stages.imu.reports.sensor_report import NOT_OBSERVABLE, SensorReport
from stages.imu.sources.schema import Device, Recording
from stages.imu.sources.units import implied_acceleration_unit
from stages.imu.trial.frames import Frame, find_frame
from stages.imu.trial.places import BodySensor
from stages.imu.trial.sensor import SensorTrace, trace_sensor


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


def report_sensor(
    trace: SensorTrace,
    frame: Frame | None,
    settings: Settings,
    refusals: tuple[Refusal, ...],
    run: str,
    rows: int,
    missing: int,
) -> SensorReport:
    """What one recording is worth; `rows` and `missing` are counted in the source, before any repair."""
    indexed, clock, device = trace.indexed, trace.clock, trace.indexed.recording.device
    reading = static_reading(trace)
    unit = implied_acceleration_unit(reading, device, settings.gravity)
    batches = batch_sizes(indexed)
    refused = tuple(one.sentence for one in refusals)
    remarks = () if frame is not None or refused else ("no still stand: the frame cannot be found",)
    return SensorReport(
        run=run,
        place=device.place,
        bandwidth_hz=math.nan if device.bandwidth_hz is None else device.bandwidth_hz,
        rows=rows,
        exact_duplicates=indexed.exact_duplicates,
        sent_again=indexed.sent_again,
        key_duplicates=indexed.key_duplicates,
        out_of_order=indexed.out_of_order,
        unusable_rows=indexed.unusable_rows,
        lost_packets=NOT_OBSERVABLE if indexed.lost_packets is None else indexed.lost_packets,
        gaps=indexed.gaps,
        resets=indexed.resets,
        batch_size=indexed.batch_size,
        smallest_batch=int(batches.min(initial=indexed.batch_size)),
        largest_batch=int(batches.max(initial=0)),
        stamp=clock.stamp,
        rate_hz=clock.rate_hz,
        rate_ppm=clock.rate_ppm,
        numbered_by=indexed.numbered_by,
        clock_settings=len(clock.settings),
        clock_bend_s=clock.bend,
        robust_ppm=clock.robust_ppm,
        jitter_before_s=clock.jitter_before,
        clock_error_s=clock.error,
        missing_values=missing,
        dead_axes=dead_axes(trace),
        clipped_acceleration=trace.clipped_acceleration,
        clipped_angular_rate=trace.clipped_angular_rate,
        acceleration_step=quantisation_step(indexed.recording.acceleration) * trace.scale.acceleration,
        angular_rate_step=quantisation_step(indexed.recording.angular_rate) * trace.scale.angular_rate,
        rest_s=float(trace.rest.sum() / clock.rate_hz) if clock.rate_hz > 0 else math.nan,
        static_reading=reading,
        static_gain=reading * trace.scale.acceleration / settings.gravity,
        acceleration_unit=unit,
        angular_rate_unit=angular_rate_unit(trace, settings.slowest_stride_hz),
        swing_residual_deg=frame.swing_residual_deg if frame else math.nan,
        swing_share=frame.swing_share if frame else math.nan,
        mounting_deg=frame.mounting_deg if frame else math.nan,
        accepted=not refused and frame is not None,
        reasons=refused + remarks,
    )
