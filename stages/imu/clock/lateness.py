"""The floor of lateness: what a fitted clock cannot hide, and how stamps of a clock that was set are straightened.

A packet can be late, never early, and in any stretch of a recording some packet was hardly late. So the least lateness
of a window, above a clock that is right, is the radio's smallest delay, the same in every window. Where these floors
are not level the clock that was fitted is not the one that the sensor kept: the difference between the highest and the
lowest floor is its error, up to what radio alone does to the least of so many packets.

The phone's clock may be set while it runs (network time), which lifts or drops all stamps from then on: the floor has
a step. A sensor's oscillator may wander, which bends the floor. Both are taken out where the samples are numbered.

So the arrival stamps lie above the line t = a + b * index that a loss-free radio of constant delay would draw, and that
line is the highest one below all stamps: the linear program

    maximise  sum_i (a + b n_i)   subject to   a + b n_i <= t_i,

whose solution is the edge of the lower convex hull that spans the mean index (two unknowns: the optimum lies on
two stamps). It holds however the lateness is distributed, where least squares is pulled up by every stall.
The smallest delay of the radio stays in `a`: it cannot be observed from the stamps.
"""

from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np
from numpy.polynomial import Polynomial
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import minimum_filter1d

HUBER_WIDTH, REWEIGHTED = 1.345, 30  # 95 % efficiency for normal errors (Huber 1981); rounds
A_WINDOW = 40  # moments of arrival, of which the least late is late by a fortieth of the mean, if exponential
SHORT_WINDOW = 20
FEWEST_MOMENTS = 20  # below this two windows say nothing
FEWEST_WINDOWS, MOST_WINDOWS = 4, 24
A_KNOT = 100  # a bend is drawn through floors that know better than to follow the radio
FEWEST_KNOTS = 6
MOST_STEPS = 12
LONGEST_LAG = 2000  # moments; the median rate over a lag is blind to the few lags that hold a setting
LEAST_PIECE = 60  # moments between two settings of a clock: a shorter piece fits any rate
RATE_SEARCH = 0.05  # about a first guess of the rate, which a setting of the clock may have tilted
STEP_DOUBT = 1.5  # rate and steps are found from the same stamps: the floor shows less of their error
GOLDEN = (5**0.5 - 1) / 2
SECTIONS = 40
QUEUED = 0.25  # of the mean time between arrivals: a packet that comes sooner after another waited behind it


def lower_envelope(index: np.ndarray, stamp: np.ndarray) -> Polynomial:
    """The highest line below all points, in the mean; exact, O(n log n). Needs two different indices."""
    order = np.lexsort((stamp, index))
    x, y = index[order].astype(float), stamp[order]
    first = np.append(True, np.diff(x) > 0)
    x, y = x[first], y[first]
    corner, inside = np.arange(len(x)), np.zeros(len(x), dtype=bool)
    # A point on or above the chord of its neighbours is no corner. Without all of those at once, others are; each such
    # pass leaves half of what noise has put there.
    while len(corner := corner[~inside]) > 2:
        p, q, r = corner[:-2], corner[1:-1], corner[2:]
        inside = np.zeros(len(corner), dtype=bool)
        inside[1:-1] = (y[q] - y[p]) * (x[r] - x[p]) >= (y[r] - y[p]) * (x[q] - x[p])
        if not inside.any():
            break
    right = int(np.clip(np.searchsorted(x[corner], index.mean()), 1, len(corner) - 1))
    p, q = corner[right - 1], corner[right]
    period = (y[q] - y[p]) / (x[q] - x[p])
    return Polynomial([y[p] - period * x[p], period])


def least_squares_line(index: np.ndarray, stamp: np.ndarray, weight: np.ndarray | None = None) -> Polynomial:
    """Weighted least-squares line through the points."""
    w = np.ones(len(index)) if weight is None else weight
    x0, y0 = np.average(index, weights=w), np.average(stamp, weights=w)
    dx = index - x0
    period = float(np.sum(w * dx * (stamp - y0)) / np.sum(w * dx * dx))
    return Polynomial([y0 - period * x0, period])


def robust_line(index: np.ndarray, stamp: np.ndarray) -> Polynomial:
    """Huber's M-estimate of the line by iteratively reweighted least squares, scale from the median deviation."""
    line = least_squares_line(index, stamp)
    for _ in range(REWEIGHTED):
        residual = stamp - line(index)
        size = np.abs(residual - np.median(residual))
        scale = max(1.4826 * float(np.median(size)), 1e-9)
        line = least_squares_line(index, stamp, 1.0 / np.maximum(1.0, size / (HUBER_WIDTH * scale)))
    return line


def moments(y: np.ndarray) -> np.ndarray:
    """The last packet (k,) of each moment of arrival: those before it waited, for it or behind a stalled one.

    A stall, or an upload, is one piece of evidence, not many.
    """
    between = np.diff(y)
    whole = between[np.abs(between) < 0.5 * np.ptp(y)] if len(between) else between  # not the setting of a clock
    usual = float(np.mean(whole)) if len(whole) else 0.0
    together = (between >= 0) & (between < QUEUED * usual)
    return np.flatnonzero(np.append(~together, True))


def floors(x: np.ndarray, late: np.ndarray, moments: int, most: int) -> np.ndarray:
    """Index and lateness of the least late of each window, and how much later the next one is: (w, 3) of (n,)."""
    windows = np.array_split(np.arange(len(x)), int(np.clip(len(x) // moments, FEWEST_WINDOWS, most)))
    least, next_least = np.array([rows[np.argsort(late[rows])[[0, min(1, len(rows) - 1)]]] for rows in windows]).T
    return np.column_stack((x[least], late[least], late[next_least] - late[least]))


def unevenness(x: np.ndarray, late: np.ndarray, moments: int = A_WINDOW, most: int = MOST_WINDOWS) -> float:
    """Height [s] of the highest floor above the lowest one, and the usual doubt of a floor: how near its next is.

    x, late (n,): one for each moment of arrival; NaN for too few.
    """
    if len(x) < FEWEST_MOMENTS:
        return float("nan")
    found = floors(x, late, moments, most)
    return float(np.ptp(found[:, 1]) + np.median(found[:, 2]))


@dataclass(frozen=True)
class Straightened:
    """Arrivals on one clock: `line` below them, `steps` the settings of the clock, `bend` the knots (k, 2) of its
    departure from the line [s] (empty: none), and `error` the unevenness of the floor that is left [s].

    `steps` (s, 2): index of the first packet with it, and by how much the clock was put on [s].
    """

    line: Polynomial
    steps: np.ndarray
    bend: np.ndarray
    error: float

    @property
    def period(self) -> float:
        """Of the line [s]."""
        return float(self.line.coef[1])

    def bent(self, index: np.ndarray) -> np.ndarray:
        """Departure of the sensor's clock from the line at these indices (n,) [s]."""
        if not len(self.bend):
            return np.zeros(len(index))
        inside = np.clip(index, self.bend[0, 0], self.bend[-1, 0])
        return np.asarray(PchipInterpolator(self.bend[:, 0], self.bend[:, 1])(inside))


def put_on(steps: np.ndarray, x: np.ndarray) -> np.ndarray:
    """By how much a clock with these `steps` had been put on at packets of these indices (n,) [s]."""
    return np.asarray((steps[:, 1] * (x[:, None] >= steps[:, 0])).sum(axis=1))


def straighten(x: np.ndarray, y: np.ndarray, tolerance: float, numbered: bool) -> Straightened:
    """One clock for arrivals y (n,) [s] at increasing indices x (n,).

    Settings and bends are looked for only where the floor is uneven by more than `tolerance` [s], and only in samples
    that are `numbered`: among samples that are merely counted, a loss looks like a clock that was put on.
    """
    none = np.empty((0, 2))
    plain = _judged(x, y, none)
    if not numbered or not plain.error > tolerance:
        return plain
    steps = found_steps(x, y, tolerance)
    tried = [plain, _bent(x, y, none), *((_judged(x, y, steps), _bent(x, y, steps)) if len(steps) else ())]
    first: Straightened = min(tried, key=attrgetter("error"))
    return next((one for one in tried if one.error <= tolerance), first)


def _judged(x: np.ndarray, y: np.ndarray, steps: np.ndarray) -> Straightened:
    """The line below the arrivals once the steps are taken out, with its error."""
    level, free = y - put_on(steps, x), moments(y)
    line = lower_envelope(x, level)
    late = (level - line(x))[free]
    error = unevenness(x[free], late)
    if len(steps):
        # With the freedom of a step a wrong rate may hide inside of windows: judged by shorter ones as well.
        error = max(STEP_DOUBT * error, unevenness(x[free], late, SHORT_WINDOW))
    return Straightened(line, steps, np.empty((0, 2)), error)


def _bent(x: np.ndarray, y: np.ndarray, steps: np.ndarray) -> Straightened:
    """The same with a bend through the floors, judged by windows that are not those of its knots."""
    straight, free = _judged(x, y, steps), moments(y)
    most = min(MOST_WINDOWS, len(free) // A_KNOT)
    if most < FEWEST_KNOTS:
        return straight
    late = (y - put_on(steps, x) - straight.line(x))[free]
    bent = replace(straight, bend=floors(x[free], late, A_KNOT, most)[:, :2])
    left = unevenness(x[free], late - bent.bent(x[free]), A_KNOT // 2, 2 * most - 1)
    return replace(bent, error=left * (STEP_DOUBT if len(steps) else 1.0))


def found_steps(x: np.ndarray, y: np.ndarray, tolerance: float) -> np.ndarray:
    """Settings (s, 2) of the clock behind arrivals, as in `Straightened.steps`.

    The floor of the packets before and after a place differs by the setting there; the largest difference is a
    setting, then the largest that is a piece away from it, and so on while they exceed twice the `tolerance`.
    """
    free = moments(y)
    x, y = x[free], y[free]
    count, piece = len(x), LEAST_PIECE
    if count < 2 * piece:
        return np.empty((0, 2))
    apart = int(np.clip(count // 4, 1, LONGEST_LAG))
    period = float(np.median((y[apart:] - y[:-apart]) / (x[apart:] - x[:-apart])))
    above = y - period * x
    before = minimum_filter1d(above, piece, origin=(piece - 1) // 2)  # of the rows up to and with this one
    after = minimum_filter1d(above, piece, origin=-(piece // 2))  # of the rows from this one on
    jump = np.append(0.0, after[1:] - before[:-1])
    jump[:piece] = jump[count - piece :] = 0.0
    starts: list[int] = []
    while len(starts) < MOST_STEPS and np.abs(jump).max() > 2 * tolerance:
        about = int(np.argmax(np.abs(jump)))
        near = slice(max(0, about - piece), about + piece)
        starts.append(near.start + _placed(above[near]))
        jump[near] = 0.0
    bounds = np.unique([0, *starts, count])
    sizes = np.diff(one_rate(x, y, bounds, period))
    # A moment stands under its last packet: the setting comes after the last one of the moment before.
    return np.column_stack((x[bounds[1:-1] - 1] + 1, sizes))[np.abs(sizes) > tolerance]


def _placed(above: np.ndarray) -> int:
    """First row of those (n,) behind a step: where two levels below the rows leave them the least height in all."""
    row = np.arange(1, len(above))
    before, after = np.minimum.accumulate(above)[:-1], np.minimum.accumulate(above[::-1])[::-1][1:]
    return int(row[np.argmax(row * before + (len(above) - row) * after)])


def one_rate(x: np.ndarray, y: np.ndarray, bounds: np.ndarray, about: float) -> np.ndarray:
    """Heights (p,) of parallel lines below the arrivals of each piece between `bounds` (p + 1,): least lateness in all.

    The sum of the heights of lower bounds of one slope is a concave function of the slope: golden section.
    """
    middle, weight = x.mean(), np.diff(bounds)

    def heights(period: float) -> np.ndarray:
        return np.minimum.reduceat(y - period * (x - middle), bounds[:-1])

    low, high = about * (1 - RATE_SEARCH), about * (1 + RATE_SEARCH)
    for _ in range(SECTIONS):
        left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        better_left = weight @ heights(left) > weight @ heights(right)
        low, high = (low, right) if better_left else (left, high)
    return heights((low + high) / 2)
