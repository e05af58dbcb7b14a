"""Impacts of a varied walker: the laws of the impact hold for its changed numbers too.

Each takes the plain walker's impact, which carries the variations across, and adds what the changes of the numbers do
to the velocities after it at a given state before it.
"""

from __future__ import annotations

import numpy as np

from stages.analytic.compiled import Four, Numbers, compiled
from stages.analytic.derivatives.equations import terms as ep
from stages.analytic.derivatives.rates import add
from stages.analytic.derivatives.response import change_of, contact_rate_change, slipping_response
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import dot, factor_constrained, solve, solve_constrained
from stages.analytic.model.kinds import Compliant, Limited
from stages.analytic.model.varied import VariedLimited, VariedRigidLegs, VariedRolling, VariedRubbingRolling
from stages.analytic.model.walker import Vector
from stages.analytic.phases.coulomb_impact import LIFTS, STICKS, UNDECIDED, land, strike, trailing_impulse
from stages.analytic.phases.flow import HOVERING, SINGLE_STANCE, push_of
from stages.analytic.phases.succession import Next, contact_phase, limited_succession
from stages.analytic.phases.transitions import foot_clearance, heel_strike_reset, landing_impulse


@compiled
def rigid_varied_reset(y: Vector, p: VariedRigidLegs) -> bool:
    """`heel_strike_reset` of rigid legs."""
    before = (y[0], y[1], y[2], y[3])
    decided = heel_strike_reset(y, p.plain)
    after_p = eq.exchanged(p.plain)
    m11, m12, m22, _, _ = eq.rigid_terms(y[0], y[1], 0.0, 0.0, after_p)
    inverse = 1.0 / (m11 * m22 - m12 * m12)
    by_handover = ep.rigid_handover_by(before[0], before[1], before[2], before[3], p.plain)
    by_inertia = ep.rigid_impulse_by(y[0], y[1], y[2], y[3], after_p)
    rows = p.along.shape[0]
    for row in range(rows):
        d = change_of(p, row)
        given, needed = ep.rigid_handover_change(by_handover, d), ep.rigid_impulse_change(by_inertia, eq.exchanged(d))
        f1, f2 = given[0] - needed[0], given[1] - needed[1]
        start = y.size - 4 * (rows - row)
        y[start + 2] += inverse * (m22 * f1 - m12 * f2)
        y[start + 3] += inverse * (m11 * f2 - m12 * f1)
    return decided


@compiled
def impulse_by(y: Vector, before: Four, after: Four, impulse: tuple[float, float], p: Compliant) -> Numbers:
    """Derivatives of M (qd+ - qd-) - Pi Lambda by the walker's numbers."""
    return ep.compliant_impulse_by(
        y[0], y[1], y[2], y[3], after[0] - before[0], after[1] - before[1], after[2] - before[2], after[3] - before[3],
        impulse[0], impulse[1], p)


@compiled
def rolling_varied_reset(y: Vector, p: VariedRolling | VariedRubbingRolling) -> bool:
    """`heel_strike_reset` of rolling feet."""
    old = np.empty(8)
    for i in range(8):
        old[i] = y[i]
    decided = heel_strike_reset(y, p.plain)
    after, impulse, factors, constrained, normal, roll = landing_impulse(old, p.plain)
    by = impulse_by(old, (old[4], old[5], old[6], old[7]), after, impulse, p.plain)
    rows = p.along.shape[0]
    for row in range(rows):
        d = change_of(p, row)
        change, contact = ep.compliant_impulse_change(by, d), contact_rate_change(old, after, p.plain, d)
        free = solve(factors, -change[0], -change[1], -change[2], -change[3])
        jump, _ = solve_constrained(factors, constrained, normal, roll, free, -contact[0], -contact[1])
        add(y, y.size - 8 * (rows - row) + 4, (-jump[2], jump[3], -jump[0], jump[1]))  # in the names after heel strike
    return decided


@compiled
def varied_land(y: Vector, p: VariedLimited) -> None:
    """`land`: the landing foot alone comes to rest."""
    by_handover = ep.compliant_handover_by(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p.plain)
    land(y, p.plain)
    after_p = eq.exchanged(p.plain)
    by_inertia = ep.compliant_impulse_by(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], 0.0, 0.0, after_p)
    t = eq.compliant_terms(y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, after_p)
    factors = eq.mass_factors(t, after_p)
    rows = p.along.shape[0]
    for row in range(rows):
        d = change_of(p, row)
        given = ep.compliant_handover_change(by_handover, d)
        needed = ep.compliant_impulse_change(by_inertia, eq.exchanged(d))
        add(y, y.size - 8 * (rows - row) + 4, solve(
            factors, given[0] - needed[0], given[1] - needed[1], given[2] - needed[2], given[3] - needed[3]))


@compiled
def varied_strike(y: Vector, p: VariedLimited, plain: Limited, renamed: bool) -> bool:
    """`strike`: the trailing foot meets the ground, or is let go of; False where the law does not decide.

    `plain` is that of `p`, with its legs exchanged where they are `renamed` since.
    """
    found, ratio, impulse, factors, normal, roll = trailing_impulse(y, plain)
    before = (y[4], y[5], y[6], y[7])
    decided = strike(y, plain)
    if found in (LIFTS, UNDECIDED):
        return decided
    after = (y[4], y[5], y[6], y[7])
    by = impulse_by(y, before, after, impulse, plain)
    constrained = factor_constrained(factors, normal, roll)
    push, mobility = push_of(factors, normal, roll, ratio)
    backwards = -1.0 if dot(roll, after) > 0.0 else 1.0
    rows = p.along.shape[0]
    for row in range(rows):
        d = change_of(p, row)
        d = eq.exchanged(d) if renamed else d
        change, contact = ep.compliant_impulse_change(by, d), contact_rate_change(y, after, plain, d)
        if found == STICKS:
            free = solve(factors, -change[0], -change[1], -change[2], -change[3])
            jump, _ = solve_constrained(factors, constrained, normal, roll, free, -contact[0], -contact[1])
        else:
            jump, _ = slipping_response(
                change, contact, backwards * d.mu_d * impulse[0], (factors, push, mobility, normal), roll)
        add(y, y.size - 8 * (rows - row) + 4, jump)
    return decided


@compiled
def limited_varied_reset(y: Vector, p: VariedLimited) -> bool:
    """`heel_strike_reset` with limited friction."""
    varied_land(y, p)
    return varied_strike(y, p, eq.exchanged(p.plain), True)


@compiled
def limited_varied_succession(phase: int, y: Vector, p: VariedLimited) -> Next:
    """`succeed` with limited friction: where a hovering foot comes down, it strikes as well."""
    if phase <= SINGLE_STANCE:
        return contact_phase(y, eq.exchanged(p.plain)) if limited_varied_reset(y, p) else (SINGLE_STANCE, False)
    if phase == HOVERING and foot_clearance(y, p.plain, y, 4)[0] <= -y[6]:
        if not varied_strike(y, p, p.plain, False):
            return phase, False
        return contact_phase(y, p.plain)
    return limited_succession(phase, y, p.plain)
