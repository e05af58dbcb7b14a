"""Heel strike where the trailing foot's friction is limited and its contact pushes only.

The landing foot comes to rest and rolls. The trailing foot's contact is plastic as well, but may let go or slip:
Moreau's impact law with no restitution, both contacts at once, friction by the slip after the impact:

    0 <= Lambda_N,  0 <= v_N+,  Lambda_N v_N+ = 0;   |Lambda_T| <= mu_s Lambda_N where it sticks,
    Lambda_T = -mu_d sign(v_T+) Lambda_N where it slips.

J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics, 1988; F. Pfeiffer and Ch. Glocker,
Multibody dynamics with unilateral contacts, 1996, chapter 8. The law has one solution unless friction can wedge the
foot (mu |W_NT| >= W_NN of the inverse contact mass W = Pi^T M^-1 Pi); where it has several or none, nothing is chosen.
"""

from __future__ import annotations

from stages.analytic.compiled import Four, Numbers, compiled
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import dot, factor_constrained, solve, solve_constrained
from stages.analytic.model.kinds import Limited
from stages.analytic.model.walker import Vector
from stages.analytic.phases.flow import contact_directions, push_of, row4_times
from stages.analytic.phases.impulse_terms import free_jump, impulse_jacobians

#: What the trailing foot does after an impact.
LIFTS, STICKS, SLIPS, UNDECIDED = 0, 1, 2, 3


@compiled
def trailing_impulse(y: Vector, p: Limited) -> tuple[int, float, tuple[float, float], Numbers, Four, Four]:
    """What the trailing foot does in an impact (one of the above), its friction ratio if it slips, and its impulse.

    `y` is the state with the landing foot at rest already, in the names after heel strike. With them comes what solves
    the same system again: the factors of M, and Pi by columns.
    """
    t = eq.compliant_terms(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p)
    factors = eq.mass_factors(t, p)
    normal, roll, _, _ = contact_directions(y, p)
    before = (y[4], y[5], y[6], y[7])
    constrained = factor_constrained(factors, normal, roll)
    normal_speed, slip = dot(normal, before), dot(roll, before)
    _, stuck = solve_constrained(factors, constrained, normal, roll, before, 0.0, 0.0)
    found, ratio, impulse = LIFTS, 0.0, (0.0, 0.0)
    if stuck[0] > 0.0 and abs(stuck[1]) <= p.mu_s * stuck[0]:
        found, impulse = STICKS, stuck
    else:
        for sign in (1.0, -1.0):
            push, mobility = push_of(factors, normal, roll, -sign * p.mu_d)
            force = -normal_speed / mobility
            if force > 0.0 and sign * (slip + dot(roll, push) * force) > 0.0:
                found, ratio, impulse = SLIPS, -sign * p.mu_d, (force, -sign * p.mu_d * force)
    if (normal_speed >= 0.0) != (found == LIFTS):
        found = UNDECIDED
    return found, ratio, impulse, factors, normal, roll


@compiled
def strike(y: Vector, p: Limited) -> bool:
    """The trailing foot meets the ground, or is let go of, in place; False where the law does not decide."""
    found, ratio, impulse, factors, normal, roll = trailing_impulse(y, p)
    before = (y[4], y[5], y[6], y[7])
    if found in (LIFTS, UNDECIDED):
        return found == LIFTS
    constrained = factor_constrained(factors, normal, roll)
    push, mobility = push_of(factors, normal, roll, ratio)
    if found == STICKS:
        after, _ = solve_constrained(factors, constrained, normal, roll, before, 0.0, 0.0)
    else:
        after = (before[0] + push[0] * impulse[0], before[1] + push[1] * impulse[0],
                 before[2] + push[2] * impulse[0], before[3] + push[3] * impulse[0])
    if y.size > 8:
        jacobians = impulse_jacobians(y, before, after, impulse, p)
        for start in range(8, y.size, 8):
            free = free_jump(jacobians, factors, y, start)
            target1 = -row4_times(jacobians[2][0:4], y, start)
            target2 = -row4_times(jacobians[2][8:12], y, start)
            if found == STICKS:
                jump, _ = solve_constrained(factors, constrained, normal, roll, free, target1, target2)
            else:
                force = (target1 - dot(normal, free)) / mobility
                jump = (free[0] + push[0] * force, free[1] + push[1] * force,
                        free[2] + push[2] * force, free[3] + push[3] * force)
            for i in range(4):
                y[start + 4 + i] = jump[i]
    for i in range(4):
        y[4 + i] = after[i]
    return True


@compiled
def land(y: Vector, p: Limited) -> None:
    """The landing foot alone comes to rest and rolls; state and variations in the new names, in place.

    Momenta of all motions that keep it rolling are kept: M(q+) qd+ = H(q-) qd-.
    """
    handover = eq.compliant_handover(y[0], y[1], y[2], y[3], p)
    by_place = eq.compliant_handover_jacobian(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p)
    q, after_p = (-y[2], y[3], -y[0], y[1]), eq.exchanged(p)
    t = eq.compliant_terms(q[0], q[1], q[2], q[3], 0.0, 0.0, 0.0, 0.0, after_p)
    factors = eq.mass_factors(t, after_p)
    after = solve(factors, row4_times(handover[0:4], y, 4), row4_times(handover[4:8], y, 4),
                  row4_times(handover[8:12], y, 4), row4_times(handover[12:16], y, 4))
    if y.size > 8:
        by_mass = eq.compliant_inertia_jacobian(
            q[0], q[1], q[2], q[3], after[0], after[1], after[2], after[3], after_p)
        for s in range(8, y.size, 8):
            f1 = row4_times(handover[0:4], y, s + 4) + row4_times(by_place[0:4], y, s)
            f2 = row4_times(handover[4:8], y, s + 4) + row4_times(by_place[4:8], y, s)
            f3 = row4_times(handover[8:12], y, s + 4) + row4_times(by_place[8:12], y, s)
            f4 = row4_times(handover[12:16], y, s + 4) + row4_times(by_place[12:16], y, s)
            y[s], y[s + 1], y[s + 2], y[s + 3] = -y[s + 2], y[s + 3], -y[s], y[s + 1]
            y[s + 4], y[s + 5], y[s + 6], y[s + 7] = solve(
                factors, f1 - row4_times(by_mass[0:4], y, s), f2 - row4_times(by_mass[8:12], y, s),
                f3 - row4_times(by_mass[16:20], y, s), f4 - row4_times(by_mass[24:28], y, s))
    y[0], y[1], y[2], y[3] = q
    y[4], y[5], y[6], y[7] = after


@compiled
def limited_reset(y: Vector, p: Limited) -> bool:
    """Heel strike with limited friction on the state and its variations, in place; False where it is undecided."""
    land(y, p)
    return strike(y, eq.exchanged(p))
