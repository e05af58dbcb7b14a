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
from stages.penalty.motion.contact import foot_force
from stages.penalty.motion.feet import acts_on
from stages.penalty.motion.hip import hip_load

Vector = np.ndarray
Six = tuple[float, float, float, float, float, float]
Forces = tuple[float, float, float, float]
Three = tuple[float, float, float]


@compiled
def terms_of(y: Vector, leg: int, p: Walker) -> Numbers:
    """`leg_terms` of a leg of the state (12,)."""
    return leg_terms(y[1], y[2 + leg], y[4 + leg], y[6], y[7], y[8 + leg], y[10 + leg], leg_of(p, leg))


@compiled
def plain_inverse(t: Numbers, u: Numbers, p: Penalty) -> tuple[Three, Three, float]:
    """`inverses` of Table 1's walker."""
    return (1.0 / t[4], 0.0, p.slide), (1.0 / u[4], 0.0, p.slide), p.M + 2.0 * p.m


@compiled
def inverse_of(t: Numbers, p: LegNumbers, slide: float) -> Three:
    """Of one leg of a detailed walker."""
    if slide == 0.0:
        return 1.0 / t[4], 0.0, 0.0
    inverse = 1.0 / (t[4] * p.m - t[16] * t[16])
    return inverse * p.m, -inverse * t[16], inverse * t[4]


@compiled
def detailed_inverse(t: Numbers, u: Numbers, p: DetailedPenalty) -> tuple[Three, Three, float]:
    """`inverses` of a detailed walker."""
    legs = p.first.m + p.first.m_f + (p.other.m + p.other.m_f)
    return inverse_of(t, p.first, p.slide), inverse_of(u, p.other, p.slide), p.M + legs


#: Inverse of the mass matrix of (angle, length) of both legs, three numbers each, and the whole mass: from both legs'
#: terms, inverses(t, u, p).
inverses: Callable[..., tuple[Three, Three, float]] = ByKind({
    Penalty: plain_inverse, DetailedPenalty: detailed_inverse})


@compiled
def factor(t: Numbers, u: Numbers, p: Walker) -> Numbers:
    """Factors of the mass matrix from the terms of leg 0 and of leg 1, for `solve`."""
    (i0, j0, k0), (i1, j1, k1), total = inverses(t, u, p)
    a0, b0, c0, d0 = t[0] * i0 + t[1] * j0, t[0] * j0 + t[1] * k0, t[2] * i0 + t[3] * j0, t[2] * j0 + t[3] * k0
    a1, b1, c1, d1 = u[0] * i1 + u[1] * j1, u[0] * j1 + u[1] * k1, u[2] * i1 + u[3] * j1, u[2] * j1 + u[3] * k1
    s11 = total - t[0] * a0 - t[1] * b0 - u[0] * a1 - u[1] * b1
    s12 = -t[0] * c0 - t[1] * d0 - u[0] * c1 - u[1] * d1
    s22 = total - t[2] * c0 - t[3] * d0 - u[2] * c1 - u[3] * d1
    inverse = 1.0 / (s11 * s22 - s12 * s12)
    return (i0, i1, a0, b0, c0, d0, a1, b1, c1, d1, s22 * inverse, -s12 * inverse, s11 * inverse, k0, k1, j0, j1)


@compiled
def solve(f: Numbers, x: float, y: float, angle0: float, angle1: float, length0: float, length1: float) -> Six:
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
    )
    return qdd, (n0, f0, n1, f1), factors, t, u
