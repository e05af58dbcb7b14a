"""Two sensors that are dated by clocks of their own, without a common beginning, brought together by their motion.

Both ride on one leg and turn as one: still, pushed, walking. The still stand and the push happen once, so the rates lie
over each other in one place only, though steps repeat. Two crystals run at different rates as well: how the lag grows
from the walk's first half to its second is taken out of the foot's times.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from scipy.signal import fftconvolve

from stages.imu.clock.resample import resample
from stages.imu.parameters import Settings
from stages.imu.strikes.heel_strikes import filled
from stages.imu.trial.places import LATERAL, BodySensor, longest_step

REACH = 0.4  # of the shortest step, around the common lag, in which each half's own is looked for


def have_own_clocks(sensors: Mapping[str, BodySensor]) -> bool:
    """Whether there are two sensors and each is dated by its own clock."""
    return len(sensors) == 2 and all(sensor.trace.clock.stamp == "device" for sensor in sensors.values())


def brought_together(sensors: Mapping[str, BodySensor], settings: Settings) -> dict[str, BodySensor]:
    """The sensors with the foot's times on the hip's clock."""
    hip, foot = sensors["hip"], sensors["foot"]
    dt = 1 / settings.grid_rate_hz
    (start, a), (begin, b) = (_rate(sensor, dt, settings) for sensor in (hip, foot))
    if min(len(a), len(b)) < 3 * settings.grid_rate_hz:
        return dict(sensors)
    product = fftconvolve(a, b[::-1])  # at i: rows of a and b that are i - len(b) + 1 apart
    apart = int(np.argmax(product)) - len(b) + 1
    time = foot.time - (begin - start - apart * dt)
    reach = round(REACH / settings.fastest_step_hz / dt)
    half = [_lag(a, b, apart, rows, dt, reach) for rows in _halves(a, b, apart)]
    if len(half) == 2:
        (early, first), (late, second) = half
        growth = (second - first) / ((late - early) * dt)
        if abs(growth) < settings.rate_tolerance:
            middle = start + 0.5 * (early + late) * dt
            time = time - growth * (time - middle)
    return {"hip": hip, "foot": dataclasses.replace(foot, time=time)}


def _rate(sensor: BodySensor, dt: float, settings: Settings) -> tuple[float, np.ndarray]:
    """First time and lateral rate (n,) of a sensor on an even grid of its own, holes drawn over."""
    grid = np.arange(sensor.time[0], sensor.time[-1], dt)
    seen = resample(sensor.time, sensor.rate[:, [LATERAL]], grid, longest_step(sensor, settings))[:, 0]
    return float(sensor.time[0]), filled(seen)


def _halves(a: np.ndarray, b: np.ndarray, apart: int) -> list[np.ndarray]:
    """Rows of the first half and of the second of what both cover and in which something moves."""
    rows = np.arange(max(0, apart), min(len(a), len(b) + apart))
    moving = rows[np.abs(a[rows]) > 0.1 * np.abs(a[rows]).max()] if len(rows) else rows
    if len(moving) < 10:
        return []
    middle = (moving[0] + moving[-1]) // 2
    return [np.arange(moving[0], middle), np.arange(middle, moving[-1])]


def _lag(a: np.ndarray, b: np.ndarray, apart: int, rows: np.ndarray, dt: float, reach: int) -> tuple[float, float]:
    """Middle of the rows of a, and how much later b shows them than `apart` says [s], refined by a parabola."""
    rows = rows[(rows - apart - reach >= 0) & (rows - apart + reach < len(b))]
    if not len(rows):
        return 0.0, 0.0
    error = np.array([np.mean((a[rows] - b[rows - apart + shift]) ** 2) for shift in range(-reach, reach + 1)])
    best = int(np.clip(np.argmin(error), 1, len(error) - 2))
    left, middle, right = error[best - 1 : best + 2]
    curvature = left - 2 * middle + right
    return float(rows.mean()), float(best - reach + (0.5 * (left - right) / curvature if curvature > 0 else 0.0)) * dt
