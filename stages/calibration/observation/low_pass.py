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

import numpy as np

from stages.analytic.model.walker import Vector
from stages.calibration.motion.panels import NODES, TO_POWERS

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
        lengths = np.diff(piece.edges)
        for panel, length in enumerate(lengths):
            response = _response(powers[panel], w, length)
            begin = piece.start + piece.edges[panel]
            is_last = panel == len(lengths) - 1 and number == len(pieces) - 1
            stop = len(times) if is_last else int(np.searchsorted(times, begin + length, side="left"))
            at = np.append(times[following:stop] - begin, length)
            value, slope = _follow(response, x, speed, w, length, at)
            if stop > following:
                out[following:stop] = value[:-1]
                rates[following:stop] = slope[:-1, :, 0]
                # a fixed time is later in a stretch that begins earlier
                out[following:stop, :, 1:] -= slope[:-1, :, :1] * piece.start_by
                following = stop
            x, speed = value[-1], slope[-1]
        u = np.tensordot(np.ones(NODES), powers[-1], 1)  # at s = 1, the end
        growth = w * w * (u[:, 0] - x[:, 0]) - ROOT_2 * w * speed[:, 0]
        x, speed = x.copy(), speed.copy()
        x[:, 1:] += speed[:, :1] * piece.duration_by
        speed[:, 1:] += growth[:, None] * piece.duration_by
        speed += w * w * piece.impulse
    return Filtered(out[:, :, 0], out[:, :, 1:], rates)


def _response(powers: np.ndarray, w: float, length: float) -> np.ndarray:
    """Coefficients (NODES, ...) of the polynomial that the filter answers a polynomial with, both in s in [-1, 1]."""
    scale = 2.0 / length / w  # d/dt = scale w d/ds
    answer = powers.copy()
    for i in range(NODES - 2, -1, -1):
        answer[i] -= ROOT_2 * scale * (i + 1) * answer[i + 1]
        if i + 2 < NODES:
            answer[i] -= scale * scale * (i + 1) * (i + 2) * answer[i + 2]
    return answer


def _follow(
    response: np.ndarray, x: np.ndarray, speed: np.ndarray, w: float, length: float, at: Vector
) -> tuple[np.ndarray, np.ndarray]:
    """Filter and its rate (t, k, 1 + c) at times `at` (t,) since the panel began in `x` and `speed` (k, 1 + c)."""
    exponents = np.arange(NODES)
    s = 2.0 * at / length - 1.0
    value_at = s[:, None] ** exponents
    slope_at = exponents * s[:, None] ** np.maximum(exponents - 1, 0) * (2.0 / length)
    signs = (-1.0) ** exponents
    begin = np.tensordot(signs, response, 1)
    begin_slope = np.tensordot(exponents * -signs * (2.0 / length), response, 1)
    a, b = x - begin, speed - begin_slope
    decay = w / ROOT_2
    fall, c, d = np.exp(-decay * at), np.cos(decay * at), np.sin(decay * at)
    free_a, free_b = fall * (c + d), fall * d / decay
    slope_a, slope_b = -2 * decay * fall * d, fall * (c - d)
    value = np.tensordot(value_at, response, 1) + free_a[:, None, None] * a + free_b[:, None, None] * b
    slope = np.tensordot(slope_at, response, 1) + slope_a[:, None, None] * a + slope_b[:, None, None] * b
    return value, slope
