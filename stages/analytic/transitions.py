"""Heel strike and toe-off: guards with their rates, and the plastic impact with its derivative.

Coordinates as in `flow`. At heel strike the legs change names: theta+ = -psi, psi+ = -theta, L_1 and L_2 swap.
"""

from __future__ import annotations

from math import cos, sin

import numpy as np

from stages.analytic import equations as eq
from stages.analytic.compiled import compiled
from stages.analytic.elimination import factor, factor_constrained, solve, solve_constrained
from stages.analytic.flow import (
    RIGID,
    contact_directions,
    double_acceleration,
    double_jacobians,
    double_variation,
    row_times,
)


@compiled
def foot_clearance(phase, y, p):
    """Height of the swing foot above the ground, its rate, and its advance on the stance foot: eq. (3)."""
    if phase == RIGID:
        theta, stance, psi, swing = y[0], p[2] - p[3], y[1], p[2] - p[3]
        dtheta, dstance, dpsi, dswing = y[2], 0.0, y[3], 0.0
    else:
        theta, stance, psi, swing = y[0], y[1] - p[3], y[2], y[3] - p[3]
        dtheta, dstance, dpsi, dswing = y[4], y[5], y[6], y[7]
    height = stance * cos(theta) - swing * cos(psi)
    rate = dstance * cos(theta) - stance * sin(theta) * dtheta - dswing * cos(psi) + swing * sin(psi) * dpsi
    return height, rate, stance * sin(theta) + swing * sin(psi)


@compiled
def clearance_variation(phase, y, p, start):
    """Change of the clearance for the variation stored from `start`."""
    if phase == RIGID:
        leg = p[2] - p[3]
        return leg * (sin(y[1]) * y[start + 1] - sin(y[0]) * y[start])
    return (
        cos(y[0]) * y[start + 1]
        - (y[1] - p[3]) * sin(y[0]) * y[start]
        - cos(y[2]) * y[start + 3]
        + (y[3] - p[3]) * sin(y[2]) * y[start + 2]
    )


@compiled
def toe_off_guard(y, p, rates):
    """Normal force of the trailing foot in double stance and its rate along `rates` = dy/dt."""
    qdd, force, factors, constrained, normal, roll = double_acceleration(y, p)
    jacobians = double_jacobians(y, qdd, force, p)
    _, change = double_variation(jacobians, (factors, constrained, normal, roll), rates, 0)
    return force[0], change[0]


@compiled
def toe_off_variation(y, p, start):
    """Change of the trailing foot's normal force for the variation stored from `start`."""
    qdd, force, factors, constrained, normal, roll = double_acceleration(y, p)
    jacobians = double_jacobians(y, qdd, force, p)
    _, change = double_variation(jacobians, (factors, constrained, normal, roll), y, start)
    return change[0]


@compiled
def without_forces(p):
    """Parameters with stiffness, damping and gravity off: what is left of the equations is inertia."""
    return p[0], p[1], p[2], p[3], p[4], 0.0, 0.0, p[7], 0.0, 0.0


@compiled
def landing_impulse(y, p):
    """Velocities after a compliant walker's heel strike, in the names before it, and the impulse on the landing foot.

    The landing foot comes to rest on the ground and rolls, the other foot keeps rolling (eq. (6) over the impact):
    M (qd+ - qd-) = Pi Lambda, Pi^T qd+ = 0. Springs and dampers give no impulse.
    """
    t = eq.compliant_terms(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p)
    factors = factor(t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7], t[9])
    normal, roll, _, _ = contact_directions(y, p)
    constrained = factor_constrained(factors, normal, roll)
    before = (y[4], y[5], y[6], y[7])
    after, impulse = solve_constrained(factors, constrained, normal, roll, before, 0.0, 0.0)
    return after, impulse, factors, constrained, normal, roll


@compiled
def rename_legs(y, start):
    """Exchange the legs' roles in one 8-vector (q, qd), in place."""
    for i in (0, 4):
        y[start + i], y[start + i + 2] = -y[start + i + 2], -y[start + i]
        y[start + i + 1], y[start + i + 3] = y[start + i + 3], y[start + i + 1]


@compiled
def compliant_reset(y, p):
    """Heel strike of compliant legs on the state and its variations, in place."""
    after, impulse, factors, constrained, normal, roll = landing_impulse(y, p)
    if y.size > 8:
        inertia = without_forces(p)
        by_mass = eq.compliant_residual_jacobian(
            y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0,
            after[0] - y[4], after[1] - y[5], after[2] - y[6], after[3] - y[7], inertia)
        by_force = eq.contact_force_jacobian(y[0], y[1], y[2], y[3], impulse[0], impulse[1], p)
        by_contact = eq.contact_acceleration_jacobian(
            y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, after[0], after[1], after[2], after[3], p)
        for start in range(8, y.size, 8):
            change = solve(
                factors,
                row_times(by_force, 0, 4, y, start) - by_position(by_mass, 0, y, start),
                row_times(by_force, 1, 4, y, start) - by_position(by_mass, 1, y, start),
                row_times(by_force, 2, 4, y, start) - by_position(by_mass, 2, y, start),
                row_times(by_force, 3, 4, y, start) - by_position(by_mass, 3, y, start),
            )
            free = (y[start + 4] + change[0], y[start + 5] + change[1],
                    y[start + 6] + change[2], y[start + 7] + change[3])
            jump, _ = solve_constrained(
                factors, constrained, normal, roll, free,
                -by_position(by_contact, 0, y, start), -by_position(by_contact, 1, y, start))
            for i in range(4):
                y[start + 4 + i] = jump[i]
            rename_legs(y, start)
    for i in range(4):
        y[4 + i] = after[i]
    rename_legs(y, 0)


@compiled
def by_position(matrix, row, dy, start):
    """The position half of one row of a (n, 8) Jacobian, times a variation."""
    total = 0.0
    for column in range(4):
        total += matrix[row * 8 + column] * dy[start + column]
    return total


@compiled
def rigid_reset(y, p):
    """Heel strike of rigid legs on the state and its variations, in place; the trailing foot leaves at once."""
    a11, a12, a21, a22 = eq.rigid_handover(y[0], y[1], p)
    momentum1 = a11 * y[2] + a12 * y[3]
    momentum2 = a21 * y[2] + a22 * y[3]
    theta, psi = -y[1], -y[0]
    m11, m12, m22, _, _ = eq.rigid_terms(theta, psi, 0.0, 0.0, p)
    inverse = 1.0 / (m11 * m22 - m12 * m12)
    dtheta = inverse * (m22 * momentum1 - m12 * momentum2)
    dpsi = inverse * (m11 * momentum2 - m12 * momentum1)
    if y.size > 4:
        before = eq.rigid_handover_jacobian(y[0], y[1], y[2], y[3], p)
        after = eq.rigid_residual_jacobian(theta, psi, 0.0, 0.0, dtheta, dpsi, without_forces(p))
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


@compiled
def heel_strike_reset(phase, y, p):
    """State and variations just after heel strike, in the new names, in place."""
    if phase == RIGID:
        rigid_reset(y, p)
    else:
        compliant_reset(y, p)


@compiled
def hidden_crossing(g0, d0, g1, d1, h):
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
