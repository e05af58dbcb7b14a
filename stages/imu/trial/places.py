"""Sensors in body axes, and two of them on one leg: a common grid, the foot's lag, the lever arm, the leg's angle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.imu.clock.resample import resample
from stages.imu.parameters import Settings
from stages.imu.strikes.heel_strikes import filled
from stages.imu.strikes.heel_strikes import step_period as period_of
from stages.imu.trial.frames import Frame
from stages.imu.trial.leg_motion import leg_angle
from stages.imu.trial.sensor import SensorTrace

PLACES = ("hip", "foot")
FORWARD, UP, LATERAL = 0, 1, 2


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
    count = max(0, int((last - first) * settings.grid_rate_hz) + 1)
    return np.asarray(first + np.arange(count) / settings.grid_rate_hz)


def overlap_of(first: np.ndarray, second: np.ndarray) -> float:
    """Share of the longer recording that both cover."""
    both = min(first[-1], second[-1]) - max(first[0], second[0])
    return float(max(0.0, both) / max(np.ptp(first), np.ptp(second), 1e-9))


def foot_lag(sensors: dict[str, BodySensor], settings: Settings) -> tuple[float, bool]:
    """How much later the foot's rate shows what the hip's shows [s], and whether that is more than was searched.

    Both ride on one leg and turn as one. Stamps first: only lags within half a step are tried. Least difference of the
    two, one of which may be turned round, refined by a parabola where it lies between lags that were tried; at an end
    of the search it is left there.
    """
    grid = common_grid(sensors, settings)
    if len(grid) < 3 * settings.grid_rate_hz:
        return 0.0, False
    hip, foot = (filled(on_grid(sensors[place], grid, settings)[:, 3 + LATERAL]) for place in PLACES)
    dt = 1 / settings.grid_rate_hz
    period = period_of(hip, dt, (settings.slowest_step_hz, settings.fastest_step_hz))
    if not math.isfinite(period):
        return 0.0, False
    reach = max(2, int(0.5 * period / dt))
    lags = np.arange(-reach, reach + 1)
    inner = slice(reach, len(grid) - reach)
    moved = [np.roll(foot, -lag)[inner] for lag in lags]
    error = np.array([min(np.mean((hip[inner] - one) ** 2), np.mean((hip[inner] + one) ** 2)) for one in moved])
    best = int(np.argmin(error))
    if not 0 < best < len(lags) - 1:
        return float(lags[best] * dt), True
    left, middle, right = error[best - 1 : best + 2]
    curvature = left - 2 * middle + right
    return float((lags[best] + (0.5 * (left - right) / curvature if curvature > 0 else 0.0)) * dt), False


def lever_arm(sensors: dict[str, BodySensor], settings: Settings) -> float:
    """Distance of the foot sensor below the hip sensor [m], from f_foot - f_hip = d (omega' forward + omega^2 up).

    Negative where the two sensors are named the wrong way round.
    """
    grid = common_grid(sensors, settings)
    if len(grid) < 10:
        return math.nan
    hip, foot = (on_grid(sensors[place], grid, settings) for place in PLACES)
    rate = 0.5 * (hip[:, 3 + LATERAL] + foot[:, 3 + LATERAL])
    expected = np.column_stack((np.gradient(rate, grid), rate**2))
    difference = (foot - hip)[:, [FORWARD, UP]]
    known = np.isfinite(expected).all(axis=1) & np.isfinite(difference).all(axis=1)
    # Impacts shake the sensors: trimmed to the smoother nine tenths of the motion.
    size = np.abs(expected[:, 0])
    known &= size < np.nanquantile(size, 0.9) if known.any() else known
    power = float(np.sum(expected[known] ** 2))
    return float(np.sum(expected[known] * difference[known]) / power) if power > 0 else math.nan


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
