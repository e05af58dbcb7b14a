"""Heel strikes in the signals of the inner leg.

The leg turns backward while it stands and forward while it swings, so its rate changes sign near every heel strike:
from forward to backward when the inner leg lands, from backward to forward when the outer one does. The strike itself
is where the specific force changes fastest near that crossing. Its time is then refined: all strikes of the same leg
look alike, and each is shifted until it lies best on the mean of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

INNER, OUTER = 0, 1
WINDOW_S = (-0.05, 0.07)  # around a strike, for the template
REFINEMENTS = 4
SEARCH_STEPS = 0.3  # half width of the search around a crossing, in steps
QUIET_RATE = 0.25  # of the typical peak rate: below it the leg does not walk


@dataclass(frozen=True)
class HeelStrikes:
    """Times (s,) [s] of heel strikes and the leg (s,) that lands: 0 the inner one, 1 the outer one."""

    time: np.ndarray
    leg: np.ndarray


NO_STRIKES = HeelStrikes(np.empty(0), np.empty(0, dtype=np.int64))


def find_heel_strikes(
    time: np.ndarray, force: np.ndarray, lateral_rate: np.ndarray, step_band_hz: tuple[float, float]
) -> HeelStrikes:
    """Heel strikes from an even grid: specific force (n, k) [m/s^2], rate about the lateral axis (n,) [rad/s]; NaN allowed."""
    dt = time[1] - time[0] if len(time) > 1 else 1.0
    period = step_period(lateral_rate, dt, step_band_hz)
    if not np.isfinite(period):
        return NO_STRIKES
    smooth = gaussian_filter1d(filled(lateral_rate), 0.06 * period / dt)
    change = change_of_force(force, dt)
    crossings = _crossings(smooth, period, dt)
    half = max(1, int(SEARCH_STEPS * period / dt))
    rows, legs = [], []
    for crossing, leg in crossings:
        window = change[max(0, crossing - half) : crossing + half + 1]
        if np.isfinite(window).any():
            rows.append(max(0, crossing - half) + int(np.nanargmax(window)))
            legs.append(leg)
    if not rows:
        return NO_STRIKES
    at, leg = time[rows], np.array(legs)
    for which in (INNER, OUTER):
        at[leg == which] = refine(time, force, at[leg == which])
    order = np.argsort(at)
    return HeelStrikes(at[order], leg[order])


def step_period(lateral_rate: np.ndarray, dt: float, step_band_hz: tuple[float, float]) -> float:
    """Duration of a step [s]: half the lag of the first peak of the rate's autocorrelation in the band; NaN if none."""
    x = filled(lateral_rate - np.nanmean(lateral_rate)) if np.isfinite(lateral_rate).any() else np.zeros(1)
    shortest, longest = (int(2 / f / dt) for f in reversed(step_band_hz))
    if len(x) < shortest + 3 or not x.any():
        return float("nan")
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
    return np.interp(row, row[known], signal[known])


def change_of_force(force: np.ndarray, dt: float) -> np.ndarray:
    """Magnitude (n,) of the rate of change of specific force [m/s^3]; NaN beside a hole."""
    change = np.full(len(force), np.nan)
    change[1:-1] = np.linalg.norm(force[2:] - force[:-2], axis=1) / (2 * dt)
    return change


def _crossings(rate: np.ndarray, period: float, dt: float) -> list[tuple[int, int]]:
    """Rows where the walking leg turns round, with the leg that lands there."""
    peaks = np.abs(rate[find_peaks(np.abs(rate), distance=max(1, int(0.5 * period / dt)))[0]])
    if not len(peaks):
        return []
    typical = np.quantile(peaks, 0.75)
    sign = np.sign(rate)
    turns = np.flatnonzero(sign[1:] * sign[:-1] < 0)
    reach = int(0.6 * period / dt)
    found = []
    for turn in turns:
        before, after = rate[max(0, turn - reach) : turn + 1], rate[turn + 1 : turn + 1 + reach]
        if min(np.abs(before).max(), np.abs(after).max() if len(after) else 0.0) > QUIET_RATE * typical:
            found.append((int(turn), INNER if rate[turn] > 0 else OUTER))
    return found


def refine(time: np.ndarray, force: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Times shifted so that the force around each strike lies best, in least squares, on the mean of all of them.

    The mean shift is kept at zero: what is refined is the spacing of the strikes.
    """
    if len(at) < 3:
        return at
    dt = time[1] - time[0]
    offset = np.arange(WINDOW_S[0], WINDOW_S[1], dt)
    shifts = np.arange(-0.012, 0.0121, 0.001)
    for _ in range(REFINEMENTS):
        windows = _windows(time, force, at[:, None] + offset)
        count = np.isfinite(windows).all(axis=2).sum(axis=0)
        template = np.nansum(windows, axis=0) / np.maximum(count, 1)[:, None]
        template[count == 0] = np.nan
        moved = np.array([_best_shift(time, force, t + offset, template, shifts) for t in at])
        at = at + moved - moved.mean()
    return at


def _windows(time: np.ndarray, force: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Force at the wanted times, by straight lines on the grid: shape wanted.shape + (k,)."""
    return np.stack([np.interp(wanted, time, axis, left=np.nan, right=np.nan) for axis in force.T], axis=-1)


def _best_shift(
    time: np.ndarray, force: np.ndarray, window: np.ndarray, template: np.ndarray, shifts: np.ndarray
) -> float:
    error = ((_windows(time, force, window + shifts[:, None]) - template) ** 2).sum(axis=2)
    seen = np.isfinite(error).sum(axis=1)
    cost = np.where(seen >= 0.5 * len(window), np.nansum(error, axis=1) / np.maximum(seen, 1), np.inf)
    best = int(np.argmin(cost))
    if not 0 < best < len(shifts) - 1 or not np.isfinite(cost[best - 1 : best + 2]).all():
        return float(shifts[best]) if np.isfinite(cost[best]) else 0.0
    left, middle, right = cost[best - 1 : best + 2]
    curvature = left - 2 * middle + right
    return float(shifts[best] + (0.5 * (left - right) / curvature if curvature > 0 else 0.0) * (shifts[1] - shifts[0]))


@dataclass(frozen=True)
class StepFrequency:
    """Steps per second [Hz] with its standard error [Hz] and the number of heel strikes behind it."""

    value: float
    standard_error: float
    strikes: int


def step_frequency(strikes: HeelStrikes) -> StepFrequency:
    """Frequency from a straight line through the strike times, with an offset of its own for each leg.

    Strikes are numbered by whole steps, so a strike that was missed does not count as a long step.
    """
    if len(strikes.time) < 4:
        return StepFrequency(float("nan"), float("nan"), len(strikes.time))
    step = np.diff(strikes.time)
    number = np.append(0, np.cumsum(np.maximum(1, np.rint(step / np.median(step)))))
    columns = np.column_stack((np.ones(len(number)), number, strikes.leg))
    if len(set(strikes.leg.tolist())) == 1:
        columns = columns[:, :2]
    solution, _, _, _ = np.linalg.lstsq(columns, strikes.time, rcond=None)
    residual = strikes.time - columns @ solution
    variance = residual @ residual / max(1, len(number) - columns.shape[1])
    period_error = np.sqrt(variance * np.linalg.pinv(columns.T @ columns)[1, 1])
    return StepFrequency(1 / solution[1], float(period_error / solution[1] ** 2), len(number))
