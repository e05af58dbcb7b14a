"""What the numbers of a sensor mean: from declared units to SI, and what the numbers themselves say about it.

A sensor at rest measures gravity, whatever its axes: the magnitude shows g from m/s^2, mg and counts. A gyroscope
has no such standard, but a walk has: a step of length s on legs of length l sweeps them by 2 asin(s / 2 l), which
knows no metre, no second and no gravity. The units of angular rate lie a factor of 57 and of 1000 apart.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfiltfilt

from stages.imu.sources.opening import SourceRefused, printable
from stages.imu.sources.schema import ACCELERATION_UNITS, ANGULAR_RATE_UNITS, Device, Recording

STANDARD_GRAVITY = ACCELERATION_UNITS["g"] or math.nan
GAIN_TOLERANCE = 0.15  # a sensor whose gravity is further off is broken or its unit is another
#: What a leg sweeps [rad]: the middle, by its logarithm, of steps of a quarter of the leg to one and a quarter.
SWEPT = math.sqrt(2 * math.asin(0.25 / 2) * 2 * math.asin(1.25 / 2))
USUAL_RANGES_G = (2.0, 4.0, 8.0, 16.0)


@dataclass(frozen=True)
class Scale:
    """SI value of one raw unit, and full scale in raw units (infinite where the source does not say)."""

    acceleration: float
    angular_rate: float
    acceleration_full_scale: float
    angular_rate_full_scale: float


def scale_of(recording: Recording) -> Scale:
    """The scale that a recording's device declares. Raises SourceRefused for counts without range or resolution."""
    device, run = recording.device, recording.experiment.name
    acceleration, rate = ACCELERATION_UNITS[device.accelerometer_unit], ANGULAR_RATE_UNITS[device.gyroscope_unit]
    largest_a = (device.accelerometer_range_g or math.inf) * STANDARD_GRAVITY
    largest_w = math.radians(device.gyroscope_range_deg_s or math.inf)
    if acceleration is None:
        acceleration = largest_a / _counts(device, run, device.accelerometer_range_g, "accelerometer_range_g")
    if rate is None:
        rate = largest_w / _counts(device, run, device.gyroscope_range_deg_s, "gyroscope_range_deg_s")
    return Scale(acceleration, rate, largest_a / acceleration, largest_w / rate)


def _counts(device: Device, run: str, full_scale: float | None, key: str) -> float:
    if full_scale is None or device.bits is None:
        raise SourceRefused(f"run {printable(run)}: the sensor at {printable(device.place)} gives counts, so its "
                            f"device needs {key} and bits")
    return float(2 ** (device.bits - 1))


def implied_acceleration_unit(static_magnitude: float, device: Device, gravity: float = STANDARD_GRAVITY) -> str:
    """The unit in which a static reading is gravity [m/s^2]: g, m/s^2, mg, counts (with the full scale), or "none"."""
    candidates = {unit: gravity / size for unit, size in ACCELERATION_UNITS.items() if size}
    largest = 2 ** ((device.bits or 16) - 1)
    for full_scale in sorted({device.accelerometer_range_g or 4.0, *USUAL_RANGES_G}):
        candidates[f"counts of {full_scale:g} g full scale"] = largest / full_scale * (gravity / STANDARD_GRAVITY)
    near = {unit: abs(static_magnitude / size - 1) for unit, size in candidates.items()}
    declared = declared_acceleration_unit(device)
    if near.get(declared, math.inf) < GAIN_TOLERANCE:
        return declared  # of units as near as a gain's error the one that is said
    unit = min(near, key=lambda name: near[name] if math.isfinite(near[name]) else math.inf)
    return unit if near[unit] < GAIN_TOLERANCE else "none"


def declared_acceleration_unit(device: Device) -> str:
    """The unit that a device declares, as `implied_acceleration_unit` says it."""
    unit = device.accelerometer_unit
    return f"counts of {device.accelerometer_range_g or 0:g} g full scale" if unit == "counts" else unit


def swept_angle(angular_rate: np.ndarray, rate_hz: float, slowest_hz: float) -> float:
    """The angle [rad] between the ends that a leg swings to, from its angular rate (n, 3) [rad/s], evenly sampled.

    Of what turns faster than `slowest_hz`, so that neither a bias nor the way the sensor was carried counts: the
    largest travel of any axis. NaN for a recording that is too short for it.
    """
    if len(angular_rate) < rate_hz / slowest_hz:
        return math.nan
    high_pass = butter(2, min(slowest_hz, 0.4 * rate_hz), "highpass", fs=rate_hz, output="sos")
    turned = np.cumsum(angular_rate - np.median(angular_rate, axis=0), axis=0) / rate_hz
    return float(np.ptp(sosfiltfilt(high_pass, turned, axis=0), axis=0).max())


def implied_angular_rate_unit(swept: float, declared: str) -> str:
    """The unit in which an angle, swept by a rate read as `declared`, is a leg's; "unclear" where it is in none."""
    if not swept > 0 or not math.isfinite(swept):
        return "unclear"
    sizes = {unit: size for unit, size in ANGULAR_RATE_UNITS.items() if size}
    off = {unit: abs(math.log(swept / SWEPT * size / sizes[declared])) for unit, size in sizes.items()}
    unit = min(off, key=off.__getitem__)
    return unit if off[unit] < 0.5 * math.log(180 / math.pi) else "unclear"
