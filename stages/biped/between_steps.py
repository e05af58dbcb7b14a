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
    s = (time - steps[i])[:, None] / step
    powers = _powers(i, step, position, velocity, acceleration)
    _, a1, a2, c3, c4, c5 = powers
    return _place(powers, s), (a1 + s * (2 * a2 + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))) / step


def within(
    steps: np.ndarray, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, row: int
) -> Callable[[float], np.ndarray]:
    """The position (k,) that `hermite` has at a time [s] between a row of the steps and the next, asked for often."""
    begin, step = float(steps[row]), float(steps[row + 1] - steps[row])
    powers = _powers(row, step, position, velocity, acceleration)
    return lambda time: _place(powers, (time - begin) / step)


def _powers(
    i: Any, step: Any, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray | None
) -> tuple[np.ndarray, ...]:
    """Coefficients of the position in powers of the share of a step that has gone by since row or rows i."""
    start, rise = position[i], position[i + 1] - position[i]
    a1, b1 = velocity[i] * step, velocity[i + 1] * step
    if acceleration is None:
        return start, a1, 3 * rise - 2 * a1 - b1, -2 * rise + a1 + b1, 0.0 * rise, 0.0 * rise
    a2, b2 = 0.5 * acceleration[i] * step**2, 0.5 * acceleration[i + 1] * step**2
    return (start, a1, a2, 10 * rise - 6 * a1 - 4 * b1 - 3 * a2 + b2, -15 * rise + 8 * a1 + 7 * b1 + 3 * a2 - 2 * b2,
            6 * rise - 3 * a1 - 3 * b1 - a2 + b2)


def _place(powers: tuple[np.ndarray, ...], s: Any) -> np.ndarray:
    start, a1, a2, c3, c4, c5 = powers
    place: np.ndarray = start + s * (a1 + s * (a2 + s * (c3 + s * (c4 + s * c5))))
    return place


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
