"""A sensor's second-order Butterworth low pass of a walk's signals, through its events, with exact derivatives.

x'' + sqrt(2) w x' + w^2 x = w^2 u. On a panel u is a polynomial, so x is a polynomial and a free motion: no time step
is chosen. An impact adds its impulse J at once: x' grows by w^2 J.

The filter is followed in the time since each stretch began. A derivative at a fixed time of that kind obeys the same
equation, without any term of the events; at an event it takes over x at the end of the stretch, which moves with it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, exp, sin, sqrt

import numpy as np

from stages.analytic.model.walker import Vector
from stages.calibration.compiled import compiled
from stages.calibration.motion.stretches import NODES, TO_POWERS


@compiled
def follow_panels(
    powers: np.ndarray, lengths: Vector, begin: float, start_by: Vector, w: float, times: Vector, following: int,
    is_last: bool, x: np.ndarray, speed: np.ndarray, out: np.ndarray, rates: np.ndarray,
) -> int:  # fmt: skip
    """Carry the filter `x` and its rate `speed`, (k, 1 + c) each, through the panels of a stretch, in place.

    `powers` (p, NODES, k, 1 + c): coefficients of powers of s in [-1, 1] on panels of these `lengths` (p,) [s], the
    first of which begins at `begin`; c columns are derivatives at a fixed time since then, and `start_by` (c,) is that
    of the beginning. From the sample `following` on, the rising `times` (n,) that lie in the panels are filled: `out`
    (n, k, 1 + c) with derivatives at that time, `rates` (n, k); the last stretch takes all that are left. Returns the
    first sample that is not filled.
    """
    signals, columns = x.shape
    decay = w / sqrt(2.0)
    answer, a, b = np.empty((NODES, signals, columns)), np.empty((signals, columns)), np.empty((signals, columns))
    for panel in range(lengths.size):
        length = lengths[panel]
        scale = 2.0 / (length * w)  # d/dt = scale w d/ds
        for k in range(signals):
            for c in range(columns):
                value, slope = 0.0, 0.0
                for i in range(NODES - 1, -1, -1):
                    term = powers[panel, i, k, c]
                    if i + 1 < NODES:
                        term -= sqrt(2.0) * scale * (i + 1) * answer[i + 1, k, c]
                    if i + 2 < NODES:
                        term -= scale * scale * (i + 1) * (i + 2) * answer[i + 2, k, c]
                    answer[i, k, c] = term
                    sign = 1.0 - 2.0 * (i % 2)
                    value += sign * term
                    slope -= sign * i * term * (2.0 / length)
                a[k, c], b[k, c] = x[k, c] - value, speed[k, c] - slope
        last_panel = is_last and panel == lengths.size - 1
        while following < times.size and (last_panel or times[following] < begin + length):
            at = times[following] - begin
            s = 2.0 * at / length - 1.0
            fall, turn, rise = exp(-decay * at), cos(decay * at), sin(decay * at)
            by_a, by_b = fall * (turn + rise), fall * rise / decay
            for k in range(signals):
                slope = 0.0
                for i in range(NODES - 1, 0, -1):
                    slope = slope * s + i * answer[i, k, 0]
                slope = slope * (2.0 / length) - 2.0 * decay * fall * rise * a[k, 0] + fall * (turn - rise) * b[k, 0]
                rates[following, k] = slope
                for c in range(columns):
                    value = 0.0
                    for i in range(NODES - 1, -1, -1):
                        value = value * s + answer[i, k, c]
                    value += by_a * a[k, c] + by_b * b[k, c]
                    # a fixed time is later in a stretch that begins earlier
                    out[following, k, c] = value if c == 0 else value - slope * start_by[c - 1]
            following += 1
        fall, turn, rise = exp(-decay * length), cos(decay * length), sin(decay * length)
        for k in range(signals):
            for c in range(columns):
                value, slope = 0.0, 0.0
                for i in range(NODES):
                    value += answer[i, k, c]
                    slope += i * answer[i, k, c] * (2.0 / length)
                x[k, c] = value + fall * (turn + rise) * a[k, c] + fall * rise / decay * b[k, c]
                speed[k, c] = slope - 2.0 * decay * fall * rise * a[k, c] + fall * (turn - rise) * b[k, c]
        begin += length
    return following


ROOT_2 = math.sqrt(2.0)


@dataclass(frozen=True)
class Piece:
    """Signals of one stretch in SI units, k of them, by c columns.

    `start` [s] and `edges` (p + 1,) [s] since it; `signals` (p * NODES, k, 1 + c): values, then derivatives at fixed
    time since the start. `start_by`, `duration_by` (c,) [s]. `impulse` (k, 1 + c) is what an impact at its end adds.
    """

    start: float
    edges: Vector
    signals: np.ndarray
    start_by: Vector
    duration_by: Vector
    impulse: np.ndarray


@dataclass(frozen=True)
class Filtered:
    """What the sensor has at given times: signals (m, k), derivatives at these times (m, k, c), and rates (m, k)."""

    value: np.ndarray
    by: np.ndarray
    rate: np.ndarray


def filtered(pieces: Sequence[Piece], bandwidth_hz: float, times: Vector) -> Filtered:
    """Signals behind the low pass at the rising `times` (m,) [s] since the first piece began.

    It has rested in the first value of each signal. Every time must lie within the pieces.
    """
    w = 2 * math.pi * bandwidth_hz
    first = pieces[0].signals
    k, columns = first.shape[1:]
    out, rates = np.empty((len(times), k, columns)), np.empty((len(times), k))
    x, speed = np.tensordot((-1.0) ** np.arange(NODES) @ TO_POWERS, first[:NODES], 1), np.zeros((k, columns))
    following = 0
    for number, piece in enumerate(pieces):
        powers = np.einsum("ij,pjkc->pikc", TO_POWERS, piece.signals.reshape(-1, NODES, k, columns))
        following = follow_panels(
            powers, np.diff(piece.edges), piece.start + piece.edges[0], piece.start_by, w, times, following,
            number == len(pieces) - 1, x, speed, out, rates)
        u = np.tensordot(np.ones(NODES), powers[-1], 1)  # at s = 1, the end
        growth = w * w * (u[:, 0] - x[:, 0]) - ROOT_2 * w * speed[:, 0]
        x[:, 1:] += speed[:, :1] * piece.duration_by
        speed[:, 1:] += growth[:, None] * piece.duration_by
        speed += w * w * piece.impulse
    return Filtered(out[:, :, 0], out[:, :, 1:], rates)
