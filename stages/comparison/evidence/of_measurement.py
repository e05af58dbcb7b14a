"""Numbers of the claims on sensors and measurements."""

from __future__ import annotations

import math

import numpy as np

from stages.biped.walk import SENSOR_SIGNALS
from stages.comparison.claims.of_runs import leg_motion, measurement
from stages.comparison.claims.paper import STANDARD_GRAVITY
from stages.comparison.evidence import studies
from stages.comparison.evidence.evidence import NAN, Evidence


def sensor_range(e: Evidence) -> measurement.SensorRange:
    known = [one for one in e.results.campaign.spikes if math.isfinite(one.hip_peak)]
    peaks = tuple(one.hip_peak / STANDARD_GRAVITY for one in known)
    behind = [run.hip.peak_filtered for run in e.results.campaign.runs]
    return measurement.SensorRange(
        e.twin.peak_specific_force / STANDARD_GRAVITY,
        e.twin.peak_foot_specific_force / STANDARD_GRAVITY,
        math.degrees(e.twin.peak_rate),
        e.twin.time_above_range,
        1 / e.twin.step_frequency,
        (min(peaks, default=NAN), max(peaks, default=NAN)),
        (min((one.time_above_range for one in known), default=NAN),
         max((one.time_above_range for one in known), default=NAN)),
        float(np.median(behind)) / STANDARD_GRAVITY if behind else NAN,
    )  # fmt: skip


def hip_path_drifts(e: Evidence) -> leg_motion.HipPathDrifts:
    legs, seen = e.ingest.leg if e.ingest is not None else None, e.measured.leg
    lengths = (NAN,) * 4
    if seen is not None:
        lengths = seen.runs.step_length, seen.step_length_error, seen.twin.step_length, seen.simple.step_length
    truth = (NAN,) * 4
    if legs is not None:
        truth = (float(np.mean(legs.way)), _rms(legs.twice), _rms(legs.step), _rms(legs.angle))
    return leg_motion.HipPathDrifts(e.measured.origin, *truth, *lengths)


def _rms(errors: np.ndarray) -> float:
    known = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else NAN


def encloses(e: Evidence) -> measurement.MeasurementEncloses:
    measured = e.measured
    shares = tuple(measured.twin[name].envelope_share for name in SENSOR_SIGNALS[:3])
    return measurement.MeasurementEncloses(measured.origin, measured.runs, shares)


def slower(e: Evidence) -> measurement.MeasurementSlower:
    measured = e.measured
    interval = measured.twin_frequency
    return measurement.MeasurementSlower(
        measured.origin, measured.step_frequency, measured.twin_step_frequency, interval.lower, interval.upper
    )


def push_slows(e: Evidence) -> measurement.PushSlows:
    frequencies = {run.report.name: run.report.step_frequency for run in e.results.imu.runs}
    found = studies.pushes_and_frequency(e.results.campaign.runs, frequencies)
    return measurement.PushSlows(e.measured.origin, len(frequencies), *found)
