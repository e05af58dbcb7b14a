"""Rates of the variations of a varied walker: those of the plain one, and what the changes of its numbers add."""

from __future__ import annotations

from stages.analytic.compiled import Four, compiled, inlined
from stages.analytic.derivatives.equations import terms as ep
from stages.analytic.derivatives.response import (
    change_of,
    compliant_by,
    rigid_by,
    rigid_response,
    rubbing_response,
    sliding_response,
    sliding_system,
)
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import solve, solve_constrained
from stages.analytic.model.varied import (
    VariedCompliant,
    VariedLimited,
    VariedRigid,
    VariedRubbing,
    VariedRubbingRolling,
)
from stages.analytic.model.walker import Vector
from stages.analytic.phases.compliant_hip import rubbed_acceleration, rubbing_rolling_rates
from stages.analytic.phases.flow import (
    DOUBLE_STANCE,
    HIP_STICKS,
    SLIDING_BACK,
    SLIDING_FORWARD,
    contact_directions,
    double_acceleration,
    double_jacobians,
    force_variation,
    rigid_acceleration,
    rigid_rates,
    row8_times,
    single_acceleration,
    sliding_rates,
    store,
)
from stages.analytic.phases.hip_friction import rubbing_rates, sign_of


@inlined
def add(vector: Vector, start: int, change: Four) -> None:
    """Add four numbers to those stored from `start`."""
    for i in range(4):
        vector[start + i] += change[i]


@compiled
def rigid_varied_rates(phase: int, y: Vector, p: VariedRigid, rates: Vector) -> None:
    """`flow` of rigid legs."""
    rigid_rates(phase, y, p.plain, rates)
    qdd, inverse = rigid_acceleration(y, p.plain)
    by, rows = rigid_by(y, qdd, p.plain), p.along.shape[0]
    for row in range(rows):
        change = rigid_response(by, inverse, change_of(p, row))
        start = y.size - 4 * (rows - row)
        rates[start + 2] += change[0]
        rates[start + 3] += change[1]


@compiled
def rubbing_varied_rates(phase: int, y: Vector, p: VariedRubbing, rates: Vector) -> None:
    """`flow` of rigid legs with friction at the hip, whose torque may change as well."""
    rubbing_rates(phase, y, p.plain, rates)
    _, inverse = rigid_acceleration(y, p.plain)
    each1, each2 = inverse[0] + inverse[1], inverse[1] + inverse[2]
    by, rows = rigid_by(y, (rates[2], rates[3]), p.plain), p.along.shape[0]
    for row in range(rows):
        d = change_of(p, row)
        change = rigid_response(by, inverse, d)
        torque = -sign_of(phase) * d.tau_h
        if phase == HIP_STICKS:
            torque = -(change[0] + change[1]) / (each1 + each2)
        start = y.size - 4 * (rows - row)
        rates[start + 2] += change[0] + each1 * torque
        rates[start + 3] += change[1] + each2 * torque


@inlined
def single_varied_rates(y: Vector, p: VariedCompliant, rates: Vector) -> None:
    """Rates in compliant single stance."""
    qdd, factors = single_acceleration(y, p.plain)
    store(rates, y, 0, qdd)
    jacobian = eq.compliant_residual_jacobian(
        y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], qdd[0], qdd[1], qdd[2], qdd[3], p.plain)
    by = ep.compliant_residual_by(
        y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], qdd[0], qdd[1], qdd[2], qdd[3], 0.0, 0.0, p.plain)
    first = y.size - 8 * p.along.shape[0]
    for start in range(8, y.size, 8):
        f1, f2 = row8_times(jacobian[0:8], y, start), row8_times(jacobian[8:16], y, start)
        f3, f4 = row8_times(jacobian[16:24], y, start), row8_times(jacobian[24:32], y, start)
        if start >= first:
            change = ep.compliant_residual_change(by, change_of(p, (start - first) // 8))
            f1, f2, f3, f4 = f1 + change[0], f2 + change[1], f3 + change[2], f4 + change[3]
        store(rates, y, start, solve(factors, -f1, -f2, -f3, -f4))


@inlined
def double_varied_rates(y: Vector, p: VariedCompliant, rates: Vector) -> None:
    """Rates in compliant double stance."""
    qdd, force, factors, constrained, normal, roll = double_acceleration(y, p.plain)
    store(rates, y, 0, qdd)
    jacobians, by = double_jacobians(y, qdd, force, p.plain), compliant_by(y, qdd, force, p.plain)
    first = y.size - 8 * p.along.shape[0]
    for start in range(8, y.size, 8):
        f1, f2, f3, f4 = force_variation(jacobians, y, start)
        target1, target2 = row8_times(jacobians[2][0:8], y, start), row8_times(jacobians[2][8:16], y, start)
        if start >= first:
            d = change_of(p, (start - first) // 8)
            change, contact = ep.compliant_residual_change(by[0], d), ep.contact_acceleration_change(by[1], d)
            f1, f2, f3, f4 = f1 - change[0], f2 - change[1], f3 - change[2], f4 - change[3]
            target1, target2 = target1 + contact[0], target2 + contact[1]
        varied, _ = solve_constrained(
            factors, constrained, normal, roll, solve(factors, f1, f2, f3, f4), -target1, -target2)
        store(rates, y, start, varied)


@compiled
def rolling_varied_rates(phase: int, y: Vector, p: VariedCompliant, rates: Vector) -> None:
    """`flow` of compliant legs with feet that roll or are in the air."""
    if phase == DOUBLE_STANCE:
        double_varied_rates(y, p, rates)
    else:
        single_varied_rates(y, p, rates)


@compiled
def limited_varied_rates(phase: int, y: Vector, p: VariedLimited, rates: Vector) -> None:
    """`flow` of compliant legs with limited friction."""
    if phase not in (SLIDING_FORWARD, SLIDING_BACK):
        rolling_varied_rates(phase, y, p, rates)
        return
    sliding_rates(phase, y, p.plain, rates)
    by, force, system = sliding_system(phase, y, p.plain)
    _, roll, _, _ = contact_directions(y, p.plain)
    rows = p.along.shape[0]
    for row in range(rows):
        change, _ = sliding_response(phase, by, force, system, roll, change_of(p, row))
        add(rates, y.size - 8 * (rows - row) + 4, change)


@compiled
def rubbing_rolling_varied_rates(phase: int, y: Vector, p: VariedRubbingRolling, rates: Vector) -> None:
    """`flow` of compliant legs with friction at the hip."""
    rubbing_rolling_rates(phase, y, p.plain, rates)
    qdd, force, system = rubbed_acceleration(phase, y, p.plain)
    by, rows = compliant_by(y, qdd, force, p.plain), p.along.shape[0]
    for row in range(rows):
        change, _ = rubbing_response(phase, by, system, change_of(p, row))
        add(rates, y.size - 8 * (rows - row) + 4, change)
