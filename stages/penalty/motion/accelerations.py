"""Accelerations of the penalty walker: the two legs' parts put together and the mass matrix solved in closed form.

The legs meet in the hip's x and y only, so the legs are eliminated first and two equations are left. Of a leg's angle
and length the mass matrix is inverted. A rigid leg has none for the length in its inverse: the length takes no
acceleration and its equation is left out. At the hip act its weight, and spring, damper and friction between the legs.
"""

from collections.abc import Callable

import numpy as np

from stages.analytic.compiled import ByKind, Numbers
from stages.penalty.compiled import compiled
from stages.penalty.model.walker import LegNumbers, Penalty, PlainLeg, leg_of, leg_terms
from stages.penalty.motion.feet import acts_on, block_under, foot_force
from stages.planar.run import HIP_CREEP

Vector = np.ndarray
Six = tuple[float, float, float, float, float, float]
Forces = tuple[float, float, float, float]


#: Places of the hip's numbers among those of a walker, as `changes.flat` has them: mass, the mass for gravity; where
#: legs begin; gravity as the first leg has it; and the numbers of spring, damper, rest angle and friction.
MASS, WEIGHED, FIRST, OTHER = 0, 1, 2, 2 + len(LegNumbers._fields)
GRAVITY, SPRING = FIRST + LegNumbers._fields.index("g_x"), OTHER + len(LegNumbers._fields)


@compiled
def rubbed(rate: float) -> float:
    """Share of the friction torque that resists a rate of the hip, -1 to 1."""
    return min(max(rate / HIP_CREEP, -1.0), 1.0)


@compiled
def hip_load(y: Vector, p: Penalty) -> tuple[float, float, float]:
    """Weight of the hip along x and y [N]; torque between the legs [N m] on the angle of leg 0, and with the opposite
    sign on that of leg 1."""
    rate = y[8] - y[9]
    torque = -p.k_h * (y[2] - y[3] - p.phi_h) - p.b_h * rate - p.tau_h * rubbed(rate)
    return p.M_g * p.first.g_x, p.M_g * p.first.g_y, torque


@compiled
def torque_variation(y: Vector, start: int, p: Penalty) -> float:
    """Change of the torque for the variation stored from `start`."""
    slope = p.b_h
    if abs(y[8] - y[9]) < HIP_CREEP:
        slope += p.tau_h / HIP_CREEP
    change: float = -p.k_h * (y[start + 2] - y[start + 3]) - slope * (y[start + 8] - y[start + 9])
    return change


@compiled
def hip_change(y: Vector, a: np.ndarray, row: int, ax: float, ay: float, p: Penalty) -> tuple[float, float, float]:
    """Change of the hip's weight less its mass times its acceleration, and of the torque, for a row of changes of the
    walker's numbers."""
    mass, weight, rate = a[row, MASS], a[row, WEIGHED], y[8] - y[9]
    stretch = y[2] - y[3] - p.phi_h
    torque = -a[row, SPRING] * stretch - a[row, SPRING + 1] * rate + p.k_h * a[row, SPRING + 2]
    return (
        (weight - mass) * p.first.g_x + mass * (p.first.g_x - ax) + p.M_g * a[row, GRAVITY],
        (weight - mass) * p.first.g_y + mass * (p.first.g_y - ay) + p.M_g * a[row, GRAVITY + 1],
        torque - a[row, SPRING + 3] * rubbed(rate),
    )


@compiled
def terms_of(y: Vector, leg: int, p: Penalty) -> Numbers:
    """`leg_terms` of a leg of the state (12,)."""
    above = y[1] - block_under(p, leg)
    return leg_terms(above, y[2 + leg], y[4 + leg], y[6], y[7], y[8 + leg], y[10 + leg], leg_of(p, leg))


@compiled
def plain_eliminated(t: Numbers, slide: float, p: PlainLeg) -> Numbers:
    """`eliminated` of Table 1's leg, whose angle and length do not push each other."""
    i, k = 1.0 / t[4], slide / p.m
    return i, t[0] * i, t[1] * k, t[2] * i, t[3] * k, k, 0.0


@compiled
def detailed_eliminated(t: Numbers, slide: float, p: LegNumbers) -> Numbers:
    """`eliminated` of any other leg."""
    i, j, k = 1.0 / t[4], 0.0, 0.0
    if slide != 0.0:
        inverse = 1.0 / (t[4] * p.m - t[16] * t[16])
        i, j, k = inverse * p.m, -inverse * t[16], inverse * t[4]
    return i, t[0] * i + t[1] * j, t[0] * j + t[1] * k, t[2] * i + t[3] * j, t[2] * j + t[3] * k, k, j


#: From a leg's terms the inverse of the mass matrix of its angle and length, and what that makes of the hip's x and y:
#: angle; angle and length for x, for y; length; both. With `slide` 0 there is none for the length: eliminated(t, slide,
#: p).
eliminated: Callable[..., Numbers] = ByKind({PlainLeg: plain_eliminated, LegNumbers: detailed_eliminated})


@compiled
def factor(t: Numbers, u: Numbers, p: Penalty) -> Numbers:
    """Factors of the mass matrix from the terms of leg 0 and of leg 1, for `solve`."""
    i0, a0, b0, c0, d0, k0, j0 = eliminated(t, p.slide, p.first)
    i1, a1, b1, c1, d1, k1, j1 = eliminated(u, p.slide, p.other)
    total = p.M + (p.first.m + p.first.m_f + (p.other.m + p.other.m_f))
    s11 = total - t[0] * a0 - t[1] * b0 - u[0] * a1 - u[1] * b1
    s12 = -t[0] * c0 - t[1] * d0 - u[0] * c1 - u[1] * d1
    s22 = total - t[2] * c0 - t[3] * d0 - u[2] * c1 - u[3] * d1
    inverse = 1.0 / (s11 * s22 - s12 * s12)
    return (i0, i1, a0, b0, c0, d0, a1, b1, c1, d1, s22 * inverse, -s12 * inverse, s11 * inverse, k0, k1, j0, j1)


@compiled
def solve(
    f: Numbers, x: float, y: float, angle0: float, angle1: float, length0: float, length1: float
) -> Six:
    """Solution of M qdd = (x, y, angles, lengths) from the factors of M."""
    g1 = x - f[2] * angle0 - f[3] * length0 - f[6] * angle1 - f[7] * length1
    g2 = y - f[4] * angle0 - f[5] * length0 - f[8] * angle1 - f[9] * length1
    ax = f[10] * g1 + f[11] * g2
    ay = f[11] * g1 + f[12] * g2
    return (
        ax,
        ay,
        f[0] * angle0 - f[2] * ax - f[4] * ay + f[15] * length0,
        f[1] * angle1 - f[6] * ax - f[8] * ay + f[16] * length1,
        f[13] * length0 - f[3] * ax - f[5] * ay + f[15] * angle0,
        f[14] * length1 - f[7] * ax - f[9] * ay + f[16] * angle1,
    )


@compiled
def accelerations(phase: int, y: Vector, p: Penalty) -> tuple[Six, Forces, Numbers, Numbers, Numbers]:
    """qdd, the ground's forces (normal, friction of leg 0, then of leg 1) [N], factors of M and both legs' terms."""
    t, u = terms_of(y, 0, p), terms_of(y, 1, p)
    n0, f0 = foot_force(acts_on(phase, 0), t[9], t[10], t[11], p.law)
    n1, f1 = foot_force(acts_on(phase, 1), u[9], u[10], u[11], p.law)
    factors, (x, upward, torque) = factor(t, u, p), hip_load(y, p)
    qdd = solve(
        factors,
        x + t[5] + u[5] + f0 + f1,
        upward + t[6] + u[6] + n0 + n1,
        t[7] + t[12] * n0 + t[14] * f0 + torque,
        u[7] + u[12] * n1 + u[14] * f1 - torque,
        t[8] + t[13] * n0 + t[15] * f0,
        u[8] + u[13] * n1 + u[15] * f1,
    )
    return qdd, (n0, f0, n1, f1), factors, t, u
