"""Straight lines through arrival stamps: the highest one below them all, least squares, and a robust one.

A packet can be late, never early. So the arrival stamps lie above the line t = a + b * index that a loss-free radio
of constant delay would draw, and that line is the highest one below all stamps: the linear program

    maximise  sum_i (a + b n_i)   subject to   a + b n_i <= t_i,

whose solution is the edge of the lower convex hull that spans the mean index (two unknowns: the optimum lies on
two stamps). It holds however the lateness is distributed, where least squares is pulled up by every stall.
The smallest delay of the radio stays in `a`: it cannot be observed from the stamps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

HUBER_WIDTH = 1.345  # 95 % efficiency for normal errors (Huber 1981)
#: A point above the chord of its neighbours is no corner. Without all of those at once, others are; each such pass
#: leaves half of what noise has put there. After so many a scan, one point at a time, has few left.
PASSES = 30
Places = np.ndarray | int


@dataclass(frozen=True)
class Line:
    """t = offset + period * index [s]."""

    offset: float
    period: float

    def at(self, index: np.ndarray) -> np.ndarray:
        """Times of the indices [s]."""
        return self.offset + self.period * index


def lower_envelope(index: np.ndarray, stamp: np.ndarray) -> Line:
    """The highest line below all points, in the mean; exact, O(n log n). Needs two different indices."""
    order = np.lexsort((stamp, index))
    x, y = index[order].astype(float), stamp[order]
    first = np.append(True, np.diff(x) > 0)
    x, y = x[first], y[first]
    corner = np.arange(len(x))
    for _ in range(PASSES):
        inside = _above(x, y, corner[:-2], corner[1:-1], corner[2:])
        if not inside.any():
            break
        corner = corner[np.concatenate([[True], ~inside, [True]])]
    else:
        corner = _scanned(x, y, corner)
    right = int(np.clip(np.searchsorted(x[corner], index.mean()), 1, len(corner) - 1))
    p, q = corner[right - 1], corner[right]
    period = (y[q] - y[p]) / (x[q] - x[p])
    return Line(float(y[p] - period * x[p]), float(period))


def _above(x: np.ndarray, y: np.ndarray, p: Places, q: Places, r: Places) -> np.ndarray:
    """Whether points q lie on or above the chords from p to r."""
    return np.asarray((y[q] - y[p]) * (x[r] - x[p]) >= (y[r] - y[p]) * (x[q] - x[p]))


def _scanned(x: np.ndarray, y: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Those of the points that are corners of the lower hull, from left to right: Andrew's scan."""
    hull: list[int] = []
    for point in points.tolist():
        while len(hull) > 1 and _above(x, y, hull[-2], hull[-1], point):
            hull.pop()
        hull.append(point)
    return np.array(hull)


def least_squares_line(index: np.ndarray, stamp: np.ndarray, weight: np.ndarray | None = None) -> Line:
    """Weighted least-squares line through the points."""
    w = np.ones(len(index)) if weight is None else weight
    x0, y0 = np.average(index, weights=w), np.average(stamp, weights=w)
    dx = index - x0
    period = float(np.sum(w * dx * (stamp - y0)) / np.sum(w * dx * dx))
    return Line(float(y0 - period * x0), period)


def robust_line(index: np.ndarray, stamp: np.ndarray, rounds: int = 30) -> Line:
    """Huber's M-estimate of the line by iteratively reweighted least squares, scale from the median deviation."""
    line = least_squares_line(index, stamp)
    for _ in range(rounds):
        residual = stamp - line.at(index)
        residual = residual - np.median(residual)
        scale = max(1.4826 * float(np.median(np.abs(residual))), 1e-9)
        weight = 1.0 / np.maximum(1.0, np.abs(residual) / (HUBER_WIDTH * scale))
        line = least_squares_line(index, stamp, weight)
    return line
