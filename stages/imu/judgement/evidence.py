"""What a trial's signals say about themselves, beyond any declaration: numbers with a known value in a good trial.

Hip and foot ride on one rigid leg that walks in a plane. So both turn alike; the foot reads what the hip reads plus
d (omega' forward + omega^2 up) of the lever arm d between them, which gives d, the direction of the leg's line in the
frames that were found, and by its two parts the scale of the gyroscopes; the leg swings forward faster than it rolls
back; the angle at its own landing and that at the other leg's are opposite; and over whole strides the mean specific
force is gravity. None of these needs to know how the sensors were mounted or which unit was meant.

A leg that stands shows its gyroscope's gain and its own length: gravity turns by its angle, its foot rolls. With
theta = -phi, a sensor of which A is the height above the sole of a leg that stands and rolls measures, forward,

    f = -g sin(theta + slope) + (A + r (cos theta - 1)) theta''

A gyroscope that reads gamma times the true rate gives gamma theta. How far gravity turns shows gamma, how the force
follows the rate's change shows A. What a stance's angle is off is one more number, which a drift lets grow.
"""

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
from scipy.signal import butter, sosfiltfilt

from stages.imu.clock.clock import resample
from stages.imu.parameters import Drawing, Parameters
from stages.imu.result import Evidence
from stages.imu.strikes.heel_strikes import PULSE_S, SHIFTS_S, filled, in_hole, lowest_between
from stages.imu.strikes.step_times import INNER, HeelStrikes, stances_of
from stages.imu.trial.body import FORWARD, LATERAL, PLACES, BodySensor, GridSignals, swing_axis

#: For Table 1's robot; others have their own time. Low passes of both sides: above, a derivative of the rate is noise.
LEVER_LOW_PASS_HZ, STANCE_LOW_PASS_HZ = 12.0, 30.0
AROUND_STRIKE_S = (-0.06, 0.10)  # left out of the lever arm's equation: impacts shake the sensors
AFTER_LANDING_S, BEFORE_LANDING_S = 0.06, 0.04  # and of a stance
HOLE_S = 0.02  # and so is what lies so near to a hole
LATE_S = 0.06  # farthest that the rates are looked for behind the forces, or before
EXPLAINED = 0.5  # of what does not agree is left by a lag that is reported
ALIKE = 0.25  # smallest agreement of two signals that shows by what factor they differ
FEWEST_POINTS = 50
ROUNDS = 6  # of Gauss and Newton: from 1 to 2 in five
SURE = 0.02  # largest standard error, from the scatter, of a gain that is reported
NAN = math.nan


def evidence_of(
    sensors: Mapping[str, BodySensor], common: GridSignals, strikes: HeelStrikes, bounds: np.ndarray,
    slope_deg: float | None, parameters: Parameters,
) -> Evidence:
    """What the run's signals say about themselves, by all strikes and the strides between these bounds."""
    settings, drawing, quick, grid = parameters.settings, parameters.drawing, parameters.quick, common.time
    found = dict.fromkeys((field.name for field in dataclasses.fields(Evidence)), NAN)
    if len(sensors) == 2:
        hip, foot = (common.signals[place] for place in PLACES)
        found["agreement"], found["rate_ratio"] = agreement_of(hip[:, 3 + LATERAL], foot[:, 3 + LATERAL])
        names = ("lever_arm", "lever_direction_deg", "forward_gain", "hip_turning", "foot_turning", "rate_lag")
        found |= zip(names, lever_of(grid, hip, foot, strikes, settings.grid_rate_hz, quick))
    first = next((place for place in PLACES if place in sensors), "")
    slope, stances = math.radians(slope_deg or 0.0), stances_of(strikes)
    if len(grid):  # where one sensor ended before the other there is no angle
        bounds = bounds[(bounds[:, 0] >= grid[0]) & (bounds[:, 1] <= grid[-1])]
    for place, sensor in sensors.items():
        found[f"{place}_axis_deg"] = axis_turn_of(sensor.rate[~sensor.trace.rest])
        if not len(bounds) or not len(grid):
            continue
        angle, signals = common.angle[place], common.signals[place]
        arm = drawing.leg_length - (parameters.limits.lever_arm if place == "foot" else drawing.sag)
        gain, error, height, apart = swept(
            grid, signals[:, FORWARD], signals[:, 3 + LATERAL], angle, stances, slope, settings.gravity, arm,
            drawing.foot_radius, quick)  # fmt: skip
        size, downhill = gravity_of(grid, signals[:, :3], angle, (bounds[0, 0], bounds[-1, 1]))
        own = {"gain": gain, "gain_error": error, "arm": height / arm, "pitch_deg": math.degrees(apart),
               "gravity": size / settings.gravity, "gravity_deg": math.degrees(downhill - slope)}  # fmt: skip
        found |= {f"{place}_{name}": value for name, value in own.items()}
        if place == first:
            found["strike_symmetry_deg"] = symmetry_of(np.interp(strikes.time, grid, angle), strikes)
    found["spacing"], found["alternating"] = spacing_of(strikes)
    if first:
        sensor = sensors[first]
        found["third_moment"] = skewness(filled(sensor.rate[~sensor.trace.rest, LATERAL]))
        # Among samples that are there: one at full scale shows a strike.
        there = resample(sensor.time, np.zeros((len(sensor.time), 1)), grid, sensor.longest_step(settings))
        reach = max(1, round((0.75 * PULSE_S + SHIFTS_S[-1]) / quick * settings.grid_rate_hz))  # as far as one is moved
        hidden = in_hole(there, np.searchsorted(grid, strikes.time), reach)
        found["hidden_strikes"] = float(hidden.mean()) if len(hidden) else NAN
    return Evidence(**found)


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


def away_from_holes(known: np.ndarray, quick: float, rate_hz: float) -> np.ndarray:
    """Which rows (n,) of a grid lie further than `HOLE_S` from one that is not known."""
    reach = max(1, round(HOLE_S / quick * rate_hz))
    return np.asarray(np.convolve(~known, np.ones(2 * reach + 1), "same") == 0)


def low_pass(cut_off_hz: float, rate_hz: float) -> np.ndarray:
    """Sections of a second-order low pass, applied to and fro."""
    return np.asarray(butter(2, min(cut_off_hz, 0.4 * rate_hz), fs=rate_hz, output="sos"))


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
    known = away_from_holes(np.isfinite(hip).all(axis=1) & np.isfinite(foot).all(axis=1), quick, rate_hz)
    if len(strikes.time) > 1:  # a push or a catch may hold blows of its own
        known &= (time > strikes.time[0]) & (time < strikes.time[-1])
    for strike in strikes.time:
        known &= (time < strike + AROUND_STRIKE_S[0] / quick) | (time > strike + AROUND_STRIKE_S[1] / quick)
    if known.sum() < FEWEST_POINTS:
        return (NAN,) * 6
    sections = low_pass(LEVER_LOW_PASS_HZ * quick, rate_hz)

    def smooth(one: np.ndarray) -> np.ndarray:
        return np.asarray(sosfiltfilt(sections, one)[known])

    rate, one = filled(0.5 * (hip[:, 5] + foot[:, 5])), np.ones(int(known.sum()))
    turning, square = smooth(np.gradient(rate, time)), smooth(rate**2)
    forward, up = smooth(filled(foot[:, 0] - hip[:, 0])), smooth(filled(foot[:, 1] - hip[:, 1]))
    arm = np.linalg.lstsq(np.column_stack((turning + 1j * square, one)), forward + 1j * up, rcond=None)[0][0]
    of_hip, across = smooth(filled(hip[:, 0])), np.linalg.qr(np.column_stack((turning, one)))[0]
    left = [force - across @ (across.T @ force) for force in (of_hip, of_hip + forward)]
    own = [agreement_of(smooth(np.gradient(filled(each[:, 5]), time)), forward)[0] for each in (hip, foot)]
    changes = np.asarray(sosfiltfilt(sections, np.gradient(rate, time)))
    reach = round(LATE_S / quick * rate_hz)
    alike = np.array([agreement_of(np.roll(changes, -late)[known], forward)[0] for late in range(-reach, reach + 1)])
    best = int(np.clip(np.argmax(alike), 1, len(alike) - 2))
    late = best + lowest_between(-alike, best) - reach if 1 - alike.max() < EXPLAINED * (1 - alike[reach]) else 0.0
    direction = math.degrees(math.atan2(arm.imag, abs(arm.real)))
    return float(arm.real), direction, gain_of(*left), own[0], own[1], late / rate_hz


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
        return math.inf, 0.0
    whole = np.maximum(1, np.rint(step / usual))
    other = np.diff(strikes.leg) != 0
    return float(np.abs(step / usual - whole).max()), float(np.mean(other == (whole % 2 == 1)))


def swept(
    time: np.ndarray, forward: np.ndarray, rate: np.ndarray, angle: np.ndarray, stances: tuple[np.ndarray, np.ndarray],
    slope: float, gravity: float, arm: float, radius: float, quick: float = 1.0,
) -> tuple[float, float, float, float]:
    """What the lateral gyroscope reads over the true rate (1), its standard error from the scatter, the sensor's height
    above the sole [m], and how far the angle of the rate departs at most from gravity's in a stance [rad].

    time (n,) [s], even; forward (n,) [m/s^2] and rate (n,) [rad/s] on body axes, NaN in holes; angle (n,) [rad] from
    that rate; stances: landings of this leg and the other leg's that follow, each (k,) [s]; slope [rad], arm [m] and
    radius [m] as they should be. The robot is so `quick` as Table 1's. NaN for what the stances do not show.
    """
    number = np.full(len(time), -1)
    for place, (start, end) in enumerate(zip(*stances)):
        number[(time > start + AFTER_LANDING_S / quick) & (time < end - BEFORE_LANDING_S / quick)] = place
    if (number >= 0).sum() < FEWEST_POINTS:
        return (NAN,) * 4
    grid_hz = (len(time) - 1) / float(time[-1] - time[0])
    standing = (number >= 0) & away_from_holes(np.isfinite(forward) & np.isfinite(rate), quick, grid_hz)
    if standing.sum() < FEWEST_POINTS:
        return (NAN,) * 4
    both = filled(forward), -np.gradient(filled(rate), time)
    sections = low_pass(STANCE_LOW_PASS_HZ * quick, grid_hz)
    force, turning = (sosfiltfilt(sections, one)[standing] for one in both)
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
            return (NAN,) * 4
    # Both sides are smoothed: so many points of the grid are one.
    scatter = float(left @ left) / len(left) * max(1.0, grid_hz / (2 * STANCE_LOW_PASS_HZ * quick))
    error = math.sqrt(scatter * np.linalg.inv(columns.T @ columns)[0, 0]) / share[0]  # relative, of 1 / gamma
    if not error < SURE:
        return (NAN,) * 4
    return float(1 / share[0]), error / share[0], float(share[1] / share[0]), float(np.abs(share[2:]).max())


def mean_gain(evidence: Evidence, drawing: Drawing) -> tuple[float, float]:
    """What the gyroscopes read in the mean over what gravity turns by (1), and its standard error.

    Each place shows it, for how fast one gyroscope turns beside the other is known; the surer weighs more.
    """
    ratio = evidence.rate_ratio or NAN
    gains = []
    for gain, error, other in ((evidence.hip_gain, evidence.hip_gain_error, ratio),
                               (evidence.foot_gain, evidence.foot_gain_error, 1 / ratio)):  # fmt: skip
        if not math.isnan(gain):
            mean = gain if math.isnan(other) else 0.5 * gain * (1 + other)
            gains.append((mean, 1 / (max(error, drawing.swept_error) ** 2 + drawing.gain_error**2)))
    weight = sum(one for _, one in gains)
    return (sum(mean * one for mean, one in gains) / weight, weight**-0.5) if gains else (NAN, NAN)


def confirmed(evidence: Evidence, parameters: Parameters) -> tuple[float, float]:
    """Standard errors (1) of the gyroscopes' gain and of the leg's length, both taken as they are declared.

    They say how far what is declared is confirmed by what was found, with a standard error of its own.

    A gain found within two of its errors of 1 is confirmed to one; further off, and of a length, the square of the
    distance is that of what is declared wrong and of the error together. Two gyroscopes that differ are half as far off
    in the mean, whichever is right. A gain that nothing shows is any that the verdict lets through. A drawing that
    nothing shows is as good as it says.
    """
    drawing = parameters.drawing
    gain, sure = mean_gain(evidence, drawing)
    if math.isnan(gain):
        gain, sure = 1.0, parameters.limits.rate_scale_tolerance / math.sqrt(3)
    off = math.sqrt((gain - 1) ** 2 - sure**2) if abs(gain - 1) > 2 * sure else sure
    apart = 0.0 if math.isnan(evidence.rate_ratio) else 0.5 * abs(evidence.rate_ratio - 1)
    arm = next((one for one in (evidence.hip_arm, evidence.foot_arm) if not math.isnan(one)), 1.0)
    drawn = (arm - 1) ** 2 - drawing.swept_error**2 - drawing.gain_error**2
    return max(off, apart), math.sqrt(max(drawing.leg_length_error**2, drawn))
