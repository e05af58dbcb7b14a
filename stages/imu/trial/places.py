"""Sensors in body axes, and two of them on one leg: a common grid, the foot's lag, the lever arm, the leg's angle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.imu.clock.resample import resample
from stages.imu.parameters import Settings
from stages.imu.trial.frames import Frame
from stages.imu.trial.leg_motion import leg_angle
from stages.imu.trial.sensor import SensorTrace

PLACES = ("hip", "foot")
FORWARD, UP, LATERAL = 0, 1, 2
MOVING = 0.1  # of the largest rate
ROUNDED = 1e-3  # of a step of the grid: stamps since 1970 are rounded to a tenth of it


@dataclass(frozen=True)
class BodySensor:
    """A sensor in body axes: time (n,) [s], force (n, 3) [m/s^2], rate (n, 3) [rad/s] without bias."""

    trace: SensorTrace
    frame: Frame
    time: np.ndarray
    force: np.ndarray
    rate: np.ndarray


def longest_step(sensor: BodySensor, settings: Settings) -> float:
    """Longest time between two samples that is interpolated [s]."""
    return settings.bridged_samples / sensor.trace.rate_hz


def on_grid(sensor: BodySensor, grid: np.ndarray, settings: Settings) -> np.ndarray:
    """Force and rate (m, 6) on a grid (m,); force and rate keep holes of their own."""
    step = longest_step(sensor, settings)
    return np.hstack([resample(sensor.time, part, grid, step) for part in (sensor.force, sensor.rate)])


def common_grid(sensors: dict[str, BodySensor], settings: Settings) -> np.ndarray:
    """Even grid over the time all sensors cover."""
    first = max(sensor.time[0] for sensor in sensors.values())
    last = min(sensor.time[-1] for sensor in sensors.values())
    count = max(0, int((last - first) * settings.grid_rate_hz + ROUNDED) + 1)
    return np.asarray(first + np.arange(count) / settings.grid_rate_hz)


def overlap_of(first: BodySensor, second: BodySensor) -> float:
    """Share of the longer motion that both cover, from where each begins to turn to where it ends."""
    spans = []
    for sensor in (first, second):
        size = np.abs(np.nan_to_num(sensor.rate[:, LATERAL]))
        moving = sensor.time[size > MOVING * size.max()]
        spans.append((moving[0], moving[-1]) if len(moving) else (sensor.time[0], sensor.time[-1]))
    (a, b), (c, d) = spans
    return float(max(0.0, min(b, d) - max(a, c)) / max(b - a, d - c, 1e-9))


def bias_error(sensor: BodySensor) -> float:
    """Standard error of a sensor's lateral bias, from the scatter of its still stand [rad/s]; 0 without one."""
    still = sensor.rate[sensor.trace.rest, LATERAL]
    still = still[np.isfinite(still)]
    return float(np.std(still) / math.sqrt(len(still))) if len(still) else 0.0


def angle_on(
    grid: np.ndarray, place: str, seen: dict[str, np.ndarray], sensor: BodySensor, settings: Settings
) -> np.ndarray:
    """The leg's angle on a grid (m,) [rad] from the rate at a place; the other place, on the same leg, fills holes."""
    rate = seen[place][:, 3 + LATERAL]
    for other in seen.values():
        rate = np.where(np.isfinite(rate), rate, other[:, 3 + LATERAL])
    still = sensor.time[sensor.trace.rest]
    rest = (grid >= still[0]) & (grid <= still[-1]) if len(still) else np.zeros(len(grid), dtype=bool)
    return leg_angle(grid, rate, rest, math.radians(settings.rest_leg_angle_deg))
