"""Which rows of a recording are of a walk: a robot that stood still sets off, until it stands again or is picked up.

A lab's recording goes on: the robot is caught at the ramp's end, carried back, put down, and walks once more. A hand
turns it about all axes, and the stand of another pose is none to measure a walk from. So each walk is read by itself,
from the stand before it to the next one, or to where it leaves its plane.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from stages.imu.parameters import Limits, Settings
from stages.imu.strikes.heel_strikes import SMOOTHED_STEPS, filled, step_period, turns
from stages.imu.trial.sensor import SensorTrace, stands


def walks_in(trace: SensorTrace, settings: Settings, limits: Limits) -> list[slice]:
    """The rows of each walk, with the stand before it; none where no walk follows a stand."""
    starts, ends = stands(trace.specific_force, trace.angular_rate, trace.rate_hz, settings)
    least = settings.rest_window_s * trace.rate_hz
    apart = starts[1:] - ends[:-1] > least  # a slow push begins so gently that its first part looks still by itself
    starts, ends = starts[np.append(True, apart)[: len(starts)]], ends[np.append(apart, True)[: len(ends)]]
    rate = np.column_stack([filled(axis) for axis in trace.angular_rate.T])
    walks = list[slice]()
    for first, stood, after in zip(starts, ends, np.append(starts[1:], len(rate))):
        walked = _walked(rate[stood:after] - rate[first:stood].mean(axis=0), trace.rate_hz, settings, limits)
        if walked:
            walks.append(slice(0 if first < least else int(first), int(stood) + walked))
    return walks


def _walked(rate: np.ndarray, rate_hz: float, settings: Settings, limits: Limits) -> int:
    """For how many rows of a motion's angular rate (n, 3) the robot walks; 0 where it does not.

    It swings in one plane, that of its first strides, and turns round as often as a run needs steps.
    """
    begun = rate[: int(rate_hz / settings.slowest_stride_hz)]
    power, axes = np.linalg.eigh(begun.T @ begun)
    if not power[-1] >= limits.swing_share * power.sum() > 0.0:
        return 0
    swing, dt = rate @ axes[:, -1], 1.0 / rate_hz
    period = step_period(swing[: len(begun)], dt, (settings.slowest_step_hz, settings.fastest_step_hz))
    if not np.isfinite(period):
        return 0
    step = int(period * rate_hz)
    of_a_step = [np.convolve(signal, np.ones(step), "valid") for signal in ((rate**2).sum(axis=1), swing**2)]
    usual = step * power.sum() / len(begun)
    outside = np.flatnonzero(of_a_step[0] - of_a_step[1] > (1.0 - limits.swing_share) * np.maximum(of_a_step[0], usual))
    walked = int(outside[0]) if len(outside) else len(rate)
    smooth = gaussian_filter1d(swing[:walked], SMOOTHED_STEPS * period / dt)
    return walked if walked and len(turns(smooth, period, dt)) >= settings.fewest_steps else 0
