"""Guards of a varied walker: a change of its numbers changes them at a given state too."""

from __future__ import annotations

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.derivatives.equations import terms as ep
from stages.analytic.derivatives.response import (
    change_of,
    clearance_change,
    compliant_by,
    contact_rate_change,
    double_response,
    rubbing_response,
    sliding_response,
    sliding_system,
)
from stages.analytic.model.elimination import dot
from stages.analytic.model.kinds import Compliant, Limited
from stages.analytic.model.varied import Varied, VariedCompliant, VariedLimited, VariedRigidLegs, VariedRubbingRolling
from stages.analytic.model.walker import Vector
from stages.analytic.phases.compliant_hip import on_both, rubbed_acceleration
from stages.analytic.phases.flow import (
    DOUBLE_STANCE,
    HOVERING,
    SINGLE_STANCE,
    SLIDING_FORWARD,
    contact_directions,
    double_acceleration,
)
from stages.analytic.phases.guards import Guard, guard


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
