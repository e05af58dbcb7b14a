"""What a recording is worth, said before it is used."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
from stages.imu.clock.packet_index import IndexedRecording
from stages.imu.parameters import Settings
from stages.imu.sources.units import (
    agrees_with_gravity,
    implied_acceleration_unit,
    implied_angular_rate_unit,
    turning_ratio,
)
from stages.imu.trial.frames import Frame
from stages.imu.trial.sensor import SensorTrace

FEWEST_ROWS = 50
AXIS_NAMES = ("ax", "ay", "az", "gx", "gy", "gz")
NOT_OBSERVABLE = -1


@dataclass(frozen=True)
class SensorReport:
    """Faults and facts of one sensor in one run."""

    run: str = quantity("-", "experiment")
    place: str = quantity("-", "place of the sensor")
    bandwidth_hz: float = quantity("Hz", "cut-off of the sensor's low pass as declared; NaN where it is not")
    rows: int = quantity("1", "rows stored")
    exact_duplicates: int = quantity("1", "rows that repeat another in every column")
    key_duplicates: int = quantity("1", "rows that repeat the packet and position of another with other content")
    out_of_order: int = quantity("1", "rows stored after a later one")
    unusable_rows: int = quantity("1", "rows without packet number or stamp")
    lost_packets: int = quantity("1", "packets missing in the numbering; -1: loss cannot be observed without a counter")
    gaps: int = quantity("1", "holes in the sequence of samples")
    resets: int = quantity("1", "restarts of the packet counter")
    batch_size: int = quantity("1", "samples in a packet")
    smallest_batch: int = quantity("1", "fewest samples of a packet that arrived")
    largest_batch: int = quantity("1", "most samples of a packet that arrived")
    stamp: str = quantity("-", "stamp the clock was fitted to")
    rate_hz: float = quantity("Hz", "fitted sampling rate")
    rate_ppm: float = quantity("ppm", "fitted rate relative to the nominal one")
    robust_ppm: float = quantity("ppm", "rate of the robust cross-check relative to the fitted one")
    jitter_before_s: float = quantity("s", "rms of the stamps about a least-squares line")
    jitter_after_s: float = quantity("s", "rms disagreement of two clocks fitted to alternate packets")
    missing_values: int = quantity("1", "cells that are no number")
    dead_axes: tuple[str, ...] = quantity("-", "axes that never change")
    clipped_acceleration: int = quantity("1", "samples with an accelerometer axis at full scale")
    clipped_angular_rate: int = quantity("1", "samples with a gyroscope axis at full scale")
    acceleration_step: float = quantity("m/s^2", "quantisation step of the accelerometer")
    angular_rate_step: float = quantity("rad/s", "quantisation step of the gyroscope")
    rest_s: float = quantity("s", "length of the still stand")
    static_reading: float = quantity("1", "magnitude of the specific force at rest in the stored unit")
    static_gain: float = quantity("1", "magnitude of the specific force at rest over gravity, in the declared unit")
    acceleration_unit: str = quantity("-", "unit of acceleration the static reading implies")
    angular_rate_unit: str = quantity("-", "unit of angular rate the turning of gravity implies")
    swing_residual_deg: float = quantity("deg", "angle of the swing axis from normal to gravity")
    swing_share: float = quantity("1", "share of the angular motion about the swing axis")
    mounting_deg: float = quantity("deg", "angle of the frame found to the declared mounting")
    accepted: bool = quantity("1", "whether the recording is used")
    reasons: tuple[str, ...] = quantity("-", "why it is not, or what to bear in mind")


def report_sensor(
    trace: SensorTrace, frame: Frame | None, settings: Settings, run: str, rows: int, missing: int
) -> SensorReport:
    """Judge one recording; `rows` and `missing` are counted in the source, before any repair."""
    indexed, clock, device = trace.indexed, trace.clock, trace.indexed.recording.device
    reading = static_reading(trace)
    unit = implied_acceleration_unit(reading, device)
    rate_unit = angular_rate_unit(trace)
    raw = np.hstack((indexed.recording.acceleration, indexed.recording.angular_rate))
    dead = dead_axes(raw)
    batches = batch_sizes(indexed)
    refused = tuple(_refusals(trace, settings, dead, reading, unit, rate_unit))
    remarks = () if frame is not None or refused else ("no still stand: the frame cannot be found",)
    return SensorReport(
        run=run,
        place=device.place,
        bandwidth_hz=math.nan if device.bandwidth_hz is None else device.bandwidth_hz,
        rows=rows,
        exact_duplicates=indexed.exact_duplicates,
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
        robust_ppm=clock.robust_ppm,
        jitter_before_s=clock.jitter_before,
        jitter_after_s=clock.disagreement,
        missing_values=missing,
        dead_axes=dead,
        clipped_acceleration=trace.clipped_acceleration,
        clipped_angular_rate=trace.clipped_angular_rate,
        acceleration_step=quantisation_step(indexed.recording.acceleration) * trace.scale.acceleration,
        angular_rate_step=quantisation_step(indexed.recording.angular_rate) * trace.scale.angular_rate,
        rest_s=float(trace.rest.sum() / clock.rate_hz) if clock.rate_hz > 0 else math.nan,
        static_reading=reading,
        static_gain=reading * trace.scale.acceleration / settings.gravity,
        acceleration_unit=unit,
        angular_rate_unit=rate_unit,
        swing_residual_deg=frame.swing_residual_deg if frame else math.nan,
        swing_share=frame.swing_share if frame else math.nan,
        mounting_deg=frame.mounting_deg if frame else math.nan,
        accepted=not refused and frame is not None,
        reasons=refused + remarks,
    )


def _refusals(
    trace: SensorTrace, settings: Settings, dead: tuple[str, ...], reading: float, unit: str, rate_unit: str
) -> list[str]:
    """Every reason not to use the recording."""
    indexed, clock, device = trace.indexed, trace.clock, trace.indexed.recording.device
    if indexed.recording.rows < FEWEST_ROWS:
        return [f"only {indexed.recording.rows} usable rows"]
    found = []
    if dead:
        found.append(f"dead axes: {', '.join(dead)}")
    if not math.isfinite(reading):
        found.append("no specific force to compare with gravity")
    elif not agrees_with_gravity(unit, device):
        says = f"it is gravity in {unit}" if unit != "none" else "it is gravity in no known unit"
        found.append(f"static reading {reading:.4g} is not gravity in {device.accelerometer_unit}: {says}")
    if rate_unit not in ("unclear", _declared_rate_unit(device.gyroscope_unit)):
        found.append(f"gravity turns with the angular rate read as {rate_unit}, not as {device.gyroscope_unit}")
    if not abs(clock.rate_ppm) < settings.rate_tolerance * 1e6:
        found.append(f"rate of {clock.rate_hz:.4g} Hz is not the nominal {device.rate_hz:g} Hz")
    if clock.disagreement > settings.clock_tolerance_s:
        found.append(f"the clock cannot be repaired: halves disagree by {clock.disagreement * 1e3:.2g} ms")
    share = missing_share(trace)
    if share > settings.loss_tolerance:
        found.append(f"{share:.0%} of the samples are lost")
    return found


def batch_sizes(indexed: IndexedRecording) -> np.ndarray:
    """Samples that arrived of each packet (p,) of which any did."""
    packet = np.column_stack((indexed.segment, indexed.index // indexed.batch_size))
    return np.unique(packet, axis=0, return_counts=True)[1]


def missing_share(trace: SensorTrace) -> float:
    """Share of the samples between first and last that are missing, also while a sensor restarted.

    Where no loss can be observed it is 0.
    """
    index, segment = trace.indexed.index, trace.indexed.segment
    if not len(index):
        return 0.0
    restart = np.diff(segment) != 0
    pauses = np.diff(trace.time)[restart] * trace.rate_hz - 1
    absent = float((np.diff(index) - 1)[~restart].sum() + pauses.sum())
    return absent / (len(index) + absent)


def static_reading(trace: SensorTrace) -> float:
    """Magnitude of the specific force in stored units: mean vector at rest, else median magnitude; NaN if unknown."""
    if trace.rest.any():
        return float(np.linalg.norm(trace.static_force()) / trace.scale.acceleration)
    size = np.linalg.norm(trace.indexed.recording.acceleration, axis=1)
    return float(np.median(size[np.isfinite(size)])) if np.isfinite(size).any() else math.nan


def angular_rate_unit(trace: SensorTrace) -> str:
    """The unit in which the angular rate explains how gravity turns, or "unclear" where nothing turns."""
    known = np.isfinite(trace.specific_force).all(axis=1) & np.isfinite(trace.angular_rate).all(axis=1)
    if known.sum() < FEWEST_ROWS or not math.isfinite(trace.rate_hz) or trace.rate_hz <= 0:
        return "unclear"
    rate = trace.angular_rate[known] - trace.bias()
    ratio = turning_ratio(trace.specific_force[known], rate, trace.rate_hz)
    return implied_angular_rate_unit(ratio, _declared_rate_unit(trace.indexed.recording.device.gyroscope_unit))


def _declared_rate_unit(unit: str) -> str:
    return "deg/s" if unit == "counts" else unit


def dead_axes(raw: np.ndarray) -> tuple[str, ...]:
    """Names of the columns (n, 6) that hold one value, or none."""
    dead = []
    for name, axis in zip(AXIS_NAMES, raw.T):
        known = axis[np.isfinite(axis)]
        if not len(known) or known.min() == known.max():
            dead.append(name)
    return tuple(dead)


def quantisation_step(raw: np.ndarray) -> float:
    """Smallest difference of two values of the same axis (n, 3); NaN where all are equal."""
    steps: list[float] = []
    for axis in raw.T:
        difference = np.diff(np.unique(axis[np.isfinite(axis)]))
        if len(difference):
            steps.append(float(difference.min()))
    return min(steps, default=math.nan)
