"""What a solver left step by step, at any time between its steps, where it is largest, and when it is sampled.

A largest value is where the derivative vanishes between the steps, or at an end. A value at an event is taken at the
event, on either side of it: what jumps or has a kink is looked at piece by piece.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial.polynomial import Polynomial, polyder, polyval

# Nodes and weights of Gauss quadrature on [0, 1], exact to degree 9: the integrands are smooth between solver steps.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(5)
NODES, WEIGHTS = 0.5 * (NODES + 1.0), 0.5 * WEIGHTS
#: Times that are looked up at once: what is computed of so many stays in the processor's cache.
BLOCK = 1024


def hermite(
    steps: np.ndarray, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray | None, time: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity at times (m,) [s], each (m, k), from those at the solver's `steps` (n,) [s], each (n, k).

    By Hermite interpolation: quintic with the accelerations, cubic without.
    """
    if len(time) > BLOCK:
        place, rate = (np.empty((len(time), position.shape[1])) for _ in range(2))
        for begin in range(0, len(time), BLOCK):
            block = slice(begin, begin + BLOCK)
            place[block], rate[block] = hermite(steps, position, velocity, acceleration, time[block])
        return place, rate
    i = np.clip(np.searchsorted(steps, time, side="right") - 1, 0, len(steps) - 2)
    step = (steps[i + 1] - steps[i])[:, None]
    return _polynomial(i, step, position, velocity, acceleration)((time - steps[i])[:, None] / step)


def hermite_from(
    row: int, steps: np.ndarray, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray | None
) -> Callable[[float], tuple[np.ndarray, np.ndarray]]:
    """What `hermite` gives at a time [s] from step number `row` to the next, each (k,): for roots, where many times are
    requested one after another.
    """
    begin, end = float(steps[row]), float(steps[row + 1])
    at = _polynomial(row, end - begin, position, velocity, acceleration)
    return lambda time: at((time - begin) / (end - begin)) if time < end else (position[row + 1], velocity[row + 1])


def _polynomial(
    i: Any, step: Any, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray | None
) -> Callable[[Any], tuple[np.ndarray, np.ndarray]]:
    """Position and velocity, by the share of the way from steps `i` to the next, which take `step` [s]."""
    start, rise = position[i], position[i + 1] - position[i]
    a1, b1 = velocity[i] * step, velocity[i + 1] * step
    if acceleration is not None:
        a2, b2 = 0.5 * acceleration[i] * step**2, 0.5 * acceleration[i + 1] * step**2
        c3 = 10 * rise - 6 * a1 - 4 * b1 - 3 * a2 + b2
        c4 = -15 * rise + 8 * a1 + 7 * b1 + 3 * a2 - 2 * b2
        c5 = 6 * rise - 3 * a1 - 3 * b1 - a2 + b2
    else:
        a2 = 3 * rise - 2 * a1 - b1
        c3 = -2 * rise + a1 + b1
        c4 = c5 = 0.0 * rise

    def at(s: Any) -> tuple[np.ndarray, np.ndarray]:
        place = start + s * (a1 + s * (a2 + s * (c3 + s * (c4 + s * c5))))
        rate = (a1 + s * (2 * a2 + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))) / step
        return place, rate

    return at


def quadrature(steps: np.ndarray, start: float, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and weights [s] that integrate from start to end: five of them, in order, in every span of the steps."""
    inner = steps[(steps > start) & (steps < end)]
    bounds = np.concatenate([[start], inner, [end]])
    span = np.diff(bounds)
    return (bounds[:-1, None] + span[:, None] * NODES).ravel(), (span[:, None] * WEIGHTS).ravel()


def acting(
    at_start: tuple[bool, bool], switches: tuple[tuple[float, int, bool], ...], time: np.ndarray
) -> np.ndarray:
    """Which of two legs (or pairs of legs) the ground acts on at the times [s], (n, 2), from when that changed."""
    held = np.tile(np.array(at_start), (len(time), 1))
    for moment, leg, acts in switches:
        held[time >= moment, leg] = acts
    return held


def running_integral(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Integral of values (n,) from the first of their times (n,) [s] to each, straight between them.

    As `scipy.integrate.cumulative_trapezoid`, which takes half a second to load.
    """
    return np.append(0.0, np.cumsum(np.diff(time) * (values[1:] + values[:-1]) / 2.0))


if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

#: Times close around the first guess at which a solution is evaluated once more.
AROUND = 9
#: A spline is drawn through no fewer samples.
FEWEST = 4
#: A top is a kink where a quartic through values around it is level below it, by this part of what they span.
KINK = 1e-3
#: Rows that a quartic goes through, and Newton's iterations to where its derivative vanishes.
ROWS, NEWTON = 5, 6
#: Events this close, as a part of all time, are one: those of two models that differ by round-off.
SAME = 1e-9

Solution = Callable[[np.ndarray], np.ndarray]


def through(time: np.ndarray, values: np.ndarray) -> CubicSpline:
    """The cubic spline through values at rising times. SciPy is loaded by who needs it, not by who reads a result."""
    from scipy.interpolate import CubicSpline

    return CubicSpline(time, values)


def turning(spline: CubicSpline) -> tuple[np.ndarray, np.ndarray]:
    """Times (m,) where the derivative of a cubic spline is zero, and its values there."""
    inside = spline.derivative().roots(extrapolate=False)
    inside = np.unique(inside[np.isfinite(inside)])
    return inside, np.asarray(spline(inside))


def largest(time: np.ndarray, values: np.ndarray, at: Solution) -> tuple[float, float]:
    """When [s], and how large: the largest of a quantity known at rising times (n,), both ends included.

    `at` gives it at rising times of one's own, from the solution itself: at the largest turning point of the
    spline through the values, once more at those of a spline through times close around that one, and where a quartic
    through these is level.
    """
    for width in (1.0, 0.25):
        top = int(np.argmax(values))
        when, value = float(time[top]), float(values[top])
        rising = np.diff(time, prepend=-np.inf) > 0.0
        if rising.sum() < FEWEST or not np.isfinite(values).all():
            return when, value
        inside, higher = turning(through(time[rising], values[rising]))
        guess = np.append(inside, when)[np.argmax(np.append(higher, value))]
        if guess == when and width == 1.0:
            return when, value
        row = min(int(np.searchsorted(time, guess, side="right")), len(time) - 1)
        reach = width * (time[row] - time[row - 1])
        near = np.linspace(max(time[0], guess - reach), min(time[-1], guess + reach), AROUND)
        time = np.unique(np.concatenate([near, [guess, when]]))
        values = at(time)
    top = int(np.argmax(values))
    level = Polynomial.fit(time, values, ROWS - 1).deriv().roots().real
    level = level[(level > time[0]) & (level < time[-1])]
    if level.size:  # not at a kink, where the curve through the values is level below them
        nearest = level[[np.argmin(np.abs(level - time[top]))]]
        if (value := at(nearest)[0]) >= values[top] - KINK * np.ptp(values):
            return float(nearest[0]), float(value)
    return float(time[top]), float(values[top])


def spans_above(time: np.ndarray, values: np.ndarray, at: Solution) -> list[tuple[float, float]]:
    """The spans (start, end) in which a quantity as in `largest` is above zero, by its roots between the times."""
    from scipy.optimize import brentq

    above = values > 0.0
    edges = [float(time[0])] if above[0] else []
    for row in np.flatnonzero(above[1:] != above[:-1]):
        edges.append(float(brentq(lambda when: float(at(np.array([when]))[0]), time[row], time[row + 1], xtol=1e-15)))
    edges += [float(time[-1])] if above[-1] else []
    return [(start, end) for start, end in zip(edges[::2], edges[1::2], strict=True) if end > start]


def time_above(time: np.ndarray, values: np.ndarray, limit: float) -> float:
    """How long [s] values (n,), straight between their times (n,), are above a limit."""
    over = values - limit
    first, last = over[:-1], over[1:]
    both = np.abs(first) + np.abs(last)
    shares = (np.maximum(first, 0.0) + np.maximum(last, 0.0)) / np.where(both > 0.0, both, 1.0)
    return float(np.diff(time) @ shares)


def sampled_at(
    time: np.ndarray, values: np.ndarray, events: np.ndarray, wanted: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Sampled signals (n, k) at wanted rising times [s], and twice at each event among them: on both of its sides.

    By cubic splines from event to event, where signals are smooth: the error falls with the spacing's fourth power.
    Events nearer than two samples leave no more than a straight line between samples. Gives the times (m,), equal ones
    where values may jump, and the values (m, k).
    """
    first, last = wanted[0], wanted[-1]
    cuts = np.unique(events)
    cuts = cuts[np.diff(cuts, prepend=-np.inf) > SAME * (last - first)]
    times, found = [], []
    for begin, finish in pairwise([-np.inf, *cuts, np.inf]):
        inside = (time >= begin) & (time < finish)
        if finish <= first or begin >= last:
            continue
        sides = np.concatenate([[begin], wanted[(wanted > begin) & (wanted < finish)], [finish]])
        times.append(at := sides[(sides >= first) & (sides <= last)])
        found.append(through(time[inside], values[inside])(at) if inside.sum() >= 2 else
                     np.column_stack([np.interp(at, time, column) for column in values.T]))
    return np.concatenate(times), np.concatenate(found)


def largest_sampled(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Largest values (k,) of signals (n, k) known at times (n,) [s], both ends included; of two equal times one is just
    before an event, the other just after it.

    Where the largest row is no end and no side of an event, by the quartic through five rows around it.
    """
    top, columns = np.argmax(values, axis=0), np.arange(values.shape[1])
    found: np.ndarray = values[top, columns]
    breaks = np.concatenate([[0], 1 + np.flatnonzero(np.diff(time) <= 0.0), [len(time)]])
    piece = np.searchsorted(breaks, top, side="right")
    first, last = breaks[piece - 1], breaks[piece] - 1
    inner = (top > first) & (top < last) & (last - first >= ROWS - 1)
    if not inner.any():
        return found
    top, columns = top[inner], columns[inner]
    rows = np.clip(top - ROWS // 2, first[inner], last[inner] - ROWS + 1) + np.arange(ROWS)[:, None]
    span = time[top + 1] - time[top - 1]
    away, near = (time[rows] - time[top]) / span, values[rows, columns]
    terms = np.linalg.solve(away.T[:, :, None] ** np.arange(ROWS), near.T[:, :, None])[:, :, 0].T
    at, bounds = np.zeros(len(top)), ((time[top - 1] - time[top]) / span, (time[top + 1] - time[top]) / span)
    for _ in range(NEWTON):
        slope, bend = (polyval(at, polyder(terms, order), tensor=False) for order in (1, 2))
        at = np.clip(at - slope / np.where(bend < 0.0, bend, -np.inf), *bounds)
    found[columns] = np.maximum(found[columns], polyval(at, terms, tensor=False))
    return found


def largest_magnitudes(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Largest magnitudes (k,) of signals as in `largest_sampled`."""
    rows, columns = np.argmax(np.abs(values), axis=0), np.arange(values.shape[1])
    return largest_sampled(time, np.where(values[rows, columns] < 0.0, -values, values))


#: Window around a heel strike, in pendulum times of the design, and rate in it, that show an impact's forces.
IMPACT_WINDOW = (-5e-3, 0.05)
IMPACT_RATE = 4e3
#: A sensor at the hip shows a spike of some 1e-4 in this time after touch-down; at this rate its peak is seen to 1 %.
SPIKE_WINDOW = (0.0, 1e-3)
SPIKE_RATE = 4e4


def uniform_times(end: float, rate_hz: float) -> np.ndarray:
    """Even times from 0 to `end` [s] at `rate_hz`, shape (n,); rounding does not lose the last one."""
    count = int(np.floor(end * rate_hz * (1.0 + 1e-12))) + 1
    return np.minimum(np.arange(count) / rate_hz, end)


def refined_times(end: float, rate_hz: float, heel_strikes: np.ndarray, pendulum_time: float) -> np.ndarray:
    """Even times from 0 to `end` [s], with denser ones around the heel strikes (s,) [s]; shape (n,), rising."""
    windows = (*IMPACT_WINDOW, 1.0 / IMPACT_RATE), (*SPIKE_WINDOW, 1.0 / SPIKE_RATE)
    offsets = np.concatenate([np.arange(*window) for window in windows]) * pendulum_time
    around = (np.asarray(heel_strikes)[:, None] + offsets).ravel()
    inside = around[(around > 0.0) & (around < end)]
    times = np.sort(np.concatenate([uniform_times(end, rate_hz), inside]))
    # points closer than a tenth of the densest spacing say nothing new
    return np.asarray(times[np.concatenate([[True], np.diff(times) > 0.1 * pendulum_time / SPIKE_RATE])])
