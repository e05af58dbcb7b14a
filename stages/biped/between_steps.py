"""What a solver left step by step, brought to any time between its steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

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
    asked for one after another.
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
