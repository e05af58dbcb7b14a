"""What a leg that stands tells of its gyroscope and its own length: gravity turns by its angle, its foot rolls.

With theta = -phi, a sensor of which A is the height above the sole of a leg that stands and rolls feels, forward,

    f = -g sin(theta + slope) + (A + r (cos theta - 1)) theta''

A gyroscope that reads gamma times the true rate gives gamma theta. How far gravity turns tells gamma, how the force
follows the rate's change tells A. What a stance's angle is off is one more number, which a drift lets grow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfiltfilt

from stages.imu.parameters import Drawing, Reading
from stages.imu.reports.run_report import Evidence
from stages.imu.strikes.heel_strikes import filled

#: For Table 1's robot; others have their own time.
LOW_PASS_HZ = 30.0  # of both sides: above a derivative of the rate is noise
AFTER_LANDING_S, BEFORE_LANDING_S = 0.06, 0.04  # impacts shake the sensor
HOLE_S = 0.02  # and a hole is drawn over
FEWEST_POINTS = 50
ROUNDS = 6  # of Gauss and Newton: from 1 to 2 in five
SURE = 0.02  # largest standard error, from the scatter, of a gain that is told


def swept(
    time: np.ndarray, forward: np.ndarray, rate: np.ndarray, angle: np.ndarray, stances: tuple[np.ndarray, np.ndarray],
    slope: float, gravity: float, arm: float, radius: float, quick: float = 1.0,
) -> tuple[float, float, float, float]:
    """What the lateral gyroscope reads over the true rate (1), its standard error from the scatter, the sensor's height
    above the sole [m], and how far the angle of the rate departs at most from gravity's in a stance [rad].

    time (n,) [s], even; forward (n,) [m/s^2] and rate (n,) [rad/s] on body axes, NaN in holes; angle (n,) [rad] from
    that rate; stances: landings of this leg and the other leg's that follow, each (k,) [s]; slope [rad], arm [m] and
    radius [m] as they should be. The robot is so `quick` as Table 1's. NaN for what the stances do not tell.
    """
    unknown = (math.nan,) * 4
    number = np.full(len(time), -1)
    for place, (start, end) in enumerate(zip(*stances)):
        number[(time > start + AFTER_LANDING_S / quick) & (time < end - BEFORE_LANDING_S / quick)] = place
    standing = number >= 0
    if standing.sum() < FEWEST_POINTS:
        return unknown
    grid_hz = (len(time) - 1) / float(time[-1] - time[0])
    hole = ~(np.isfinite(forward) & np.isfinite(rate))
    standing &= np.convolve(hole, np.ones(2 * max(1, round(HOLE_S / quick * grid_hz)) + 1), "same") == 0
    if standing.sum() < FEWEST_POINTS:
        return unknown
    low_pass = butter(2, min(LOW_PASS_HZ * quick, 0.4 * grid_hz), fs=grid_hz, output="sos")
    both = filled(forward), -np.gradient(filled(rate), time)
    force, turning = (sosfiltfilt(low_pass, one)[standing] for one in both)
    theta, which = -angle[standing], np.unique(number[standing], return_inverse=True)[1]
    own = np.eye(which.max() + 1)[which]  # each stance's angle is one more number
    share = np.array([1.0, arm, *np.zeros(own.shape[1])])
    for _ in range(ROUNDS):  # on 1 / gamma, A / gamma, and the angles
        turned, tilt = share[0] * theta, slope + own @ share[2:]
        down = -gravity * np.cos(turned + tilt)
        columns = np.column_stack((down * theta, turning, down[:, None] * own))
        left = force + gravity * np.sin(turned + tilt)
        left -= (share[1] + radius * share[0] * (np.cos(turned) - 1)) * turning
        step, _, rank, _ = np.linalg.lstsq(columns, left, rcond=None)
        share = share + step
        if rank < len(share) or not 0.1 < share[0] < 10:
            return unknown
    # Both sides are smoothed: so many points of the grid are one.
    scatter = float(left @ left) / len(left) * max(1.0, grid_hz / (2 * LOW_PASS_HZ * quick))
    error = math.sqrt(scatter * np.linalg.inv(columns.T @ columns)[0, 0]) / share[0]  # relative, of 1 / gamma
    if not error < SURE:
        return unknown
    return float(1 / share[0]), error / share[0], float(share[1] / share[0]), float(np.abs(share[2:]).max())


@dataclass(frozen=True)
class Confirmed:
    """Standard errors (1) of the gyroscopes' gain and of the leg's length, both taken as they are declared."""

    gain_error: float
    length_error: float


def mean_gain(evidence: Evidence, drawing: Drawing) -> tuple[float, float]:
    """What the gyroscopes read in the mean over what gravity turns by (1), and its standard error.

    Each place tells it, for how fast one gyroscope turns beside the other is known; the surer weighs more.
    """
    ratio = evidence.rate_ratio or math.nan
    told = []
    for gain, error, other in ((evidence.hip_gain, evidence.hip_gain_error, ratio),
                               (evidence.foot_gain, evidence.foot_gain_error, 1 / ratio)):  # fmt: skip
        if not math.isnan(gain):
            mean = gain if math.isnan(other) else 0.5 * gain * (1 + other)
            told.append((mean, 1 / (max(error, drawing.swept_error) ** 2 + drawing.gain_error**2)))
    weight = sum(one for _, one in told)
    return (sum(mean * one for mean, one in told) / weight, weight**-0.5) if told else (math.nan, math.nan)


def confirmed(evidence: Evidence, parameters: Reading) -> Confirmed:
    """How far what is declared of gain and length is confirmed by what was found, with a standard error of its own.

    A gain found within two of its errors of 1 is confirmed to one; further off, and of a length, the square of the
    distance is that of what is declared wrong and of the error together. Two gyroscopes that differ are half as far off
    in the mean, whichever is right. A gain that nothing tells is any that the verdict lets through. A drawing that
    nothing tells is as good as it says.
    """
    drawing = parameters.drawing
    gain, sure = mean_gain(evidence, drawing)
    if math.isnan(gain):
        gain, sure = 1.0, parameters.limits.rate_scale_tolerance / math.sqrt(3)
    off = math.sqrt((gain - 1) ** 2 - sure**2) if abs(gain - 1) > 2 * sure else sure
    apart = 0.0 if math.isnan(evidence.rate_ratio) else 0.5 * abs(evidence.rate_ratio - 1)
    arm = next((one for one in (evidence.hip_arm, evidence.foot_arm) if not math.isnan(one)), 1.0)
    drawn = (arm - 1) ** 2 - drawing.swept_error**2 - drawing.gain_error**2
    return Confirmed(max(off, apart), math.sqrt(max(drawing.leg_length_error**2, drawn)))
