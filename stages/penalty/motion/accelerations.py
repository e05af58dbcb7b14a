"""Accelerations of the penalty walker: the two legs' parts put together and the mass matrix solved in closed form.

The legs meet in the hip's x and y only, so the legs are eliminated first and two equations are left. Of a leg's angle
and length the mass matrix is inverted: diagonal in Table 1's walker, where they are polar coordinates of one mass. A
rigid leg has none for the length in its inverse: the length takes no acceleration and its equation is not asked.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stages.analytic.compiled import ByKind, Numbers
from stages.penalty.compiled import compiled
from stages.penalty.model.legs import leg_of, leg_terms
from stages.penalty.model.walker import DetailedPenalty, LegNumbers, Penalty, Walker
from stages.penalty.motion.feet import acts_on, block_under, foot_force
from stages.penalty.motion.hip import hip_load

Vector = np.ndarray
Six = tuple[float, float, float, float, float, float]
Forces = tuple[float, float, float, float]


@compiled
def terms_of(y: Vector, leg: int, p: Walker) -> Numbers:
    """`leg_terms` of a leg of the state (12,)."""
    above = y[1] - block_under(p, leg)
    return leg_terms(above, y[2 + leg], y[4 + leg], y[6], y[7], y[8 + leg], y[10 + leg], leg_of(p, leg))


@compiled
def plain_eliminated(t: Numbers, u: Numbers, p: Penalty) -> tuple[Numbers, Numbers, float]:
    """`eliminated` of Table 1's walker."""
    i0, i1 = 1.0 / t[4], 1.0 / u[4]
    first = (i0, t[0] * i0, t[1] * p.slide, t[2] * i0, t[3] * p.slide, p.slide, 0.0)
    return first, (i1, u[0] * i1, u[1] * p.slide, u[2] * i1, u[3] * p.slide, p.slide, 0.0), p.M + 2.0 * p.m


@compiled
def leg_eliminated(t: Numbers, p: LegNumbers, slide: float) -> Numbers:
    """Of one leg of a detailed walker."""
    i, j, k = 1.0 / t[4], 0.0, 0.0
    if slide != 0.0:
        inverse = 1.0 / (t[4] * p.m - t[16] * t[16])
        i, j, k = inverse * p.m, -inverse * t[16], inverse * t[4]
    return i, t[0] * i + t[1] * j, t[0] * j + t[1] * k, t[2] * i + t[3] * j, t[2] * j + t[3] * k, k, j


@compiled
def detailed_eliminated(t: Numbers, u: Numbers, p: DetailedPenalty) -> tuple[Numbers, Numbers, float]:
    """`eliminated` of a detailed walker."""
    mass = p.M + (p.first.m + p.first.m_f + (p.other.m + p.other.m_f))
    return leg_eliminated(t, p.first, p.slide), leg_eliminated(u, p.other, p.slide), mass


#: From both legs' terms, for each leg the inverse of the mass matrix of its angle and length and what that makes of the
#: hip's x and y (angle; angle and length for x, for y; length; both), and the whole mass: eliminated(t, u, p).
eliminated: Callable[..., tuple[Numbers, Numbers, float]] = ByKind({
    Penalty: plain_eliminated, DetailedPenalty: detailed_eliminated})


@compiled
def factor(t: Numbers, u: Numbers, p: Walker) -> Numbers:
    """Factors of the mass matrix from the terms of leg 0 and of leg 1, for `solve`."""
    (i0, a0, b0, c0, d0, k0, j0), (i1, a1, b1, c1, d1, k1, j1), total = eliminated(t, u, p)
    s11 = total - t[0] * a0 - t[1] * b0 - u[0] * a1 - u[1] * b1
    s12 = -t[0] * c0 - t[1] * d0 - u[0] * c1 - u[1] * d1
    s22 = total - t[2] * c0 - t[3] * d0 - u[2] * c1 - u[3] * d1
    inverse = 1.0 / (s11 * s22 - s12 * s12)
    return (i0, i1, a0, b0, c0, d0, a1, b1, c1, d1, s22 * inverse, -s12 * inverse, s11 * inverse, k0, k1, j0, j1)


@compiled
def plain_solve(
    f: Numbers, x: float, y: float, angle0: float, angle1: float, length0: float, length1: float, p: Walker
) -> Six:
    """`solve` of Table 1's walker."""
    g1 = x - f[2] * angle0 - f[3] * length0 - f[6] * angle1 - f[7] * length1
    g2 = y - f[4] * angle0 - f[5] * length0 - f[8] * angle1 - f[9] * length1
    ax = f[10] * g1 + f[11] * g2
    ay = f[11] * g1 + f[12] * g2
    return (
        ax,
        ay,
        f[0] * angle0 - f[2] * ax - f[4] * ay,
        f[1] * angle1 - f[6] * ax - f[8] * ay,
        f[13] * length0 - f[3] * ax - f[5] * ay,
        f[14] * length1 - f[7] * ax - f[9] * ay,
    )


@compiled
def detailed_solve(
    f: Numbers, x: float, y: float, angle0: float, angle1: float, length0: float, length1: float, p: DetailedPenalty
) -> Six:
    """`solve` of a detailed walker, of which a leg's angle and length push each other."""
    s: Six = plain_solve(f, x, y, angle0, angle1, length0, length1, p)
    return (s[0], s[1], s[2] + f[15] * length0, s[3] + f[16] * length1, s[4] + f[15] * angle0, s[5] + f[16] * angle1)


#: Solution of M qdd = (x, y, angles, lengths) from the factors of M, for a walker p:
#: solve(f, x, y, angle0, angle1, length0, length1, p).
solve: Callable[..., Six] = ByKind({Penalty: plain_solve, DetailedPenalty: detailed_solve})


@compiled
def accelerations(phase: int, y: Vector, p: Walker) -> tuple[Six, Forces, Numbers, Numbers, Numbers]:
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
        p,
    )
    return qdd, (n0, f0, n1, f1), factors, t, u
