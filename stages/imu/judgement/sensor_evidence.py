"""What one sensor's recording says about itself: losses, units, dead axes, resolution."""

from __future__ import annotations

import math

import numpy as np

from stages.imu.clock.indexed import IndexedRecording
from stages.imu.sources.units import implied_angular_rate_unit, swept_angle
from stages.imu.trial.sensor import SensorTrace

FEWEST_ROWS = 50
FLAT = 5  # samples at one extreme reading
COARSE = 0.01  # of an axis' range
BELOW_FULL_SCALE = 0.99
LOUD = 0.5  # of the largest reading of any axis: a quiet axis repeats its few counts
AXIS_NAMES = ("ax", "ay", "az", "gx", "gy", "gz")


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


def leg_sweep(trace: SensorTrace, slowest_hz: float) -> float:
    """The angle that the leg sweeps by the angular rate as declared [rad]; NaN where nothing can tell."""
    known = np.isfinite(trace.angular_rate).all(axis=1)
    if known.sum() < FEWEST_ROWS or not math.isfinite(trace.rate_hz) or trace.rate_hz <= 0:
        return math.nan
    return swept_angle(trace.angular_rate[known], trace.rate_hz, slowest_hz)


def angular_rate_unit(trace: SensorTrace, slowest_hz: float) -> str:
    """The unit in which the angular rate sweeps a leg's angle, or "unclear" where it is in none."""
    declared = declared_rate_unit(trace.indexed.recording.device.gyroscope_unit)
    return implied_angular_rate_unit(leg_sweep(trace, slowest_hz), declared)


def declared_rate_unit(unit: str) -> str:
    return "deg/s" if unit == "counts" else unit


def dead_axes(trace: SensorTrace) -> tuple[str, ...]:
    """Names of the axes that hold one value, or none."""
    raw = np.hstack((trace.indexed.recording.acceleration, trace.indexed.recording.angular_rate))
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


def flat_tops(raw: np.ndarray, full_scale: float) -> tuple[int, float]:
    """Samples at a reading (n, 3) that an axis reaches again and again but never passes, and that reading.

    Such an axis is at full scale below the one that is declared. Where steps are coarse, readings repeat anyway: then,
    and at the declared `full_scale`, (0, NaN).
    """
    worst, at = 0, math.nan
    largest = float(np.abs(raw[np.isfinite(raw)]).max(initial=0.0))
    for axis in raw.T:
        known = axis[np.isfinite(axis)]
        if not len(known) or quantisation_step(known[:, None]) > COARSE * np.ptp(known):
            continue
        for end in (known.min(), known.max()):
            count = int((known == end).sum())
            if count > worst and LOUD * largest < abs(end) < BELOW_FULL_SCALE * full_scale:
                worst, at = count, float(abs(end))
    return (worst, at) if worst >= FLAT else (0, math.nan)
