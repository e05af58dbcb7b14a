"""Accelerations of the penalty walker: the two legs' parts put together and the mass matrix solved in closed form.

The legs meet in the hip's x and y only, and an angle and a length are polar coordinates of one mass, so the legs are
eliminated first and two equations are left. A rigid leg has `slide` = 0 in the place of one over its mass: its length
takes no acceleration and its equation is not asked.
"""

from __future__ import annotations

import numpy as np

from stages.analytic.compiled import Numbers
from stages.penalty.compiled import compiled
from stages.penalty.model import equations as eq
from stages.penalty.model.walker import Penalty
from stages.penalty.motion.contact import foot_force
from stages.penalty.motion.feet import acts_on

Vector = np.ndarray
Six = tuple[float, float, float, float, float, float]
Forces = tuple[float, float, float, float]


@compiled
def terms_of(y: Vector, leg: int, p: Penalty) -> Numbers:
    """`leg_terms` of a leg of the state (12,)."""
    return eq.leg_terms(y[1], y[2 + leg], y[4 + leg], y[6], y[7], y[8 + leg], y[10 + leg], p)


@compiled
def factor(t: Numbers, u: Numbers, p: Penalty) -> Numbers:
    """Factors of the mass matrix from the terms of leg 0 and of leg 1, for `solve`."""
    i0, i1 = 1.0 / t[4], 1.0 / u[4]
    a0, b0, c0, d0 = t[0] * i0, t[1] * p.slide, t[2] * i0, t[3] * p.slide
    a1, b1, c1, d1 = u[0] * i1, u[1] * p.slide, u[2] * i1, u[3] * p.slide
    total = p.M + 2.0 * p.m
    s11 = total - t[0] * a0 - t[1] * b0 - u[0] * a1 - u[1] * b1
    s12 = -t[0] * c0 - t[1] * d0 - u[0] * c1 - u[1] * d1
    s22 = total - t[2] * c0 - t[3] * d0 - u[2] * c1 - u[3] * d1
    inverse = 1.0 / (s11 * s22 - s12 * s12)
    return i0, i1, a0, b0, c0, d0, a1, b1, c1, d1, s22 * inverse, -s12 * inverse, s11 * inverse, p.slide


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
        f[0] * angle0 - f[2] * ax - f[4] * ay,
        f[1] * angle1 - f[6] * ax - f[8] * ay,
        f[13] * length0 - f[3] * ax - f[5] * ay,
        f[13] * length1 - f[7] * ax - f[9] * ay,
    )


@compiled
def accelerations(phase: int, y: Vector, p: Penalty) -> tuple[Six, Forces, Numbers, Numbers, Numbers]:
    """qdd, the ground's forces (normal, friction of leg 0, then of leg 1) [N], factors of M and both legs' terms."""
    t, u = terms_of(y, 0, p), terms_of(y, 1, p)
    n0, f0 = foot_force(acts_on(phase, 0), t[9], t[10], t[11], p.law)
    n1, f1 = foot_force(acts_on(phase, 1), u[9], u[10], u[11], p.law)
    factors = factor(t, u, p)
    qdd = solve(
        factors,
        p.M * p.g_x + t[5] + u[5] + f0 + f1,
        p.M * p.g_y + t[6] + u[6] + n0 + n1,
        t[7] + t[12] * n0 + t[14] * f0,
        u[7] + u[12] * n1 + u[14] * f1,
        t[8] + t[13] * n0 + t[15] * f0,
        u[8] + u[13] * n1 + u[15] * f1,
    )
    return qdd, (n0, f0, n1, f1), factors, t, u
