"""Heel strike: the plastic impact of both feet, with its tangents. The legs change names: theta+ = -psi, psi+ = -theta.

First the landing foot alone comes to rest and rolls. Momenta of all motions that keep it rolling are kept:
M(q+) qd+ = H(q-) qd-. Rigid legs' trailing foot leaves at once. That of compliant legs is met by the ground in turn:
M (qd+ - qd-) = Pi Lambda; springs, dampers and gravity give no impulse. One that rolls whatever that takes comes to
rest, as if both feet had been held at once. With limited friction its contact pushes only, and may let go or slip:
Moreau's impact law with no restitution, friction by the slip after the impact:

    0 <= Lambda_N,  0 <= v_N+,  Lambda_N v_N+ = 0;   |Lambda_T| <= mu_s Lambda_N where it sticks,
    Lambda_T = -mu_d sign(v_T+) Lambda_N where it slips.

J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics, 1988; F. Pfeiffer and Ch. Glocker,
Multibody dynamics with unilateral contacts, 1996, chapter 8. The law has one solution unless friction can wedge the
foot (mu |W_NT| >= W_NN of the inverse contact mass W = Pi^T M^-1 Pi); where it has several or none, nothing is chosen.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from stages.analytic.compiled import ByKind, compiled
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import dot, solve
from stages.analytic.model.kinds import Compliant, Directions, Rigid
from stages.analytic.model.walker import Vector
from stages.analytic.phases.motion import Contact, contact_directions, held, rolling, row4_times, slipping

#: What the trailing foot does after an impact.
LIFTS, STICKS, SLIPS, UNDECIDED = 0, 1, 2, 3


@compiled
def trailing_impulse(y: Vector, p: Compliant) -> tuple[int, tuple[float, float], Any, Contact]:
    """What the trailing foot does in an impact (one of the above), its impulse, and the factors of M and the contact
    that solve the same system again.

    `y` is the state with the landing foot at rest already, in the names after heel strike.
    """
    t = eq.compliant_terms(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p)
    factors = eq.mass_factors(t, p)
    normal, roll, _, _ = contact_directions(y, p)
    before = (y[4], y[5], y[6], y[7])
    contact = rolling(factors, normal, roll)
    _, stuck = held(contact, before, 0.0, 0.0)
    if p.mu_s == np.inf:
        return STICKS, stuck, factors, contact
    normal_speed, slip = dot(normal, before), dot(roll, before)
    found, impulse = LIFTS, (0.0, 0.0)
    if stuck[0] > 0.0 and abs(stuck[1]) <= p.mu_s * stuck[0]:
        found, impulse = STICKS, stuck
    else:
        for sign in (1.0, -1.0):
            there = slipping(factors, normal, roll, -sign * p.mu_d)
            _, force = held(there, before, 0.0, 0.0)
            if force[0] > 0.0 and sign * (slip + dot(roll, there.by_normal) * force[0]) > 0.0:
                found, impulse, contact = SLIPS, force, there
    if (normal_speed >= 0.0) != (found == LIFTS):
        found = UNDECIDED
    return found, impulse, factors, contact


@compiled
def strike(y: Vector, p: Compliant, directions: Directions | None = None, renamed: bool = False) -> bool:
    """The trailing foot meets the ground, or is let go of, in place; False where the law does not decide.

    `renamed`: the legs have changed names since `directions` were given.
    """
    found, impulse, factors, contact = trailing_impulse(y, p)
    if found in (LIFTS, UNDECIDED):
        return found == LIFTS
    after, _ = held(contact, (y[4], y[5], y[6], y[7]), 0.0, 0.0)
    if y.size > 8:
        jump = (after[0] - y[4], after[1] - y[5], after[2] - y[6], after[3] - y[7])
        by_mass = eq.compliant_inertia_jacobian(y[0], y[1], y[2], y[3], jump[0], jump[1], jump[2], jump[3], p)
        by_force = eq.contact_force_jacobian(y[0], y[1], y[2], y[3], impulse[0], impulse[1], p)
        by_contact = eq.contact_acceleration_jacobian(
            y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, after[0], after[1], after[2], after[3], p)
        first, backwards = y.size, -1.0 if dot(contact.roll, after) > 0.0 else 1.0
        if directions is not None:
            by = eq.compliant_impulse_by(
                y[0], y[1], y[2], y[3], jump[0], jump[1], jump[2], jump[3], impulse[0], impulse[1], p)
            by_rates = eq.contact_acceleration_by(
                y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, after[0], after[1], after[2], after[3], p)
            first = y.size - 8 * directions.rows.shape[0]
        for s in range(8, y.size, 8):
            f1 = row4_times(by_force[0:4], y, s) - row4_times(by_mass[0:4], y, s)
            f2 = row4_times(by_force[4:8], y, s) - row4_times(by_mass[8:12], y, s)
            f3 = row4_times(by_force[8:12], y, s) - row4_times(by_mass[16:20], y, s)
            f4 = row4_times(by_force[12:16], y, s) - row4_times(by_mass[24:28], y, s)
            target1, target2 = -row4_times(by_contact[0:4], y, s), -row4_times(by_contact[8:12], y, s)
            if directions is not None and s >= first:
                d = eq.row_as(p, directions.rows, (s - first) // 8)
                d = eq.exchanged(d) if renamed else d
                change, more = eq.compliant_impulse_change(by, d), eq.contact_acceleration_change(by_rates, d)
                drag = backwards * d.mu_d * impulse[0] if found == SLIPS else 0.0
                f1, f2 = f1 - change[0] + drag * contact.roll[0], f2 - change[1] + drag * contact.roll[1]
                f3, f4 = f3 - change[2] + drag * contact.roll[2], f4 - change[3] + drag * contact.roll[3]
                target1, target2 = target1 - more[0], target2 - more[1]
            free = solve(factors, f1, f2, f3, f4)
            free = (y[s + 4] + free[0], y[s + 5] + free[1], y[s + 6] + free[2], y[s + 7] + free[3])
            (y[s + 4], y[s + 5], y[s + 6], y[s + 7]), _ = held(contact, free, target1, target2)
    y[4], y[5], y[6], y[7] = after
    return True


@compiled
def land(y: Vector, p: Compliant, directions: Directions | None = None) -> None:
    """The landing foot alone comes to rest and rolls; state and variations in the new names, in place."""
    handover = eq.compliant_handover(y[0], y[1], y[2], y[3], p)
    q, after_p = (-y[2], y[3], -y[0], y[1]), eq.exchanged(p)
    t = eq.compliant_terms(q[0], q[1], q[2], q[3], 0.0, 0.0, 0.0, 0.0, after_p)
    factors = eq.mass_factors(t, after_p)
    after = solve(factors, row4_times(handover[0:4], y, 4), row4_times(handover[4:8], y, 4),
                  row4_times(handover[8:12], y, 4), row4_times(handover[12:16], y, 4))
    if y.size > 8:
        by_place = eq.compliant_handover_jacobian(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p)
        by_mass = eq.compliant_inertia_jacobian(
            q[0], q[1], q[2], q[3], after[0], after[1], after[2], after[3], after_p)
        first = y.size
        if directions is not None:
            by_handover = eq.compliant_handover_by(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p)
            by_inertia = eq.compliant_impulse_by(
                q[0], q[1], q[2], q[3], after[0], after[1], after[2], after[3], 0.0, 0.0, after_p)
            first = y.size - 8 * directions.rows.shape[0]
        for s in range(8, y.size, 8):
            f1 = row4_times(handover[0:4], y, s + 4) + row4_times(by_place[0:4], y, s)
            f2 = row4_times(handover[4:8], y, s + 4) + row4_times(by_place[4:8], y, s)
            f3 = row4_times(handover[8:12], y, s + 4) + row4_times(by_place[8:12], y, s)
            f4 = row4_times(handover[12:16], y, s + 4) + row4_times(by_place[12:16], y, s)
            y[s], y[s + 1], y[s + 2], y[s + 3] = -y[s + 2], y[s + 3], -y[s], y[s + 1]
            f1, f2 = f1 - row4_times(by_mass[0:4], y, s), f2 - row4_times(by_mass[8:12], y, s)
            f3, f4 = f3 - row4_times(by_mass[16:20], y, s), f4 - row4_times(by_mass[24:28], y, s)
            if directions is not None and s >= first:
                d = eq.row_as(p, directions.rows, (s - first) // 8)
                given = eq.compliant_handover_change(by_handover, d)
                needed = eq.compliant_impulse_change(by_inertia, eq.exchanged(d))
                f1, f2 = f1 + given[0] - needed[0], f2 + given[1] - needed[1]
                f3, f4 = f3 + given[2] - needed[2], f4 + given[3] - needed[3]
            y[s + 4], y[s + 5], y[s + 6], y[s + 7] = solve(factors, f1, f2, f3, f4)
    y[0], y[1], y[2], y[3] = q
    y[4], y[5], y[6], y[7] = after


@compiled
def compliant_reset(y: Vector, p: Compliant, directions: Directions | None = None) -> bool:
    """`heel_strike_reset` of compliant legs."""
    land(y, p, directions)
    return strike(y, eq.exchanged(p), directions, True)


@compiled
def rigid_reset(y: Vector, p: Rigid, directions: Directions | None = None) -> bool:
    """`heel_strike_reset` of rigid legs."""
    a11, a12, a21, a22 = eq.rigid_handover(y[0], y[1], p)
    momentum1, momentum2 = a11 * y[2] + a12 * y[3], a21 * y[2] + a22 * y[3]
    theta, psi, after_p = -y[1], -y[0], eq.exchanged(p)
    m11, m12, m22, _, _ = eq.rigid_terms(theta, psi, 0.0, 0.0, after_p)
    inverse = 1.0 / (m11 * m22 - m12 * m12)
    dtheta, dpsi = inverse * (m22 * momentum1 - m12 * momentum2), inverse * (m11 * momentum2 - m12 * momentum1)
    if y.size > 4:
        before = eq.rigid_handover_jacobian(y[0], y[1], y[2], y[3], p)
        after = eq.rigid_inertia_jacobian(theta, psi, dtheta, dpsi, after_p)
        first = y.size
        if directions is not None:
            by_handover = eq.rigid_handover_by(y[0], y[1], y[2], y[3], p)
            by_inertia = eq.rigid_impulse_by(theta, psi, dtheta, dpsi, after_p)
            first = y.size - 4 * directions.rows.shape[0]
        for s in range(4, y.size, 4):
            new1, new2 = -y[s + 1], -y[s]
            f1 = (a11 * y[s + 2] + a12 * y[s + 3] + before[0] * y[s] + before[1] * y[s + 1]
                  - after[0] * new1 - after[1] * new2)
            f2 = (a21 * y[s + 2] + a22 * y[s + 3] + before[2] * y[s] + before[3] * y[s + 1]
                  - after[4] * new1 - after[5] * new2)
            if directions is not None and s >= first:
                d = eq.row_as(p, directions.rows, (s - first) // 4)
                given = eq.rigid_handover_change(by_handover, d)
                needed = eq.rigid_impulse_change(by_inertia, eq.exchanged(d))
                f1, f2 = f1 + given[0] - needed[0], f2 + given[1] - needed[1]
            y[s], y[s + 1] = new1, new2
            y[s + 2], y[s + 3] = inverse * (m22 * f1 - m12 * f2), inverse * (m11 * f2 - m12 * f1)
    y[0], y[1], y[2], y[3] = theta, psi, dtheta, dpsi
    return True


#: State and variations just after heel strike, in the new names, in place; False if the impact is undecided:
#: heel_strike_reset(y, p, directions).
heel_strike_reset: Callable[..., bool] = ByKind({Rigid: rigid_reset, Compliant: compliant_reset})
