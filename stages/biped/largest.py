"""The largest value of what a solver left at some times: where its derivative vanishes between them, or at an end.

A value at an event is taken at the event, on either side of it: what jumps or has a kink is looked at piece by piece.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

#: Times close around the first guess at which a solution is asked once more.
AROUND = 9
#: A spline is drawn through no fewer samples.
FEWEST = 4
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

    `at` gives it at rising times of one's own, from the solution itself. It is asked at the largest turning point of
    the spline through the values, and once more at those of a spline through times close around that one.
    """
    for width in (1.0, 0.25):
        top = int(np.argmax(values))
        when, value = float(time[top]), float(values[top])
        rising = np.diff(time, prepend=-np.inf) > 0.0
        if rising.sum() < FEWEST or not np.isfinite(values).all():
            return when, value
        inside, higher = turning(through(time[rising], values[rising]))
        if not (higher > value).any():
            return when, value
        guess = inside[np.argmax(higher)]
        row = min(int(np.searchsorted(time, guess, side="right")), len(time) - 1)
        reach = width * (time[row] - time[row - 1])
        near = np.linspace(max(time[0], guess - reach), min(time[-1], guess + reach), AROUND)
        time = np.unique(np.concatenate([near, [guess, when]]))
        values = at(time)
    top = int(np.argmax(values))
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


def sampled_at(
    time: np.ndarray, values: np.ndarray, events: np.ndarray, wanted: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Sampled signals (n, k) at wanted rising times [s], and twice at each event among them: on both of its sides.

    By cubic splines from event to event, where signals are smooth: the error falls with the spacing's fourth power.
    Gives the times (m,), equal ones where values may jump, and the values (m, k).
    """
    first, last = wanted[0], wanted[-1]
    cuts = np.unique(events)
    cuts = cuts[np.diff(cuts, prepend=-np.inf) > SAME * (last - first)]
    times, found = [], []
    for begin, finish in pairwise([-np.inf, *cuts, np.inf]):
        inside = (time >= begin) & (time < finish)
        if finish <= first or begin >= last or inside.sum() < 2:
            continue
        sides = np.concatenate([[begin], wanted[(wanted > begin) & (wanted < finish)], [finish]])
        times.append(sides[(sides >= first) & (sides <= last)])
        found.append(through(time[inside], values[inside])(times[-1]))
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
