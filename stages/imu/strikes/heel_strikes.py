"""Heel strikes in the signals of the inner leg.

The leg rolls backward while it stands and turns forward while it swings. It turns round shortly before it lands, and
again shortly after the other leg has landed: each turn has one heel strike near it, and its direction shows the leg.
The strike itself is a short pulse of specific force. Its time is then refined: all strikes of the same leg look alike
in all signals, and each is shifted until it lies best on the mean of them. A strike whose pulse fell into a hole of
the recording is expected between its neighbours and placed by what is left of it.
"""

import numpy as np
from scipy.ndimage import gaussian_filter1d, uniform_filter1d
from scipy.signal import find_peaks

from stages.imu.strikes.step_times import INNER, OUTER, HeelStrikes

PULSE_S = 0.015  # about the length of the pulse a heel strike leaves behind the sensor's low pass
WINDOW_S = (-0.05, 0.07)  # around a strike, for the template
SHIFTS_S = np.arange(-0.025, 0.0251, 0.001)
REFINEMENTS = 4
VARIANCE_FLOOR = 0.3  # of the median variance of the strikes: no point of the template decides alone
SMOOTHED = 5  # points of the template over which that variance is averaged
TINY = 1e-300
ROUNDED = 1e-3  # of the grid's step
SMOOTHED_STEPS = 0.06  # standard deviation of what smoothes a rate before its turns are looked for, in steps
SEARCH_STEPS = 0.3  # half width of the search around a turn, in steps
LOBE_STEPS = 0.45  # how soon before and after a turn the leg must have moved, in steps
REBOUND = 9  # pulses: after so many at most a rigid leg has rebounded
FAR = 3  # pulses from where a leg's blow usually is
FEWEST_SEEN = 2  # strikes of a leg, by which those of it that lie in holes are placed
FAINT = 0.6  # of a leg's median pulse: a fainter one is not the strike, which then lies in a hole
STILL = 0.1  # of the largest peak rate: below it the leg stands, however long it does
QUIET_RATE = 0.25  # of the typical peak rate: below it the leg does not walk


NO_STRIKES = HeelStrikes(np.empty(0), np.empty(0, dtype=np.int64))


def find_heel_strikes(
    time: np.ndarray, force: np.ndarray, lateral_rate: np.ndarray, others: np.ndarray, step_band_hz: tuple[float, float]
) -> HeelStrikes:
    """Heel strikes from an even grid (n,) [s]; NaN marks holes.

    force (n, k) [m/s^2] is searched for pulses; lateral_rate (n,) [rad/s] gives the turns of the inner leg; force and
    `others` (n, j), any further signals, refine the times. Of a leg of which too few strikes are seen, those that lie
    in holes are left out.
    """
    dt = spacing(time)
    period = step_period(lateral_rate, dt, step_band_hz)
    if not np.isfinite(period):
        return NO_STRIKES
    smooth = gaussian_filter1d(filled(lateral_rate), SMOOTHED_STEPS * period / dt)
    sharpness = pulse_sharpness(np.column_stack([filled(axis) for axis in force.T]), dt)
    half = max(1, int(SEARCH_STEPS * period / dt))
    found = turns(smooth, period, dt)
    if not found:
        return NO_STRIKES
    rows = np.array([first_blow(sharpness, max(0, turn - half), turn + half + 1, lag_of(dt)) for turn, _ in found])
    turned, leg = np.array(found).T
    for which in set(leg.tolist()):
        rows[leg == which] = where_usual(sharpness, rows[leg == which], turned[leg == which], lag_of(dt))
    reach = max(1, round(0.75 * PULSE_S / dt))
    at, hidden = time[rows], in_hole(force, rows, reach)
    signals = np.column_stack((force, others))
    placed = np.ones(len(rows), dtype=bool)
    for which in (INNER, OUTER):
        mine = leg == which
        height = sharpness[rows[mine]]
        hidden[mine] |= height < FAINT * np.median(height) if len(height) else False
        if mine.any():  # what is found instead of a blow in a hole is a rebound
            usual = turned[mine] + int(np.median(rows[mine] - turned[mine]))
            inside = usual.clip(0, len(time) - 1)
            off, beyond = np.abs(rows[mine] - usual) > lag_of(dt), usual != inside
            hidden[mine] |= off & (beyond | in_hole(force, inside, reach))
            placed[mine] = ~(off & beyond)  # its blow is not in the recording
        at[mine] = refine(time, signals, at[mine], hidden[mine], period)
        placed[mine] &= ~hidden[mine] | ((~hidden[mine]).sum() >= FEWEST_SEEN)
    at, leg = at[placed], leg[placed]
    order = np.argsort(at)
    return HeelStrikes(at[order], leg[order])


def spacing(time: np.ndarray) -> float:
    """Step of an even grid (n,) [s]; over all of it, as neighbours differ by what stamps since 1970 are rounded to."""
    return float(time[-1] - time[0]) / (len(time) - 1) if len(time) > 1 else 1.0


def first_blow(sharpness: np.ndarray, start: int, end: int, lag: int) -> int:
    """Row, from `start` to before `end`, of the first blow that is not faint, of those from which the largest may
    rebound: rigid legs do, and where both blows clip the second may look larger. A pulse begins to show a `lag` before
    its own row, of a slow sensor two. Where blows lie in holes the largest is none, and what is far before it neither.
    """
    largest = start + int(np.argmax(sharpness[start:end]))
    start = max(start, largest - REBOUND * lag)
    seen = sharpness[start:end]
    begun = int(np.argmax(seen >= FAINT * sharpness[largest]))
    return start + begun + int(np.argmax(seen[begun : begun + 2 * lag + 1]))


def where_usual(sharpness: np.ndarray, rows: np.ndarray, turned: np.ndarray, lag: int) -> np.ndarray:
    """Rows (s,) of a leg's blows, each where those after its turns (s,) usually are if one that is not faint is there:
    what stands out far from there is a wrong reading."""
    usual = (turned + int(np.median(rows - turned))).clip(0, len(sharpness) - 1)
    starts = np.maximum(usual - lag, 0)
    near = np.array([start + np.argmax(sharpness[start : one + lag + 1]) for start, one in zip(starts, usual)])
    blown = sharpness[near] >= FAINT * np.median(sharpness[rows])
    return np.where((np.abs(rows - usual) > FAR * lag) & blown, near, rows)


def in_hole(force: np.ndarray, rows: np.ndarray, reach: int) -> np.ndarray:
    """Whether each row (s,) has a hole of the signals within `reach` rows."""
    hole = ~np.isfinite(force).all(axis=1)
    count = np.append(0, np.cumsum(hole))
    return np.asarray(count[np.minimum(rows + reach + 1, len(hole))] > count[np.maximum(rows - reach, 0)])


def expect_hidden(at: np.ndarray, hidden: np.ndarray, period: float) -> np.ndarray:
    """Times of one leg's strikes with those hidden in a hole put where the others expect them, two steps apart."""
    seen = np.flatnonzero(~hidden)
    if not hidden.any() or len(seen) < FEWEST_SEEN:
        return at
    number = np.append(0, np.cumsum(np.maximum(1, np.rint(np.diff(at) / (2 * period)))))
    expected = at.copy()
    for i in np.flatnonzero(hidden):
        near = seen[np.argsort(np.abs(number[seen] - number[i]), kind="stable")[:4]]
        offset = np.polyfit(number[near] - number[i], at[near], 1)[1]
        if abs(offset - at[i]) < 0.5 * period:
            expected[i] = offset
    return expected


def step_period(lateral_rate: np.ndarray, dt: float, step_band_hz: tuple[float, float]) -> float:
    """Duration of a step [s]: half the lag of the first peak of the rate's autocorrelation in the band; NaN if none."""
    x = filled(lateral_rate - np.nanmean(lateral_rate)) if np.isfinite(lateral_rate).any() else np.zeros(1)
    shortest, longest = (int(2 / f / dt) for f in reversed(step_band_hz))
    spectrum = np.abs(np.fft.rfft(x, 2 * len(x))) ** 2
    correlation = np.fft.irfft(spectrum)[: min(len(x), longest + 2)]
    peaks, _ = find_peaks(correlation[shortest:])
    peaks = peaks[correlation[shortest + peaks] > 0.2 * correlation[0]] + shortest
    if not len(peaks):
        return float("nan")
    strong = correlation[peaks] > 0.8 * correlation[peaks].max()
    return float(peaks[strong][0] * dt / 2)


def filled(signal: np.ndarray) -> np.ndarray:
    """A signal (n,) with its holes drawn over by straight lines: for finding periods, never for curves."""
    known = np.isfinite(signal)
    if known.all() or not known.any():
        return np.where(known, signal, 0.0)
    row = np.arange(len(signal))
    return np.asarray(np.interp(row, row[known], signal[known]))


def lag_of(dt: float) -> int:
    """Rows of a grid with this step [s] that a pulse lasts."""
    return max(1, round(PULSE_S / dt))


def pulse_sharpness(force: np.ndarray, dt: float) -> np.ndarray:
    """How far the force (n, k) stands out against itself a pulse length earlier and later, (n,) [m/s^2]."""
    lag = lag_of(dt)
    sharpness = np.zeros(len(force))
    if len(force) > 2 * lag:
        sharpness[lag:-lag] = np.linalg.norm(2 * force[lag:-lag] - force[2 * lag :] - force[: -2 * lag], axis=1)
    return sharpness


def turns(rate: np.ndarray, period: float, dt: float) -> list[tuple[int, int]]:
    """Rows where the walking leg turns round, each with the leg that lands there."""
    peaks = np.abs(rate[find_peaks(np.abs(rate), distance=max(1, int(0.5 * period / dt)))[0]])
    if not len(peaks):
        return []
    enough = max(QUIET_RATE * np.quantile(peaks, 0.75), STILL * peaks.max())
    reach = max(1, int(LOBE_STEPS * period / dt))
    found = []
    for turn in np.flatnonzero(rate[1:] * rate[:-1] < 0):
        direction = np.sign(rate[turn])
        before, after = rate[max(0, turn - reach) : turn + 1], rate[turn + 1 : turn + 1 + reach]
        if (direction * before).max() > enough and (-direction * after).max() > enough:
            found.append((int(turn), INNER if direction > 0 else OUTER))
    return found


def refine(
    time: np.ndarray, signals: np.ndarray, at: np.ndarray, hidden: np.ndarray, period: float
) -> np.ndarray:
    """Times (s,) shifted so that the signals (n, k) around each lie best, in least squares, on the mean of all.

    The mean is that of the strikes that were seen, and their mean shift is kept at zero: what is refined is the
    spacing of the strikes. Each point of the mean counts by the inverse of the strikes' variance there, so that what
    repeats decides, not the transient of the walk or the part of the pulse that sampling cuts differently each time.
    Those hidden in a hole are moved from where the others, as they lie by then, expect them.
    """
    seen = ~hidden
    if seen.sum() < FEWEST_SEEN:
        return at
    dt = spacing(time)
    offset = dt * np.arange(round(WINDOW_S[0] / dt), round(WINDOW_S[1] / dt))
    around = np.moveaxis(_windows(time, signals, at[seen, None] + offset), -1, 0)
    scale = np.array([np.std(signal[np.isfinite(signal)]) if np.isfinite(signal).any() else 0.0 for signal in around])
    scaled = signals / np.where(scale > 0, scale, 1.0)
    found = at
    for number in range(REFINEMENTS):
        at = expect_hidden(np.where(hidden, found, at), hidden, period)
        _, template, scatter = mean_and_variance(_windows(time, scaled, at[seen, None] + offset))
        worst = np.nanmax(scatter) if np.isfinite(scatter).any() else 1.0
        known = np.where(np.isfinite(scatter), scatter, worst)
        variance = uniform_filter1d(known, SMOOTHED, axis=0, mode="nearest")
        # The first round's variance is that of strikes not yet laid over each other.
        weight = 1 / (variance + VARIANCE_FLOOR * np.median(variance) + TINY) if number else np.ones_like(variance)
        moved = np.array([_best_shift(time, scaled, t + offset, template, weight) for t in at])
        at = at + moved - moved[seen].mean()
    return at


def mean_and_variance(curves: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How many of curves (s, w, k) are known at each point, their mean and their variance; NaN where too few are."""
    known = np.isfinite(curves)
    count = known.sum(axis=0)
    mean = np.where(count > 0, np.where(known, curves, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan)
    square = np.where(known, (curves - mean) ** 2, 0.0).sum(axis=0)
    return count, mean, np.where(count > 1, square / np.maximum(count - 1, 1), np.nan)


def _windows(time: np.ndarray, signals: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Signals at the wanted times, by straight lines on the grid: shape wanted.shape + (k,).

    What is so near to a point of the grid as stamps since 1970 are rounded is at it: else that rounding would decide
    whether the hole beside it counts.
    """
    rows = (wanted - time[0]) / spacing(time)
    at = np.rint(rows)
    rows = np.where(np.abs(rows - at) < ROUNDED, at, rows)
    return np.stack([np.interp(rows, np.arange(len(time)), axis, left=np.nan, right=np.nan) for axis in signals.T], -1)


def _best_shift(
    time: np.ndarray, signals: np.ndarray, window: np.ndarray, template: np.ndarray, weight: np.ndarray
) -> float:
    """Shift [s] at which the signals lie best on the template, refined by a parabola; 0 where little is left."""
    error = (_windows(time, signals, window + SHIFTS_S[:, None]) - template) ** 2
    known = np.isfinite(error)
    enough = known.sum(axis=(1, 2)) >= 0.25 * template.size
    weighed = np.nansum(weight * error, axis=(1, 2)) / np.maximum((weight * known).sum(axis=(1, 2)), TINY)
    return float(np.nan_to_num(lowest(np.where(enough, weighed, np.inf), SHIFTS_S)))


def lowest(cost: np.ndarray, at: np.ndarray) -> float:
    """Where of even places (n,) a cost (n,) is lowest, refined by a parabola; NaN at an end and beside one that is not
    known."""
    best = int(np.argmin(cost))
    if not 0 < best < len(cost) - 1 or not np.isfinite(cost[best - 1 : best + 2]).all():
        return float("nan")
    return float(at[best] + lowest_between(cost, best) * (at[1] - at[0]))


def lowest_between(cost: np.ndarray, best: int) -> float:
    """Where the parabola through a cost (n,) and its two neighbours is lowest, in steps from it; 0 for no minimum."""
    left, middle, right = cost[best - 1 : best + 2]
    curvature = left - 2 * middle + right
    return float(0.5 * (left - right) / curvature) if curvature > 0 else 0.0
