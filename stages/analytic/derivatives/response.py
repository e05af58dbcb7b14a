"""How accelerations and contact forces answer, at a given state, to a change `d` of the walker's numbers.

The equations of `phases.flow` hold for the changed numbers too: what it adds to each of their terms is generated
(`equations`, here `ep`), and the same factors solve for the answer.
"""

from __future__ import annotations

from typing import Any

from stages.analytic.compiled import Constrained, Four, Numbers, compiled
from stages.analytic.derivatives.equations import terms as ep
from stages.analytic.model.elimination import dot, solve, solve_constrained
from stages.analytic.model.kinds import Compliant, Limited, Rigid, RubbingRolling
from stages.analytic.model.varied import Varied
from stages.analytic.model.walker import Vector
from stages.analytic.phases.compliant_hip import System, on_both, plus
from stages.analytic.phases.flow import SLIDING_FORWARD, sliding_acceleration
from stages.analytic.phases.hip_friction import sign_of

#: Derivatives of the residual and of the constraints by the walker's numbers: the same for every change of them.
By = tuple[Numbers, Numbers]


@compiled
def change_of(p: Varied, row: int) -> Any:
    """The change of the walker's numbers in a row of `along`, as a walker."""
    return ep.row_as(p.plain, p.along, row)


@compiled
def rigid_by(y: Vector, qdd: tuple[float, float], p: Rigid) -> Numbers:
    """Derivatives of the residual of rigid single stance."""
    return ep.rigid_residual_by(y[0], y[1], y[2], y[3], qdd[0], qdd[1], p)


@compiled
def compliant_by(y: Vector, qdd: Four, force: tuple[float, float], p: Compliant) -> By:
    """Derivatives of the residual and of the constraints of compliant legs."""
    residual = ep.compliant_residual_by(
        y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], qdd[0], qdd[1], qdd[2], qdd[3], force[0], force[1], p)
    contact = ep.contact_acceleration_by(
        y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], qdd[0], qdd[1], qdd[2], qdd[3], p)
    return residual, contact


@compiled
def rigid_response(by: Numbers, inverse: tuple[float, float, float], d: Rigid) -> tuple[float, float]:
    """Change of qdd of rigid single stance."""
    change = ep.rigid_residual_change(by, d)
    return (-inverse[0] * change[0] - inverse[1] * change[1], -inverse[1] * change[0] - inverse[2] * change[1])


@compiled
def free_response(by: By, factors: Numbers, d: Compliant) -> Four:
    """Change of qdd at unchanged contact forces."""
    change = ep.compliant_residual_change(by[0], d)
    return solve(factors, -change[0], -change[1], -change[2], -change[3])


@compiled
def double_response(
    by: By, system: tuple[Numbers, Constrained, Four, Four], d: Compliant
) -> tuple[Four, tuple[float, float]]:
    """Changes of qdd and lambda in double stance."""
    factors, constrained, normal, roll = system
    contact = ep.contact_acceleration_change(by[1], d)
    return solve_constrained(
        factors, constrained, normal, roll, free_response(by, factors, d), -contact[0], -contact[1])


@compiled
def rubbing_response(phase: int, by: By, system: System, d: RubbingRolling) -> tuple[Four, tuple[float, float]]:
    """Changes of qdd and lambda of compliant legs whose hip rubs or sticks; friction's torque may change as well."""
    factors, constrained, normal, roll, push, by_torque, each = system
    change, force = free_response(by, factors, d), (0.0, 0.0)
    if on_both(phase):
        change, force = double_response(by, (factors, constrained, normal, roll), d)
    torque = -sign_of(phase) * d.tau_h
    if sign_of(phase) == 0:
        torque = -(change[0] + change[2]) / each
    return plus(change, push, torque), (force[0] + by_torque[0] * torque, force[1] + by_torque[1] * torque)


@compiled
def sliding_response(
    phase: int, by: By, force: float, system: tuple[Numbers, Four, float, Four], roll: Four, d: Limited
) -> tuple[Four, float]:
    """Changes of qdd and lambda_1 of a sliding foot with normal force `force`."""
    ratio = -d.mu_d if phase == SLIDING_FORWARD else d.mu_d
    return slipping_response(
        ep.compliant_residual_change(by[0], d), ep.contact_acceleration_change(by[1], d), ratio * force, system, roll)


@compiled
def slipping_response(
    change: Numbers, contact: Numbers, drag: float, system: tuple[Numbers, Four, float, Four], roll: Four
) -> tuple[Four, float]:
    """What a slipping foot makes of changes of the residual and of the constraints, and of its friction by `drag`."""
    factors, push, mobility, normal = system
    free = solve(factors, drag * roll[0] - change[0], drag * roll[1] - change[1], drag * roll[2] - change[2],
                 drag * roll[3] - change[3])
    force = (-contact[0] - dot(normal, free)) / mobility
    return (free[0] + push[0] * force, free[1] + push[1] * force,
            free[2] + push[2] * force, free[3] + push[3] * force), force


@compiled
def contact_rate_change(y: Vector, rates: Four, p: Compliant, d: Compliant) -> Numbers:
    """Change of Pi^T qd of the second foot at given configuration and `rates` qd."""
    by = ep.contact_acceleration_by(
        y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, rates[0], rates[1], rates[2], rates[3], p)
    return ep.contact_acceleration_change(by, d)


@compiled
def clearance_change(y: Vector, p: Compliant, d: Compliant) -> float:
    """Change of the height of the swing foot at given configuration."""
    return ep.compliant_clearance_change(ep.compliant_clearance_by(y[0], y[1], y[2], y[3], p), d)[0]


@compiled
def sliding_system(
    phase: int, y: Vector, p: Limited
) -> tuple[By, float, tuple[Numbers, Four, float, Four]]:
    """What `sliding_response` needs at a state: derivatives, normal force, and what solves the equations again."""
    qdd, force, factors, push, mobility, normal = sliding_acceleration(phase, y, p)
    return compliant_by(y, qdd, force, p), force[0], (factors, push, mobility, normal)
