"""Heel strike and toe-off: what decides them, and the plastic impact with its derivative.

Coordinates as in `flow`. At heel strike the legs change names: theta+ = -psi, psi+ = -theta, L_1 and L_2 swap.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, sin

import numpy as np

from stages.analytic.compiled import ByKind, Constrained, Four, Numbers, compiled, inlined
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import factor_constrained, solve_constrained
from stages.analytic.model.kinds import (
    Compliant,
    DetailedCompliant,
    DetailedRigid,
    Limited,
    PlainCompliant,
    PlainRigid,
    Rigid,
    Rolling,
    RubbingRigid,
    TimedRigid,
)
from stages.analytic.model.walker import Vector
from stages.analytic.phases.coulomb_impact import limited_reset
from stages.analytic.phases.flow import (
    contact_directions,
    double_acceleration,
    double_jacobians,
    double_variation,
    row4_times,
)
from stages.analytic.phases.impulse_terms import free_jump, impulse_jacobians

Clearance = tuple[float, float, float]


@compiled
def rigid_clearance(y: Vector, p: PlainRigid, dy: Vector, start: int) -> Clearance:
    """`foot_clearance` of rigid legs."""
    leg, theta, psi = p.L_nat - p.r, y[0], y[1]
    ahead, behind = leg * sin(psi), leg * sin(theta)
    if start == 0:  # one product more than below: published digits rest on the round-off of either
        change = ahead * dy[1] - behind * dy[0]
    else:
        change = leg * (sin(psi) * dy[start + 1] - sin(theta) * dy[start])
    return leg * cos(theta) - leg * cos(psi), change, behind + ahead


@compiled
def compliant_clearance(y: Vector, p: PlainCompliant, dy: Vector, start: int) -> Clearance:
    """`foot_clearance` of compliant legs."""
    theta, stance, psi, swing = y[0], y[1] - p.r, y[2], y[3] - p.r
    height = stance * cos(theta) - swing * cos(psi)
    change = (cos(theta) * dy[start + 1] - stance * sin(theta) * dy[start]
              - cos(psi) * dy[start + 3] + swing * sin(psi) * dy[start + 2])
    return height, change, stance * sin(theta) + swing * sin(psi)


@compiled
def detailed_rigid_clearance(y: Vector, p: DetailedRigid, dy: Vector, start: int) -> Clearance:
    """`foot_clearance` of rigid legs that may differ."""
    stance, swing, theta, psi = p.L_nat - p.r, p.L_nat_2 - p.r_2, y[0], y[1]
    ahead, behind = swing * sin(psi), stance * sin(theta)
    return (stance * cos(theta) - swing * cos(psi) + (p.r - p.r_2), ahead * dy[start + 1] - behind * dy[start],
            behind + ahead)


@compiled
def detailed_clearance(y: Vector, p: DetailedCompliant, dy: Vector, start: int) -> Clearance:
    """`foot_clearance` of compliant legs that may differ."""
    theta, stance, psi, swing = y[0], y[1] - p.r, y[2], y[3] - p.r_2
    height = stance * cos(theta) - swing * cos(psi) + (p.r - p.r_2)
    change = (cos(theta) * dy[start + 1] - stance * sin(theta) * dy[start]
              - cos(psi) * dy[start + 3] + swing * sin(psi) * dy[start + 2])
    return height, change, stance * sin(theta) + swing * sin(psi)


#: Height of the swing foot above the ground, its change for the change of the coordinates stored in `dy` from `start`,
#: and its advance on the stance foot, eq. (3): foot_clearance(y, p, dy, start).
foot_clearance: Callable[..., Clearance] = ByKind({
    PlainRigid: rigid_clearance, PlainCompliant: compliant_clearance,
    DetailedRigid | RubbingRigid | TimedRigid: detailed_rigid_clearance, DetailedCompliant: detailed_clearance})


@inlined
def trailing_force(y: Vector, p: Compliant, dy: Vector, start: int) -> tuple[tuple[float, float], tuple[float, float]]:
    """lambda of double stance, and its change for the variation of the state stored in `dy` from `start`."""
    qdd, force, factors, constrained, normal, roll = double_acceleration(y, p)
    _, change = double_variation(
        double_jacobians(y, qdd, force, p), (factors, constrained, normal, roll), dy, start)
    return force, change


@compiled
def landing_impulse(y: Vector, p: Compliant) -> tuple[Four, tuple[float, float], Numbers, Constrained, Four, Four]:
    """Velocities after a compliant walker's heel strike, in the names before it, and the impulse on the landing foot.

    The landing foot comes to rest on the ground and rolls, the other foot keeps rolling (eq. (6) over the impact):
    M (qd+ - qd-) = Pi Lambda, Pi^T qd+ = 0. Springs and dampers give no impulse.
    """
    t = eq.compliant_terms(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p)
    factors = eq.mass_factors(t, p)
    normal, roll, _, _ = contact_directions(y, p)
    constrained = factor_constrained(factors, normal, roll)
    before = (y[4], y[5], y[6], y[7])
    after, impulse = solve_constrained(factors, constrained, normal, roll, before, 0.0, 0.0)
    return after, impulse, factors, constrained, normal, roll


@inlined
def rename_legs(y: Vector, start: int) -> None:
    """Exchange the legs' roles in one 8-vector (q, qd), in place."""
    for i in (0, 4):
        y[start + i], y[start + i + 2] = -y[start + i + 2], -y[start + i]
        y[start + i + 1], y[start + i + 3] = y[start + i + 3], y[start + i + 1]


@compiled
def rolling_reset(y: Vector, p: Compliant) -> bool:
    """Heel strike of compliant legs with rolling feet on the state and its variations, in place."""
    after, impulse, factors, constrained, normal, roll = landing_impulse(y, p)
    if y.size > 8:
        jacobians = impulse_jacobians(y, (y[4], y[5], y[6], y[7]), after, impulse, p)
        for start in range(8, y.size, 8):
            free = free_jump(jacobians, factors, y, start)
            jump, _ = solve_constrained(
                factors, constrained, normal, roll, free,
                -row4_times(jacobians[2][0:4], y, start), -row4_times(jacobians[2][8:12], y, start))
            for i in range(4):
                y[start + 4 + i] = jump[i]
    for i in range(4):
        y[4 + i] = after[i]
    for start in range(0, y.size, 8):
        rename_legs(y, start)
    return True


@compiled
def rigid_reset(y: Vector, p: Rigid) -> bool:
    """Heel strike of rigid legs on the state and its variations, in place; the trailing foot leaves at once."""
    a11, a12, a21, a22 = eq.rigid_handover(y[0], y[1], p)
    momentum1 = a11 * y[2] + a12 * y[3]
    momentum2 = a21 * y[2] + a22 * y[3]
    theta, psi, after_p = -y[1], -y[0], eq.exchanged(p)
    m11, m12, m22, _, _ = eq.rigid_terms(theta, psi, 0.0, 0.0, after_p)
    inverse = 1.0 / (m11 * m22 - m12 * m12)
    dtheta = inverse * (m22 * momentum1 - m12 * momentum2)
    dpsi = inverse * (m11 * momentum2 - m12 * momentum1)
    if y.size > 4:
        before = eq.rigid_handover_jacobian(y[0], y[1], y[2], y[3], p)
        after = eq.rigid_inertia_jacobian(theta, psi, dtheta, dpsi, after_p)
        for s in range(4, y.size, 4):
            new1, new2 = -y[s + 1], -y[s]
            f1 = (a11 * y[s + 2] + a12 * y[s + 3] + before[0] * y[s] + before[1] * y[s + 1]
                  - after[0] * new1 - after[1] * new2)
            f2 = (a21 * y[s + 2] + a22 * y[s + 3] + before[2] * y[s] + before[3] * y[s + 1]
                  - after[4] * new1 - after[5] * new2)
            y[s], y[s + 1] = new1, new2
            y[s + 2] = inverse * (m22 * f1 - m12 * f2)
            y[s + 3] = inverse * (m11 * f2 - m12 * f1)
    y[0], y[1], y[2], y[3] = theta, psi, dtheta, dpsi
    return True


#: State and variations just after heel strike, in the new names, in place; False if the impact is undecided:
#: heel_strike_reset(y, p).
heel_strike_reset: Callable[..., bool] = ByKind({Rigid: rigid_reset, Rolling: rolling_reset, Limited: limited_reset})


@inlined
def hidden_crossing(g0: float, d0: float, g1: float, d1: float, h: float) -> bool:
    """Whether the cubic through values g and rates d at both ends of a step crosses zero twice inside it."""
    if g0 * g1 <= 0.0:
        return False
    a = 6.0 * (g0 - g1) + 3.0 * h * (d0 + d1)
    b = 6.0 * (g1 - g0) - 2.0 * h * (2.0 * d0 + d1)
    c = h * d0
    discriminant = b * b - 4.0 * a * c
    if discriminant <= 0.0:
        return False
    root = np.sqrt(discriminant)
    for extremum in ((-b - root) / (2.0 * a), (-b + root) / (2.0 * a)) if a != 0.0 else (-c / b, -c / b):
        if 0.0 < extremum < 1.0:
            s = extremum
            value = (
                g0 * (1.0 + 2.0 * s) * (1.0 - s) ** 2
                + h * d0 * s * (1.0 - s) ** 2
                + g1 * s * s * (3.0 - 2.0 * s)
                - h * d1 * s * s * (1.0 - s)
            )
            if value * g0 < 0.0:
                return True
    return False
