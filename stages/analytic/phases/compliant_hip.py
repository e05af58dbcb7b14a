"""Coulomb friction at the hip of compliant legs whose feet roll: as with rigid legs, in single and in double stance.

Phases are those of `hip_friction`, `ON_BOTH` more while both feet are on the ground. Where the trailing foot leaves,
the force along the ground that it bore ends at once, and with it the torque that held a hip may change: then it is
decided anew whether the hip sticks.
"""

from __future__ import annotations

from typing import Any

from stages.analytic.compiled import Constrained, Four, Jacobians, compiled, extend
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import factor_constrained, solve, solve_constrained
from stages.analytic.model.kinds import Compliant, RubbingRolling
from stages.analytic.model.varied import VariedRubbingRolling, plain
from stages.analytic.model.walker import Vector
from stages.analytic.phases.flow import (
    HIP_STICKS,
    ON_BOTH,
    RUBS_BACK,
    RUBS_FORWARD,
    contact_directions,
    double_jacobians,
    flow,
    free_variation,
    row8_times,
    store,
)
from stages.analytic.phases.guards import PASSING, Guard, guard, swing_guard
from stages.analytic.phases.hip_friction import AT_REST, LANDED, hip_guard, hip_rate, of_hip, sign_of
from stages.analytic.phases.transitions import foot_clearance

#: A trailing foot that presses less than this, in the walker's weight, is leaving.
LEAVING = 1e-9
#: What solves the equations of motion again: factors, constraints, and what a unit torque does to accelerations, to the
#: trailing foot's forces, and to the acceleration of the angle between the legs.
System = tuple[Any, Constrained, Four, Four, Four, tuple[float, float], float]


@compiled
def on_both(phase: int) -> bool:
    """Whether both feet are on the ground."""
    return phase > HIP_STICKS


@compiled
def plus(a: Four, b: Four, share: float) -> Four:
    """a + share b."""
    return a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2], a[3] + share * b[3]


@compiled
def without_friction(both: bool, y: Vector, p: RubbingRolling) -> tuple[Four, tuple[float, float], System]:
    """qdd and lambda without the hip's friction, and what solves the same system again."""
    t = eq.compliant_terms(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p)
    factors = eq.mass_factors(t, p)
    qdd, push = solve(factors, t[10], t[11], t[12], t[13]), solve(factors, 1.0, 0.0, 1.0, 0.0)
    force, by_torque = (0.0, 0.0), (0.0, 0.0)
    normal, roll, target1, target2 = contact_directions(y, p)
    constrained = factor_constrained(factors, normal, roll)
    if both:
        qdd, force = solve_constrained(factors, constrained, normal, roll, qdd, target1, target2)
        push, by_torque = solve_constrained(factors, constrained, normal, roll, push, 0.0, 0.0)
    return qdd, force, (factors, constrained, normal, roll, push, by_torque, push[0] + push[2])


@compiled
def holding(both: bool, y: Vector, p: RubbingRolling) -> float:
    """Torque that would keep the rate of theta + psi."""
    qdd, _, system = without_friction(both, y, p)
    return -(qdd[0] + qdd[2]) / system[6]


@compiled
def rubbed_acceleration(phase: int, y: Vector, p: RubbingRolling) -> tuple[Four, tuple[float, float], System]:
    """qdd and lambda of a hip that rubs or sticks, and what solves the same system again."""
    qdd, force, system = without_friction(on_both(phase), y, p)
    torque = -sign_of(phase) * p.tau_h
    if sign_of(phase) == 0:
        torque = -(qdd[0] + qdd[2]) / system[6]
    by_torque = system[5]
    return (plus(qdd, system[4], torque), (force[0] + by_torque[0] * torque, force[1] + by_torque[1] * torque), system)


@compiled
def rubbed_variation(
    phase: int, jacobians: Jacobians, system: System, dy: Vector, start: int
) -> tuple[Four, tuple[float, float]]:
    """Variations of qdd and lambda for the variation of the state stored from `start`."""
    factors, constrained, normal, roll, push, by_torque, each = system
    change, force = free_variation(jacobians, factors, dy, start), (0.0, 0.0)
    if on_both(phase):
        change, force = solve_constrained(
            factors, constrained, normal, roll, change,
            -row8_times(jacobians[2][0:8], dy, start), -row8_times(jacobians[2][8:16], dy, start))
    if sign_of(phase) == 0:
        held = -(change[0] + change[2]) / each
        change = plus(change, push, held)
        force = (force[0] + by_torque[0] * held, force[1] + by_torque[1] * held)
    return change, force


@compiled
def rubbing_rolling_rates(phase: int, y: Vector, p: RubbingRolling, rates: Vector) -> None:
    """`flow` of compliant legs with friction at the hip."""
    qdd, force, system = rubbed_acceleration(phase, y, p)
    store(rates, y, 0, qdd)
    if y.size > 8:
        jacobians = double_jacobians(y, qdd, force, p)
        for start in range(8, y.size, 8):
            change, _ = rubbed_variation(phase, jacobians, system, y, start)
            store(rates, y, start, change)


@compiled
def rubbing_guard(phase: int, y: Vector, p: RubbingRolling, dy: Vector, start: int) -> Guard:
    """`guard`: the trailing foot's normal force, or the swing foot's clearance."""
    if not on_both(phase):
        return swing_guard(phase, y, p, dy, start)
    qdd, force, system = rubbed_acceleration(phase, y, p)
    _, change = rubbed_variation(phase, double_jacobians(y, qdd, force, p), system, dy, start)
    return force[0], change[0], True


@compiled
def compliant_hip_rate(v: Vector, start: int, p: Compliant) -> float:
    """`hip_rate` of compliant legs."""
    return float(v[start + 4] + v[start + 6])


@compiled
def rolling_hip_guard(phase: int, y: Vector, p: RubbingRolling) -> float:
    """`hip_guard` of compliant legs."""
    if sign_of(phase) == 0:
        return float(p.tau_h - abs(holding(on_both(phase), y, p)))
    return float(sign_of(phase) * (y[4] + y[6]))


extend(flow, {RubbingRolling: rubbing_rolling_rates})
extend(guard, {RubbingRolling: rubbing_guard})
extend(hip_rate, {RubbingRolling: compliant_hip_rate})
extend(hip_guard, {RubbingRolling: rolling_hip_guard})


@compiled
def from_standstill(both: bool, y: Vector, p: RubbingRolling, may_stick: bool) -> int:
    """The phase of a hip whose legs do not move against each other: it sticks if it may, or slips."""
    held, more = holding(both, y, p), ON_BOTH if both else 0
    if may_stick and abs(held) < p.tau_h:
        return HIP_STICKS + more
    return (RUBS_BACK if held > 0.0 else RUBS_FORWARD) + more


@compiled
def compliant_hip_phase(both: bool, y: Vector, p: RubbingRolling) -> int:
    """The phase of a hip with both feet on the ground, or one."""
    rate = y[4] + y[6]
    if abs(rate) > AT_REST:
        return (RUBS_FORWARD if rate > 0.0 else RUBS_BACK) + (ON_BOTH if both else 0)
    return from_standstill(both, y, p, True)


@compiled
def compliant_first_phase(y: Vector, p: RubbingRolling) -> tuple[int, bool]:
    """`first_phase` of compliant legs with friction at the hip."""
    return compliant_hip_phase(True, y, p), True


@compiled
def compliant_has_landed(phase: int, y: Vector, p: RubbingRolling | VariedRubbingRolling) -> bool:
    """`ends_step`: the swing foot is on the ground, ahead."""
    height, _, advance = foot_clearance(y, plain(p), y, 4)
    return not on_both(phase) and advance > PASSING and abs(height) < LANDED


@compiled
def leaves(phase: int, y: Vector, p: RubbingRolling) -> bool:
    """Whether the event that ended `phase` is the trailing foot's, which leaves the ground."""
    return on_both(phase) and rubbed_acceleration(phase, y, p)[1][0] <= LEAVING


@compiled
def rolling_hip_decides(phase: int, y: Vector, p: RubbingRolling) -> bool:
    """`of_hip` of compliant legs."""
    return not (compliant_has_landed(phase, y, p) or leaves(phase, y, p))


extend(of_hip, {RubbingRolling: rolling_hip_decides})


@compiled
def within_a_step(phase: int, y: Vector, p: RubbingRolling | VariedRubbingRolling) -> int:
    """The phase after an event that ends no step: the trailing foot leaves, or the hip stops, or lets go."""
    both, sticks, numbers = on_both(phase), sign_of(phase) == 0, plain(p)
    if leaves(phase, y, numbers):
        return from_standstill(False, y, numbers, True) if sticks else phase - ON_BOTH
    return from_standstill(both, y, numbers, not sticks)
