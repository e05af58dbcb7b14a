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
from stages.calibration.motion.panel_filter import follow_panels
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
        following = follow_panels(
            powers, np.diff(piece.edges), piece.start + piece.edges[0], piece.start_by, w, times, following,
            number == len(pieces) - 1, x, speed, out, rates)
        u = np.tensordot(np.ones(NODES), powers[-1], 1)  # at s = 1, the end
        growth = w * w * (u[:, 0] - x[:, 0]) - ROOT_2 * w * speed[:, 0]
        x[:, 1:] += speed[:, :1] * piece.duration_by
        speed[:, 1:] += growth[:, None] * piece.duration_by
        speed += w * w * piece.impulse
    return Filtered(out[:, :, 0], out[:, :, 1:], rates)
