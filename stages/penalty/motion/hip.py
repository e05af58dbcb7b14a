"""What acts at the hip beside the legs: weight, and in a detailed walker spring, damper and friction between them.

Torques act on the angle of leg 0, and with the opposite sign on that of leg 1.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stages.analytic.compiled import ByKind
from stages.penalty.compiled import compiled
from stages.penalty.model.walker import DetailedPenalty, LegNumbers, Penalty
from stages.planar.run import HIP_CREEP

Vector = np.ndarray
#: Places of the hip's numbers among those of a walker, as `changes.flat` has them: mass and gravity; of a detailed one
#: the mass for gravity, gravity as its first leg has it, and the numbers of spring, damper, rest angle and friction.
MASS, GRAVITY = Penalty._fields.index("M"), Penalty._fields.index("g_x")
WEIGHED, FIRST, OTHER = 1, 2, 2 + len(LegNumbers._fields)
DETAILED_GRAVITY, SPRING = FIRST + LegNumbers._fields.index("g_x"), OTHER + len(LegNumbers._fields)


@compiled
def plain_load(y: Vector, p: Penalty) -> tuple[float, float, float]:
    """`hip_load` of Table 1's walker."""
    return p.M * p.g_x, p.M * p.g_y, 0.0


@compiled
def rubbed(rate: float) -> float:
    """Share of the friction torque that resists a rate of the hip, -1 to 1."""
    return min(max(rate / HIP_CREEP, -1.0), 1.0)


@compiled
def detailed_load(y: Vector, p: DetailedPenalty) -> tuple[float, float, float]:
    """`hip_load` of a detailed walker."""
    rate = y[8] - y[9]
    torque = -p.k_h * (y[2] - y[3] - p.phi_h) - p.b_h * rate - p.tau_h * rubbed(rate)
    return p.M_g * p.first.g_x, p.M_g * p.first.g_y, torque


#: Weight of the hip along x and y [N], and torque between the legs [N m]: hip_load(y, p).
hip_load: Callable[..., tuple[float, float, float]] = ByKind({Penalty: plain_load, DetailedPenalty: detailed_load})


@compiled
def no_variation(y: Vector, start: int, p: Penalty) -> float:
    """`torque_variation` of a hip without any."""
    return 0.0


@compiled
def detailed_variation(y: Vector, start: int, p: DetailedPenalty) -> float:
    """`torque_variation` of a detailed walker."""
    slope = p.b_h
    if abs(y[8] - y[9]) < HIP_CREEP:
        slope += p.tau_h / HIP_CREEP
    change: float = -p.k_h * (y[start + 2] - y[start + 3]) - slope * (y[start + 8] - y[start + 9])
    return change


#: Change of the torque for the variation stored from `start`: torque_variation(y, start, p).
torque_variation: Callable[..., float] = ByKind({Penalty: no_variation, DetailedPenalty: detailed_variation})


@compiled
def plain_change(y: Vector, a: np.ndarray, row: int, ax: float, ay: float, p: Penalty) -> tuple[float, float, float]:
    """`hip_change` of Table 1's walker."""
    mass = a[row, MASS]
    return mass * (p.g_x - ax) + p.M * a[row, GRAVITY], mass * (p.g_y - ay) + p.M * a[row, GRAVITY + 1], 0.0


@compiled
def detailed_change(
    y: Vector, a: np.ndarray, row: int, ax: float, ay: float, p: DetailedPenalty
) -> tuple[float, float, float]:
    """`hip_change` of a detailed walker."""
    mass, weight, rate = a[row, MASS], a[row, WEIGHED], y[8] - y[9]
    stretch = y[2] - y[3] - p.phi_h
    torque = -a[row, SPRING] * stretch - a[row, SPRING + 1] * rate + p.k_h * a[row, SPRING + 2]
    return (
        weight * p.first.g_x - mass * ax + p.M_g * a[row, DETAILED_GRAVITY],
        weight * p.first.g_y - mass * ay + p.M_g * a[row, DETAILED_GRAVITY + 1],
        torque - a[row, SPRING + 3] * rubbed(rate),
    )


#: Change of the hip's weight less its mass times its acceleration, and of the torque, for a row of changes of the
#: walker's numbers: hip_change(y, a, row, ax, ay, p).
hip_change: Callable[..., tuple[float, float, float]] = ByKind({
    Penalty: plain_change, DetailedPenalty: detailed_change})


@compiled
def one_place(leg: int, p: Penalty) -> int:
    """`leg_place` of legs that are alike."""
    return 0


@compiled
def own_place(leg: int, p: DetailedPenalty) -> int:
    """`leg_place` of a detailed walker."""
    return FIRST if leg == 0 else OTHER


#: Where a leg's numbers begin among the walker's: leg_place(leg, p).
leg_place: Callable[..., int] = ByKind({Penalty: one_place, DetailedPenalty: own_place})
