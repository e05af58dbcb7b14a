"""One sensor of a run judged and turned into the body's axes."""

from __future__ import annotations

import math

import numpy as np

from stages.imu.judgement.of_sensor import refusals_of
from stages.imu.judgement.verdict import Refusal
from stages.imu.parameters import Limits, Settings
from stages.imu.reports.sensor_report import SensorReport, report_sensor
from stages.imu.sources.schema import Device, Recording
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
