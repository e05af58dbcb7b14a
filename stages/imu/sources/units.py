"""What the numbers of a sensor mean: from declared units to SI, and what the numbers themselves say about it.

A sensor at rest measures gravity, whatever its axes: the magnitude tells g from m/s^2, mg and counts. A gyroscope
has no such standard, but when a sensor turns, gravity turns the other way in its axes, du/dt = -omega x u: the
factor between the two sides is 1 for rad/s and 0.01745 for deg/s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfiltfilt

from stages.imu.errors import SourceRefused
from stages.imu.sources.schema import ACCELERATION_UNITS, ANGULAR_RATE_UNITS, Device

STANDARD_GRAVITY = ACCELERATION_UNITS["g"] or math.nan
GAIN_TOLERANCE = 0.15  # a sensor whose gravity is further off is broken or its unit is another
LEAST_MOTION = 0.05  # rad/s rms: below it noise decides, which is a gyroscope's own whatever it rides on
TURN_UNITS = {"rad/s": 1.0, "deg/s": math.pi / 180}
USUAL_RANGES_G = (2.0, 4.0, 8.0, 16.0)


@dataclass(frozen=True)
class Scale:
    """SI value of one raw unit, and full scale in raw units (infinite where the source does not say)."""

    acceleration: float
    angular_rate: float
    acceleration_full_scale: float
    angular_rate_full_scale: float


def scale_of(device: Device) -> Scale:
    """The scale the device declares. Raises SourceRefused for counts without range or resolution."""
    acceleration, rate = ACCELERATION_UNITS[device.accelerometer_unit], ANGULAR_RATE_UNITS[device.gyroscope_unit]
    largest_a = (device.accelerometer_range_g or math.inf) * STANDARD_GRAVITY
    largest_w = math.radians(device.gyroscope_range_deg_s or math.inf)
    if acceleration is None:
        acceleration = largest_a / _counts(device, device.accelerometer_range_g, "accelerometer_range_g")
    if rate is None:
        rate = largest_w / _counts(device, device.gyroscope_range_deg_s, "gyroscope_range_deg_s")
    return Scale(acceleration, rate, largest_a / acceleration, largest_w / rate)


def _counts(device: Device, full_scale: float | None, key: str) -> float:
    if full_scale is None or device.bits is None:
        raise SourceRefused(f"sensor at the {device.place} gives counts; its {key} and bits must be known")
    return float(2 ** (device.bits - 1))


def implied_acceleration_unit(static_magnitude: float, device: Device, gravity: float = STANDARD_GRAVITY) -> str:
    """The unit in which a static reading is gravity [m/s^2]: g, m/s^2, mg, counts (with the full scale), or "none"."""
    candidates = {unit: gravity / size for unit, size in ACCELERATION_UNITS.items() if size}
    largest = 2 ** ((device.bits or 16) - 1)
    for full_scale in sorted({device.accelerometer_range_g or 4.0, *USUAL_RANGES_G}):
        candidates[f"counts of {full_scale:g} g full scale"] = largest / full_scale * (gravity / STANDARD_GRAVITY)
    near = {unit: abs(static_magnitude / size - 1) for unit, size in candidates.items()}
    declared = f"counts of {device.accelerometer_range_g or 0:g} g full scale"
    if near.get(declared, math.inf) < GAIN_TOLERANCE:
        return declared  # of ranges as near as a gain's error the one that is said
    unit = min(near, key=lambda name: near[name] if math.isfinite(near[name]) else math.inf)
    return unit if near[unit] < GAIN_TOLERANCE else "none"


def agrees_with_gravity(implied: str, device: Device) -> bool:
    """Whether the implied unit is the declared one."""
    if device.accelerometer_unit == "counts":
        return implied == f"counts of {device.accelerometer_range_g or 0:g} g full scale"
    return implied == device.accelerometer_unit


def turning_ratio(
    specific_force: np.ndarray, angular_rate: np.ndarray, rate_hz: float, cut_off_hz: float
) -> float:
    """How fast gravity turns in the sensor's axes over how fast the angular rate says it does; NaN without motion.

    specific_force, angular_rate: (n, 3), evenly sampled, no NaN, bias removed. Both sides of du/dt = -omega x u pass
    the same low pass, which leaves the equation valid and removes most of the body's own acceleration. What is left
    of that acceleration tilts u as well, so the ratio of a walking body is 1 only in order of magnitude: between 0.5
    and 3.7 in 13 recordings of walkers and hands.
    """
    if len(angular_rate) < 4 * rate_hz / cut_off_hz:
        return math.nan
    length = np.linalg.norm(specific_force, axis=1, keepdims=True)
    direction = specific_force / np.where(length > 0, length, 1.0)
    low_pass = butter(2, min(cut_off_hz, 0.4 * rate_hz), fs=rate_hz, output="sos")
    turning = np.gradient(sosfiltfilt(low_pass, direction, axis=0), 1 / rate_hz, axis=0)
    expected = sosfiltfilt(low_pass, -np.cross(angular_rate, direction), axis=0)
    seen, said = (float(np.sqrt(np.mean(np.sum(side * side, axis=1)))) for side in (turning, expected))
    if max(seen, said) < LEAST_MOTION or said == 0:
        return math.nan
    return seen / said


def implied_angular_rate_unit(ratio: float, declared: str) -> str:
    """deg/s or rad/s, whichever brings the turning ratio nearest to 1 in its logarithm; "unclear" without motion."""
    if not ratio > 0 or not math.isfinite(ratio):
        return "unclear"
    return min(TURN_UNITS, key=lambda unit: abs(math.log(ratio * TURN_UNITS[declared] / TURN_UNITS[unit])))
