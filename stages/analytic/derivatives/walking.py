"""What a varied walker does in place of the plain one: the register of its functions, filled where this is imported.

With the guards and the impacts of a varied walker: a change of its numbers changes its guards at a given state. Of
an impact it takes the plain one, which carries the variations across, and adds what the changed numbers do to the
velocities after it at a given state before it.
"""

from __future__ import annotations

import numpy as np

from stages.analytic.compiled import Four, Numbers, compiled, extend
from stages.analytic.derivatives.equations import terms as ep
from stages.analytic.derivatives.rates import (
    add,
    limited_varied_rates,
    rigid_varied_rates,
    rolling_varied_rates,
    rubbing_rolling_varied_rates,
    rubbing_varied_rates,
)
from stages.analytic.derivatives.response import (
    change_of,
    clearance_change,
    compliant_by,
    contact_rate_change,
    double_response,
    rubbing_response,
    sliding_response,
    sliding_system,
    slipping_response,
)
from stages.analytic.integration import dop853_step, radau
from stages.analytic.integration.integrator import error_norm, take_step
from stages.analytic.integration.phase import failure
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import dot, factor_constrained, solve, solve_constrained
from stages.analytic.model.kinds import Compliant, Kind, Limited
from stages.analytic.model.terms import exchanged
from stages.analytic.model.varied import (
    StiffVaried,
    Varied,
    VariedCompliant,
    VariedLimited,
    VariedRigid,
    VariedRigidLegs,
    VariedRolling,
    VariedRubbing,
    VariedRubbingRolling,
    VariedTimed,
)
from stages.analytic.model.walker import Vector
from stages.analytic.phases.compliant_hip import on_both, rubbed_acceleration
from stages.analytic.phases.coulomb_impact import LIFTS, STICKS, UNDECIDED, land, strike, trailing_impulse
from stages.analytic.phases.flow import (
    DOUBLE_STANCE,
    HOVERING,
    SINGLE_STANCE,
    SLIDING_FORWARD,
    contact_directions,
    double_acceleration,
    flow,
    push_of,
)
from stages.analytic.phases.guards import Guard, guard
from stages.analytic.phases.succession import (
    Next,
    contact_phase,
    first_phase,
    limited_succession,
    rigid_succession,
    rolling_succession,
    rubbing_rolling_succession,
    rubbing_succession,
    succeed,
)
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


@compiled
def row_of(p: Varied, dy: Vector, start: int, base: int) -> int:
    """The row of `along` that goes with the variation stored from `start`; negative for one without."""
    row: int = start // base - (dy.size // base - p.along.shape[0])
    return row


@compiled
def rigid_varied_guard(phase: int, y: Vector, p: VariedRigidLegs, dy: Vector, start: int) -> Guard:
    """`guard` of rigid legs."""
    value, change, over = guard(phase, y, p.plain, dy, start)
    row = row_of(p, dy, start, 4)
    if row >= 0:
        change += ep.rigid_clearance_change(ep.rigid_clearance_by(y[0], y[1], p.plain), change_of(p, row))[0]
    return value, change, over


@compiled
def trailing_force_change(y: Vector, p: Compliant, d: Compliant) -> tuple[tuple[float, float], tuple[float, float]]:
    """lambda of double stance, and its change at the state."""
    qdd, force, factors, constrained, normal, roll = double_acceleration(y, p)
    by = compliant_by(y, qdd, force, p)
    return force, double_response(by, (factors, constrained, normal, roll), d)[1]


@compiled
def rolling_varied_guard(phase: int, y: Vector, p: VariedCompliant, dy: Vector, start: int) -> Guard:
    """`guard` of feet that roll."""
    value, change, over = guard(phase, y, p.plain, dy, start)
    row = row_of(p, dy, start, 8)
    if row >= 0 and phase == DOUBLE_STANCE:
        change += trailing_force_change(y, p.plain, change_of(p, row))[1][0]
    elif row >= 0:
        change += clearance_change(y, p.plain, change_of(p, row))
    return value, change, over


@compiled
def rubbing_rolling_varied_guard(phase: int, y: Vector, p: VariedRubbingRolling, dy: Vector, start: int) -> Guard:
    """`guard` of feet that roll, with friction at the hip."""
    value, change, over = guard(phase, y, p.plain, dy, start)
    row = row_of(p, dy, start, 8)
    if row >= 0 and on_both(phase):
        qdd, force, system = rubbed_acceleration(phase, y, p.plain)
        change += rubbing_response(phase, compliant_by(y, qdd, force, p.plain), system, change_of(p, row))[1][0]
    elif row >= 0:
        change += clearance_change(y, p.plain, change_of(p, row))
    return value, change, over


@compiled
def limited_guard_change(phase: int, y: Vector, p: Limited, d: Limited) -> float:
    """Change of the guard of a trailing foot with limited friction, see `coulomb_guard`."""
    if phase == DOUBLE_STANCE:
        force, change = trailing_force_change(y, p, d)
        left: float = p.mu_s * change[0] + d.mu_s * force[0] - np.sign(force[1]) * change[1]
        return left
    height, _, _ = guard(SINGLE_STANCE, y, p, y, 4)
    if phase == HOVERING:
        return clearance_change(y, p, d) if height <= -y[6] else 0.0
    sign = 1.0 if phase == SLIDING_FORWARD else -1.0
    by, normal_force, system = sliding_system(phase, y, p)
    _, roll, _, _ = contact_directions(y, p)
    rates = (y[4], y[5], y[6], y[7])
    if sign * dot(roll, rates) < normal_force:
        return sign * contact_rate_change(y, rates, p, d)[1]
    return sliding_response(phase, by, normal_force, system, roll, d)[1]


@compiled
def limited_varied_guard(phase: int, y: Vector, p: VariedLimited, dy: Vector, start: int) -> Guard:
    """`guard` with limited friction."""
    value, change, over = guard(phase, y, p.plain, dy, start)
    row = row_of(p, dy, start, 8)
    if row >= 0 and phase == SINGLE_STANCE:
        change += clearance_change(y, p.plain, change_of(p, row))
    elif row >= 0:
        change += limited_guard_change(phase, y, p.plain, change_of(p, row))
    return value, change, over


@compiled
def plain_failure(phase: int, y: Vector, p: Varied) -> int:
    """`failure`: that of the plain walker."""
    return failure(phase, y, p.plain)


@compiled
def plain_first_phase(y: Vector, p: Varied) -> Next:
    """`first_phase`: that of the plain walker."""
    return first_phase(y, p.plain)


@compiled
def plain_exchanged(p: Varied) -> Kind:
    """`exchanged`: the plain walker in its next step."""
    after: Kind = exchanged(p.plain)
    return after


extend(exchanged, {Varied: plain_exchanged})
extend(flow, {
    VariedRigid | VariedTimed: rigid_varied_rates, VariedRubbing: rubbing_varied_rates,
    VariedRolling: rolling_varied_rates, VariedRubbingRolling: rubbing_rolling_varied_rates,
    VariedLimited: limited_varied_rates})
extend(guard, {
    VariedRigidLegs: rigid_varied_guard, VariedRolling: rolling_varied_guard,
    VariedRubbingRolling: rubbing_rolling_varied_guard, VariedLimited: limited_varied_guard})
extend(heel_strike_reset, {
    VariedRigidLegs: rigid_varied_reset, VariedRolling | VariedRubbingRolling: rolling_varied_reset,
    VariedLimited: limited_varied_reset})
extend(succeed, {
    VariedRigid | VariedTimed: rigid_succession, VariedRubbing: rubbing_succession, VariedRolling: rolling_succession,
    VariedRubbingRolling: rubbing_rolling_succession, VariedLimited: limited_varied_succession})
extend(first_phase, {Varied: plain_first_phase})
extend(failure, {Varied: plain_failure})
extend(take_step, {StiffVaried: radau.take_step, Varied: dop853_step.take_step})
extend(error_norm, {StiffVaried: radau.error_norm, Varied: dop853_step.error_norm})
