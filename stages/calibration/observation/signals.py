"""What sensors at the hip and at the foot of one leg measure of a walk, and what their low pass lets through.

Last axes hold a value, then its exact derivatives. Those of what is sensed are by the complex step: f(x + i h dx) has h
times the derivative along dx as its imaginary part, up to h^2, which for h = 1e-30 is nothing.

The low pass is Butterworth's of second order, x'' + sqrt(2) w x' + w^2 x = w^2 u. On a panel u is a polynomial, so x is
a polynomial and a free motion: no time step is chosen. An impact adds its impulse J at once: x' grows by w^2 J. The
filter is followed in the time since each stretch began. A derivative at a fixed time of that kind obeys the same
equation, without any term of the events; at an event it takes over x at the end of the stretch, which moves with it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, exp, pi, sin, sqrt
from typing import Any

import numpy as np

from stages.analytic.derivatives.gait import exchanged_rows
from stages.analytic.model.kinds import heights_of_mass, natural_lengths
from stages.analytic.model.walker import Vector, Walker
from stages.calibration.compiled import compiled
from stages.calibration.observation.stretches import NODES, TO_POWERS, Stretch

#: Signals on the body's axes, in this order.
SIGNALS = ("hip_forward", "hip_up", "foot_forward", "foot_up", "rate")
TINY = 1e-30


def sensed(q: Any, qd: Any, qdd: Any, stands: bool, p: Any, place: Any) -> np.ndarray:
    """Signals (5, ...) of sensors on the stance leg (`stands`) or on the swing leg, dimensionless.

    `q`, `qd`, `qdd` are theta, L_1, psi, L_2 and their rates, `p` the walker's numbers, `place` that of the foot sensor
    above its foot's bottom; all are numbers or arrays. The specific force is acceleration less gravity, on the
    leg's axes forward and up; see `stages.biped.kinematics`, eqs. (7) and (8).
    """
    theta, stance, psi, swing = q
    turn, stance_rate, swing_turn, swing_rate = qd
    turning, stance_growth, swing_turning, swing_growth = qdd
    sin, cos = np.sin(theta), np.cos(theta)
    above = stance - p.r
    rolling = p.r * turning  # of the foot's centre, along x
    forward = above * turning + 2 * stance_rate * turn + rolling * cos - (p.g_x * cos - p.g_y * sin)
    up = stance_growth - above * turn**2 + rolling * sin - (p.g_x * sin + p.g_y * cos)
    if stands:
        height = place - p.r
        foot_forward = height * turning + rolling * cos - (p.g_x * cos - p.g_y * sin)
        foot_up = -height * turn**2 + rolling * sin - (p.g_x * sin + p.g_y * cos)
        return np.stack(np.broadcast_arrays(forward, up, foot_forward, foot_up, -turn))
    between = theta + psi  # the swing leg's axes are those of the stance leg turned by it
    c, s = np.cos(between), np.sin(between)
    hip_forward, hip_up = c * forward + s * up, -s * forward + c * up
    below = swing - place
    foot_forward = hip_forward + below * swing_turning + 2 * swing_rate * swing_turn
    foot_up = hip_up + below * swing_turn**2 - swing_growth
    return np.stack(np.broadcast_arrays(hip_forward, hip_up, foot_forward, foot_up, swing_turn))


class Sensing:
    """The two sensors of leg 0 on a walker whose numbers change by `along` (n, fields) with the last n columns.

    The foot sensor sits `below_hip` [m] on unloaded springs; where that is not known, `place` [m] above the foot's
    mass centre, wherever that turns out to be. With the very last column it moves up by a leg length, and nothing else.
    """

    def __init__(
        self, walker: Walker, along: np.ndarray, free: int, place: float, below_hip: float | None
    ) -> None:
        rows = along, exchanged_rows(walker, along)
        self._half = walker.size // 2
        self._on = tuple(_numbers(walker, rows[leg], free, place, below_hip, leg) for leg in (0, 1))
        force, rate, speed = walker.length / walker.time**2, 1.0 / walker.time, walker.length / walker.time
        self._scales = np.array([force, force, force, force, rate])[:, None]
        self._impulse_scales = np.array([speed, speed, speed, speed, 0.0])[:, None]

    def along(self, stretch: Stretch) -> np.ndarray:
        """What is sensed at the nodes of a stretch, (n, 5, 1 + c) in the order of `SIGNALS`, SI units."""
        leg = stretch.stance_leg
        return np.asarray(self._sensed(stretch.states, stretch.rates, leg, *self._on[leg]) * self._scales)

    def velocities(self, y: np.ndarray, stance_leg: int) -> np.ndarray:
        """Velocities of hip and foot on the leg's axes in a state (size, 1 + c), (5, 1 + c): what an impact changes.

        Without rates and gravity, accelerations are velocities' own formulas. The rate's own row is zero.
        """
        at_rest, (p, place) = y.copy(), self._on[stance_leg]
        at_rest[self._half :] = 0.0
        sensed = self._sensed(at_rest[None], y[None], stance_leg, p._replace(g_x=0.0, g_y=0.0), place)
        return np.asarray(sensed[0] * self._impulse_scales)

    def _sensed(self, states: np.ndarray, rates: np.ndarray, stance_leg: int, p: Any, place: Any) -> np.ndarray:
        """Signals (n, 5, 1 + c) of states and of what stands for their rates, (n, size, 1 + c)."""
        y, half = _as_complex(states), self._half
        q, qd, qdd = (_four(y[:, :half], *natural_lengths(p)), _four(y[:, half:]),
                      _four(_as_complex(rates)[:, half:]))  # fmt: skip
        signals = sensed(q, qd, qdd, stance_leg == 0, p, place).transpose(1, 0, 2)
        return np.concatenate([signals[:, :, :1].real, signals.imag / TINY], axis=2)


def _as_complex(columns: np.ndarray) -> np.ndarray:
    """Values with each of their derivatives as imaginary part, (..., c)."""
    return np.asarray(columns[..., :1] + 1j * TINY * columns[..., 1:])


def _numbers(
    walker: Walker, along: np.ndarray, free: int, place: float, below_hip: float | None, stance_leg: int
) -> tuple[Any, Any]:
    """The walker's numbers while a leg stands, and the place of the foot sensor above the bottom of its foot, with the
    changes as imaginary parts. The sensors sit on leg 0."""
    p = walker.on(stance_leg).p
    kind: Any = type(p)
    own = kind(*(value + 1j * TINY * np.concatenate([np.zeros(free), column])
                 for value, column in zip(p, along.T, strict=True)))
    if below_hip is None:
        above = heights_of_mass(own)[stance_leg] + place / walker.length
    else:
        above = natural_lengths(own)[stance_leg] - below_hip / walker.length
    moved = np.zeros(free + len(along))
    moved[-1] = 1.0
    return own, above + 1j * TINY * moved


def _four(part: np.ndarray, stance: Any = 0.0, swing: Any = 0.0) -> list[Any]:
    """theta, L_1, psi, L_2 of an array (n, size / 2, c), or their rates; rigid legs keep their lengths."""
    return [part[:, i] for i in range(4)] if part.shape[1] == 4 else [part[:, 0], stance, part[:, 1], swing]


@compiled
def fill_panel(
    powers: np.ndarray, length: float, w: float, x: np.ndarray, speed: np.ndarray, answer: np.ndarray, a: np.ndarray,
    b: np.ndarray,
) -> None:
    """The filter on a panel as powers of s, `answer` (NODES, k, 1 + c), and a free motion that begins with `a` and rate
    `b` (k, 1 + c), in place."""
    signals, columns = x.shape
    scale = 2.0 / (length * w)  # d/dt = scale w d/ds
    for k in range(signals):
        for c in range(columns):
            value, slope = 0.0, 0.0
            for i in range(NODES - 1, -1, -1):
                term = powers[i, k, c]
                if i + 1 < NODES:
                    term -= sqrt(2.0) * scale * (i + 1) * answer[i + 1, k, c]
                if i + 2 < NODES:
                    term -= scale * scale * (i + 1) * (i + 2) * answer[i + 2, k, c]
                answer[i, k, c] = term
                sign = 1.0 - 2.0 * (i % 2)
                value += sign * term
                slope -= sign * i * term * (2.0 / length)
            a[k, c], b[k, c] = x[k, c] - value, speed[k, c] - slope


@compiled
def follow_panels(
    powers: np.ndarray, edges: Vector, start_by: Vector, w: float, times: Vector, following: int, panel: int,
    is_last: bool, x: np.ndarray, speed: np.ndarray, out: np.ndarray, rates: np.ndarray,
) -> tuple[int, int]:  # fmt: skip
    """Carry the filter `x` and its rate `speed`, (k, 1 + c) each, through the panels of a stretch, in place.

    `powers` (p, NODES, k, 1 + c): coefficients of powers of s in [-1, 1] on panels between `edges` (p + 1,) [s]; c
    columns are derivatives at a fixed time since the first of them, and `start_by` (c,) is that of it. The filter is
    at the beginning of a `panel`. From the sample `following` on, the rising `times` (n,) that lie in the panels are
    filled: `out` (n, k, 1 + c) with derivatives at that time, `rates` (n, k); the last stretch takes all that are left.
    Returns the first sample that is not filled, and the panel that the filter is at: that of the last sample, or none.
    """
    signals, columns = x.shape
    decay = w / sqrt(2.0)
    answer, a, b = np.empty((NODES, signals, columns)), np.empty((signals, columns)), np.empty((signals, columns))
    while panel < edges.size - 1:
        begin, length = edges[panel], edges[panel + 1] - edges[panel]
        fill_panel(powers[panel], length, w, x, speed, answer, a, b)
        last_panel = is_last and panel == edges.size - 2
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
        if following == times.size:
            break
        fall, turn, rise = exp(-decay * length), cos(decay * length), sin(decay * length)
        for k in range(signals):
            for c in range(columns):
                value, slope = 0.0, 0.0
                for i in range(NODES):
                    value += answer[i, k, c]
                    slope += i * answer[i, k, c] * (2.0 / length)
                x[k, c] = value + fall * (turn + rise) * a[k, c] + fall * rise / decay * b[k, c]
                speed[k, c] = slope - 2.0 * decay * fall * rise * a[k, c] + fall * (turn - rise) * b[k, c]
        panel += 1
    return following, panel


@dataclass(frozen=True)
class Piece:
    """Signals of one stretch in SI units, k of them. Last axes hold a value, then its c derivatives.

    `start` and `duration` (1 + c,) [s]; `edges` (p + 1,) [s] since the start; `signals` (p * NODES, k, 1 + c), derived
    at fixed time since the start. `impulse` (k, 1 + c) is what an impact at its end adds.
    """

    start: Vector
    duration: Vector
    edges: Vector
    signals: np.ndarray
    impulse: np.ndarray


class LowPass:
    """Signals that are `chosen`, k of them, behind the low pass, which has rested in the first values.

    It is followed as far as it is requested. Without derivatives where they are not to be `derived`.
    """

    def __init__(
        self, pieces: Sequence[Piece], chosen: Sequence[int], bandwidth_hz: float, derived: bool = True
    ) -> None:
        self._pieces, self._chosen, self._w = pieces, chosen, 2 * pi * bandwidth_hz
        self._columns = pieces[0].start.size if derived else 1
        self._piece, self._panel, self._powers = 0, 0, self._powers_of(pieces[0])
        self._x = np.tensordot((-1.0) ** np.arange(NODES), self._powers[0], 1)
        self._speed = np.zeros((len(chosen), self._columns))

    def read(self, times: Vector) -> tuple[np.ndarray, np.ndarray]:
        """The signals (m, k, 1 + c), derived at fixed times, and their rates (m, k).

        The rising `times` (m,) [s] since the first piece began are within the pieces, and none earlier than before.
        """
        w, columns, following = self._w, self._columns, 0
        out = np.empty((len(times), len(self._chosen), columns))
        rates = np.empty(out.shape[:2])
        while True:
            piece, is_last = self._pieces[self._piece], self._piece == len(self._pieces) - 1
            following, self._panel = follow_panels(
                self._powers, piece.start[0] + piece.edges, piece.start[1:columns], w, times, following, self._panel,
                is_last, self._x, self._speed, out, rates)
            if following == len(times):
                return out, rates
            u = np.tensordot(np.ones(NODES), self._powers[-1], 1)  # at s = 1, the end
            growth = w * w * (u[:, 0] - self._x[:, 0]) - sqrt(2) * w * self._speed[:, 0]
            self._x[:, 1:] += self._speed[:, :1] * piece.duration[1:columns]
            self._speed[:, 1:] += growth[:, None] * piece.duration[1:columns]
            self._speed += w * w * piece.impulse[self._chosen, :columns]
            self._piece, self._panel = self._piece + 1, 0
            self._powers = self._powers_of(self._pieces[self._piece])

    def _powers_of(self, piece: Piece) -> np.ndarray:
        signals = piece.signals[:, self._chosen, : self._columns].reshape(-1, NODES, len(self._chosen), self._columns)
        return np.asarray(np.einsum("ij,pjkc->pikc", TO_POWERS, signals, order="C"))
