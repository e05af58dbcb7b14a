"""What sensors at the hip and at the foot of one leg feel of a walker's state, with exact derivatives.

Derivatives are by the complex step: f(x + i h dx) has h times the derivative along dx as its imaginary part, up to h^2,
which for h = 1e-30 is nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stages.analytic.derivatives.step_map import exchanged_rows
from stages.analytic.model.walker import Vector, Walker
from stages.calibration.motion.stretches import Stretch

#: Signals on the body's axes, in this order.
SIGNALS = ("hip_forward", "hip_up", "foot_forward", "foot_up", "rate")
TINY = 1e-30


@dataclass(frozen=True)
class Numbers:
    """What the sensors need of the walker: the standing foot's radius, place of the foot sensor above its foot's
    bottom, natural lengths of stance and swing leg, gravity in the slope frame; numbers or arrays."""

    radius: Any
    place: Any
    length: Any
    other_length: Any
    g_x: Any
    g_y: Any


@dataclass(frozen=True)
class Felt:
    """Signals (n, 5) in the order of `SIGNALS`, SI units, and their derivatives (n, 5, c)."""

    value: np.ndarray
    by: np.ndarray


def felt(q: Any, qd: Any, qdd: Any, stands: bool, n: Numbers) -> np.ndarray:
    """Signals (5, ...) of sensors on the stance leg (`stands`) or on the swing leg, dimensionless.

    `q`, `qd`, `qdd` are theta, L_1, psi, L_2 and their rates. The specific force is acceleration less gravity, on the
    leg's axes forward and up; see `stages.biped.kinematics`, eqs. (7) and (8).
    """
    theta, stance, psi, swing = q
    turn, stance_rate, swing_turn, swing_rate = qd
    turning, stance_growth, swing_turning, swing_growth = qdd
    sin, cos = np.sin(theta), np.cos(theta)
    above = stance - n.radius
    rolling = n.radius * turning  # of the foot's centre, along x
    forward = above * turning + 2 * stance_rate * turn + rolling * cos - (n.g_x * cos - n.g_y * sin)
    up = stance_growth - above * turn**2 + rolling * sin - (n.g_x * sin + n.g_y * cos)
    if stands:
        height = n.place - n.radius
        foot_forward = height * turning + rolling * cos - (n.g_x * cos - n.g_y * sin)
        foot_up = -height * turn**2 + rolling * sin - (n.g_x * sin + n.g_y * cos)
        return np.stack(np.broadcast_arrays(forward, up, foot_forward, foot_up, -turn))
    between = theta + psi  # the swing leg's axes are those of the stance leg turned by it
    c, s = np.cos(between), np.sin(between)
    hip_forward, hip_up = c * forward + s * up, -s * forward + c * up
    below = swing - n.place
    foot_forward = hip_forward + below * swing_turning + 2 * swing_rate * swing_turn
    foot_up = hip_up + below * swing_turn**2 - swing_growth
    return np.stack(np.broadcast_arrays(hip_forward, hip_up, foot_forward, foot_up, swing_turn))


class Sensing:
    """The two sensors of leg 0 on a walker whose numbers change by `along` (n, fields) with the last n columns.

    The foot sensor sits `below_hip` [m] on unloaded springs; where that is not known, `place` [m] above the foot's
    mass centre, wherever that turns out to be. With the very last column it moves up by a leg length, and nothing else.
    """

    def __init__(
        self, walker: Walker, along: np.ndarray, free: int, place: float = 0.0, below_hip: float | None = None
    ) -> None:
        self.walker = walker
        rows = along, exchanged_rows(walker, along)
        self._on = tuple(_numbers(walker, rows[leg], free, place, below_hip, leg) for leg in (0, 1))
        force, rate = walker.length / walker.time**2, 1.0 / walker.time
        self.scales = np.array([force, force, force, force, rate])
        speed = walker.length / walker.time
        self.impulse_scales = np.array([speed, speed, speed, speed, 0.0])

    def along(self, stretch: Stretch) -> Felt:
        """What is felt at the nodes of a stretch."""
        half = self.walker.size // 2
        y = stretch.states[:, :, None] + 1j * TINY * stretch.states_by
        rates = stretch.rates[:, :, None] + 1j * TINY * stretch.rates_by
        found = self._felt(y[:, :half], y[:, half:], rates[:, half:], stretch.stance_leg, self._on[stretch.stance_leg])
        return self._scaled(found, self.scales)

    def velocities(self, y: Vector, y_by: np.ndarray, stance_leg: int) -> Felt:
        """Velocities of hip and foot on the leg's axes in a state (size,), shape (1, 5): what an impact changes.

        Without rates and gravity, accelerations are velocities' own formulas. The rate's own column is zero.
        """
        half = self.walker.size // 2
        moved = (y[None, :, None] + 1j * TINY * y_by[None])
        at_rest, weightless = np.zeros_like(moved[:, :half]), replace(self._on[stance_leg], g_x=0.0, g_y=0.0)
        found = self._felt(moved[:, :half], at_rest, moved[:, half:], stance_leg, weightless)
        return self._scaled(found, self.impulse_scales)

    def _felt(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, stance_leg: int, n: Numbers) -> np.ndarray:
        """Complex signals (5, n, c)."""
        coordinates, rates, accelerations = (_four(part, n if k == 0 else None) for k, part in enumerate((q, qd, qdd)))
        return felt(coordinates, rates, accelerations, stance_leg == 0, n)

    @staticmethod
    def _scaled(found: np.ndarray, scales: np.ndarray) -> Felt:
        signals = found.transpose(1, 0, 2)
        return Felt(signals[:, :, 0].real * scales, signals.imag / TINY * scales[:, None])


def _numbers(
    walker: Walker, along: np.ndarray, free: int, place: float, below_hip: float | None, stance_leg: int
) -> Numbers:
    """What the sensors need while a leg stands, with the changes as imaginary parts. They sit on leg 0."""
    p: Any = walker.on(stance_leg).p
    own = {field: value + 1j * TINY * np.concatenate([np.zeros(free), column])
           for field, value, column in zip(p._fields, p, along.T, strict=True)}
    stance, swing = own["L_nat"], own.get("L_nat_2", own["L_nat"])
    if below_hip is None:
        above = (own.get("l_2", own["l"]) if stance_leg == 1 else own["l"]) + place / walker.length
    else:
        above = (swing if stance_leg == 1 else stance) - below_hip / walker.length
    moved = np.zeros(free + len(along))
    moved[-1] = 1.0
    return Numbers(own["r"], above + 1j * TINY * moved, stance, swing, own["g_x"], own["g_y"])


def _four(part: np.ndarray, lengths: Numbers | None) -> list[Any]:
    """theta, L_1, psi, L_2 of an array (n, size / 2, c), or their rates; rigid legs keep their lengths."""
    if part.shape[1] == 4:
        return [part[:, i] for i in range(4)]
    stance, swing = (lengths.length, lengths.other_length) if lengths else (0.0, 0.0)
    return [part[:, 0], stance, part[:, 1], swing]
