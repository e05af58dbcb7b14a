"""Leg angle, step length and hip path from one integration: the lateral rate, and the foot that rolls.

Integrating the acceleration twice drifts with the square of time; the rate less its bias at rest, integrated once,
does not. While the inner leg stands, its foot rolls without slip, so with theta = -phi the hip is at

    x = r theta + (L - r) sin theta,    y = r + (L - r) cos theta

from where the leg would stand upright (paper, eq. 3). Over the other leg's stance nothing carries the sensors' leg, and
nothing is said.
"""

from __future__ import annotations

import math

import numpy as np

from stages.biped.between_steps import running_integral
from stages.imu.judgement.rolling_stance import Confirmed
from stages.imu.parameters import Drawing
from stages.imu.reports.run_report import StepTimes
from stages.imu.result import LegMotion
from stages.imu.strikes.heel_strikes import filled
from stages.imu.strikes.step_times import UNKNOWN, HeelStrikes, stances_of

PATH_POINTS = 51
#: For Table 1's robot; others have their own time.
ROUNDED_S = 0.012  # how far a low pass rounds the corner of a landing off
CONTINUED_S = 0.08  # from how far inside the angle is continued to a landing
FEWEST_POINTS = 8


def leg_angle(time: np.ndarray, lateral_rate: np.ndarray, rest: np.ndarray, rest_angle: float) -> np.ndarray:
    """Angle of the leg from the slope normal (n,) [rad], foot ahead positive.

    lateral_rate (n,) [rad/s] is that of the leg, its bias removed; holes are drawn over. `rest` (n,) marks the still
    stand, in whose mean the angle is `rest_angle` [rad].
    """
    rate = filled(lateral_rate)
    turned = running_integral(rate, time)
    return np.asarray(turned - (turned[rest].mean() if rest.any() else turned[0]) + rest_angle)


def hip_at(angle: np.ndarray, drawing: Drawing) -> np.ndarray:
    """Hip (..., 2) [m] along and above the slope, from where a leg at these angles (...) [rad] would stand upright."""
    theta, r = -angle, drawing.foot_radius
    above = drawing.leg_length - r
    return np.stack([r * theta + above * np.sin(theta), r + above * np.cos(theta)], axis=-1)


def stance_angle(time: np.ndarray, angle: np.ndarray, start: float, end: float) -> np.ndarray:
    """The angle [rad] at `PATH_POINTS` even times from one landing to the next, as if nothing were beside.

    A landing changes the rate at once, and a sensor's low pass rounds that corner off: what is near to a landing is
    continued, by a cubic, from the stance's inside.
    """
    at = np.linspace(start, end, PATH_POINTS)
    found = np.asarray(np.interp(at, time, angle))
    for landing, inward in ((start, 1.0), (end, -1.0)):
        depth = inward * (time - landing)
        inside, near = (depth >= ROUNDED_S) & (depth <= CONTINUED_S), inward * (at - landing) < ROUNDED_S
        if inside.sum() >= FEWEST_POINTS and 0.5 * (end - start) > CONTINUED_S:
            cubic = np.polynomial.Polynomial.fit(depth[inside], angle[inside], 3)
            found[near] = cubic(inward * (at[near] - landing))
    return found


def leg_motion(
    time: np.ndarray,
    angle: np.ndarray,
    rest_angle: float,
    bias_error: float,
    confirmed: Confirmed,
    strikes: HeelStrikes,
    times: StepTimes,
    drawing: Drawing,
    quick: float = 1.0,
) -> LegMotion:
    """The motion of the leg from its angle (m,) on an even grid (m,) [s].

    The angle's error is that of the stand, of the gyroscopes' gain on what was turned since, and of the bias,
    `bias_error` [rad/s], on the time since the grid began. A step's is that of the gain, of the leg's length, of when
    each leg's impacts begin and of both landings' own times, and what rolling on a compliant leg departs from a rigid
    one. The robot is so `quick` as Table 1's.
    """
    gain = confirmed.gain_error
    since = time - time[0] if len(time) else time
    stand = math.radians(drawing.stand_error_deg)
    error = np.sqrt(stand**2 + (gain * (angle - rest_angle)) ** 2 + (bias_error * since) ** 2)
    start, end = stances_of(strikes)
    inside = (start >= time[0]) & (end <= time[-1]) if len(time) else np.zeros(len(start), dtype=bool)
    start, end = start[inside], end[inside]
    swept = [stance_angle(quick * time, angle, quick * one, quick * other) for one, other in zip(start, end)]
    path = hip_at(np.array(swept).reshape(-1, PATH_POINTS), drawing)
    length = path[:, -1, 0] - path[:, 0, 0]
    share = math.sqrt(gain**2 + confirmed.length_error**2 + drawing.rolling_error**2)
    apart = (end - start) / (PATH_POINTS - 1)
    ends = (path[:, [1, -1], 0] - path[:, [0, -2], 0]) / apart[:, None]  # speeds at both landings
    late = math.hypot(drawing.onset_error_s, drawing.strike_scatter_s)
    said = np.sqrt((share * length) ** 2 + late**2 * (ends**2).sum(axis=1))
    path[:, :, 0] -= path[:, :1, 0]
    drawn = confirmed.length_error * length
    return LegMotion(time, angle, error, start, end, length, said, drawn, path, times)


def nothing() -> LegMotion:
    """A leg of which nothing is known."""
    none = np.empty(0)
    return LegMotion(none, none, none, none, none, none, none, none, np.empty((0, PATH_POINTS, 2)), UNKNOWN)
