"""Numbers of the claims on sensors and measurements."""

from __future__ import annotations

import math

import numpy as np

from stages.biped.walk import SENSOR_SIGNALS
from stages.comparison.claims import measurement
from stages.comparison.claims.paper import STANDARD_GRAVITY
from stages.comparison.evidence import studies
from stages.comparison.evidence.evidence import NAN, Evidence
from stages.comparison.measurement import MeasurementAgreement


def sensor_range(e: Evidence) -> measurement.SensorRange:
    force = e.results.contact_study.variations.peak_force
    known = force[np.isfinite(force)]
    spread = (float(known.min()), float(known.max())) if len(known) else (NAN, NAN)
    behind = [run.hip.peak_filtered for run in e.results.campaign.runs]
    return measurement.SensorRange(
        e.twin.peak_specific_force / STANDARD_GRAVITY,
        e.twin.peak_foot_specific_force / STANDARD_GRAVITY,
        math.degrees(e.twin.peak_rate),
        e.twin.time_above_range,
        1 / e.twin.step_frequency,
        spread,
        float(np.median(behind)) / STANDARD_GRAVITY if behind else NAN,
    )


def encloses(measured: MeasurementAgreement) -> measurement.MeasurementEncloses:
    shares = tuple(measured.twin[name].envelope_share for name in SENSOR_SIGNALS[:3])
    return measurement.MeasurementEncloses(measured.origin, measured.runs, shares)


def slower(measured: MeasurementAgreement) -> measurement.MeasurementSlower:
    interval = measured.twin_frequency
    return measurement.MeasurementSlower(
        measured.origin, measured.step_frequency, measured.twin_step_frequency, interval.lower, interval.upper
    )


def outsole_slows(e: Evidence) -> measurement.OutsoleSlows:
    layer, usual = e.results.analytic.outsole, e.results.analytic.gait.step_frequency_hz
    return measurement.OutsoleSlows(
        layer.thickness,
        layer.frequency_without_mass / usual - 1,
        layer.frequency_with_mass / usual - 1,
        layer.mass,
        layer.turning_mass,
    )


def push_slows(e: Evidence) -> measurement.PushSlows:
    frequencies = {run.report.name: run.report.step_frequency for run in e.results.imu.runs}
    found = studies.pushes_and_frequency(e.results.campaign.runs, frequencies)
    return measurement.PushSlows(e.measured.origin, len(frequencies), *found)
