"""What a trial's signals say about themselves, beyond any declaration: numbers with a known value in a good trial.

Hip and foot ride on one rigid leg that walks in a plane. So both turn alike; the foot feels what the hip feels plus
d (omega' forward + omega^2 up) of the lever arm d between them, which gives d, the direction of the leg's line in the
frames that were found, and by its two parts the scale of the gyroscopes; the leg swings forward faster than it rolls
back; the angle at its own landing and that at the other leg's are opposite; and over whole strides the mean specific
force is gravity. None of these needs to know how the sensors were mounted or which unit was meant.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.signal import butter, sosfiltfilt

from stages.imu.strikes.heel_strikes import filled, lowest_between
from stages.imu.strikes.step_times import INNER, HeelStrikes
from stages.imu.trial.frames import swing_axis

#: For Table 1's robot; others have their own time.
LOW_PASS_HZ = 12.0  # both sides of the lever arm's equation: a derivative of the rate is noise above
AROUND_STRIKE_S = (-0.06, 0.10)  # left out of it: impacts shake the sensors
HOLE_S = 0.02  # and so is what lies so near to a hole
LATE_S = 0.06  # farthest that the rates are looked for behind the forces, or before
EXPLAINED = 0.5  # of what does not agree is left by a lag that is told
ALIKE = 0.25  # smallest agreement of two signals that tells by what factor they differ
FEWEST_POINTS = 50
NAN = float("nan")


def agreement_of(hip: np.ndarray, foot: np.ndarray) -> tuple[float, float]:
    """Signed squared correlation of two rates (n,), and the foot's over the hip's in least squares."""
    known = np.isfinite(hip) & np.isfinite(foot)
    if known.sum() < FEWEST_POINTS:
        return NAN, NAN
    a, b = hip[known] - hip[known].mean(), foot[known] - foot[known].mean()
    power = math.sqrt(float((a @ a) * (b @ b)))
    if power == 0:
        return NAN, NAN
    correlation = float(a @ b) / power
    return correlation * abs(correlation), float(a @ b / (a @ a))


def gain_of(first: np.ndarray, second: np.ndarray) -> float:
    """The factor nearest to 1 by which the second of two signals (n,) may be the first, each with errors of its own.

    It lies between the lines of least squares of each on the other (Frisch 1934). NaN where less than `ALIKE` of one is
    the other.
    """
    alike, slope = agreement_of(first, second)
    if not abs(alike) > ALIKE:
        return NAN
    low, high = sorted((slope, slope / abs(alike)))
    return min(max(1.0, low), high)


def lever_of(
    time: np.ndarray, hip: np.ndarray, foot: np.ndarray, strikes: HeelStrikes, rate_hz: float,
    quick: float = 1.0,
) -> tuple[float, float, float, float, float, float]:
    """Distance of the foot's sensor below the hip's [m], its direction from the leg's line [deg], forward gain of the
    foot over the hip (1), agreement of the forward part with how the hip's own rate changes, and with how the foot's
    does, and how late the rates are [s]. The distance is negative where the two are named the wrong way round.

    hip, foot: signals (n, 6) on a grid. The robot is so `quick` as Table 1's.

    With forward as the real and up as the imaginary axis f_foot - f_hip = z (omega' + i omega^2) + constant, where
    z = d exp(i beta) and beta is the direction. What both places accelerate with drops out, so the agreement is near 1
    for any robot; -1 for a gyroscope that was turned.
    """
    if len(time) < FEWEST_POINTS:
        return (NAN,) * 6
    hole = ~(np.isfinite(hip).all(axis=1) & np.isfinite(foot).all(axis=1))
    reach = max(1, round(HOLE_S / quick * rate_hz))
    known = np.convolve(hole, np.ones(2 * reach + 1), "same") == 0
    for strike in strikes.time:
        known &= (time < strike + AROUND_STRIKE_S[0] / quick) | (time > strike + AROUND_STRIKE_S[1] / quick)
    if known.sum() < FEWEST_POINTS:
        return (NAN,) * 6
    sections = butter(2, min(LOW_PASS_HZ * quick, 0.4 * rate_hz), fs=rate_hz, output="sos")

    def smooth(one: np.ndarray) -> np.ndarray:
        return np.asarray(sosfiltfilt(sections, one)[known])

    rate, one = filled(0.5 * (hip[:, 5] + foot[:, 5])), np.ones(int(known.sum()))
    turning, square = smooth(np.gradient(rate, time)), smooth(rate**2)
    forward, up = smooth(filled(foot[:, 0] - hip[:, 0])), smooth(filled(foot[:, 1] - hip[:, 1]))
    whole = np.linalg.lstsq(np.column_stack((turning + 1j * square, one)), forward + 1j * up, rcond=None)[0]
    of_hip, across = smooth(filled(hip[:, 0])), np.linalg.qr(np.column_stack((turning, one)))[0]
    left = [force - across @ (across.T @ force) for force in (of_hip, of_hip + forward)]
    own = [agreement_of(smooth(np.gradient(filled(each[:, 5]), time)), forward)[0] for each in (hip, foot)]
    changes = np.asarray(sosfiltfilt(sections, np.gradient(rate, time)))
    reach = round(LATE_S / quick * rate_hz)
    alike = np.array([agreement_of(np.roll(changes, -late)[known], forward)[0] for late in range(-reach, reach + 1)])
    late = (peak_of(alike) - reach) / rate_hz if 1 - alike.max() < EXPLAINED * (1 - alike[reach]) else 0.0
    direction = math.degrees(math.atan2(whole[0].imag, abs(whole[0].real)))
    return float(whole[0].real), direction, gain_of(*left), own[0], own[1], late


def peak_of(values: np.ndarray) -> float:
    """Where values (n,) are largest, refined by a parabola (a number of steps)."""
    best = int(np.clip(np.argmax(values), 1, len(values) - 2))
    return best + lowest_between(-values, best)


def axis_turn_of(rate: np.ndarray) -> float:
    """Angle [deg] between the swing axes of the first and the second half of the rates (n, 3) of a walk."""
    known = rate[np.isfinite(rate).all(axis=1)]
    halves = np.array_split(known, 2)
    if len(halves[1]) < FEWEST_POINTS:
        return NAN
    first, second = (swing_axis(half)[0] for half in halves)
    return math.degrees(math.acos(min(1.0, abs(float(first @ second)))))


def skewness(rate: np.ndarray) -> float:
    """Third moment about zero over the second's power 3/2, of a rate (n,) with holes; NaN for nothing."""
    known = rate[np.isfinite(rate)]
    power = float(np.mean(known**2)) if len(known) else 0.0
    return float(np.mean(known**3)) / power**1.5 if power > 0 else NAN


def symmetry_of(angle_at_strikes: np.ndarray, strikes: HeelStrikes) -> float:
    """Median over neighbouring strikes of the mean of the inner leg's angle at its own and the other's landing [deg].

    At a landing both feet are on the ground; legs of equal length then stand at equal angles from the normal.
    """
    own, neighbour = strikes.leg[:-1] == INNER, strikes.leg[1:] == INNER
    pairs = 0.5 * (angle_at_strikes[1:] + angle_at_strikes[:-1])[own != neighbour]
    return math.degrees(float(np.median(pairs))) if len(pairs) else NAN


def gravity_of(
    time: np.ndarray, force: np.ndarray, angle: np.ndarray, span: tuple[float, float]
) -> tuple[float, float]:
    """Mean specific force over whole strides: its size [m/s^2] and its direction [rad], downhill of the slope normal.

    force (n, 3) on body axes is turned by the leg's angle (n,) into the slope's. What a stride gains in speed it loses
    again, so the mean is -gravity, at the inclination from the normal.
    """
    even = np.linspace(*span, max(FEWEST_POINTS, 2 * len(time)))
    forward, up = filled(force[:, 0]), filled(force[:, 1])
    along = np.interp(even, time, np.cos(angle) * forward - np.sin(angle) * up).mean()
    normal = np.interp(even, time, np.sin(angle) * forward + np.cos(angle) * up).mean()
    return float(math.hypot(along, normal)), math.atan2(-along, normal)


def spacing_of(strikes: HeelStrikes) -> tuple[float, float]:
    """Largest departure of a step's duration from the median (1), whole steps that were missed counted as such, and
    the share of steps after which the other leg lands."""
    if len(strikes.time) < 3:
        return NAN, NAN
    step = np.diff(strikes.time)
    usual = float(np.median(step))
    if not usual > 0:
        return float("inf"), 0.0
    whole = np.maximum(1, np.rint(step / usual))
    other = np.diff(strikes.leg) != 0
    return float(np.abs(step / usual - whole).max()), float(np.mean(other == (whole % 2 == 1)))
