"""Which phase follows which, and what happens to the state in between.

Rolling, eq. (6): double stance from heel strike to toe-off, single stance to the next heel strike. With limited
friction the trailing foot rolls, slides or hovers in between, as its forces have it: |lambda_2| <= mu_s lambda_1 while
it rolls, lambda_2 = -mu_d sign(slip) lambda_1 while it slides, no pull. Where more than one of these fits, or none
(Painleve's paradox), no phase follows.
"""

from __future__ import annotations

from collections.abc import Callable

from stages.analytic.compiled import ByKind, compiled, inlined
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import dot
from stages.analytic.model.kinds import Kind, Limited, Rigid, Rolling, RubbingRigid, RubbingRolling
from stages.analytic.model.varied import VariedRubbing, VariedRubbingRolling
from stages.analytic.model.walker import Vector
from stages.analytic.phases.compliant_hip import compliant_first_phase, compliant_has_landed, within_a_step
from stages.analytic.phases.coulomb_guard import slip_speed, wedges
from stages.analytic.phases.coulomb_impact import strike
from stages.analytic.phases.flow import (
    DOUBLE_STANCE,
    HIP_STICKS,
    HOVERING,
    RIGID,
    SINGLE_STANCE,
    SLIDING_BACK,
    SLIDING_FORWARD,
    contact_directions,
    double_acceleration,
    single_acceleration,
    sliding_acceleration,
)
from stages.analytic.phases.hip_friction import after_hip_event, has_landed, hip_phase
from stages.analytic.phases.section import AT_REST
from stages.analytic.phases.transitions import foot_clearance, heel_strike_reset

#: The phase that follows, and whether the laws of contact decide it.
Next = tuple[int, bool]


@compiled
def in_contact(phase: int) -> bool:
    """Whether both feet are on the ground."""
    return phase in (DOUBLE_STANCE, SLIDING_FORWARD, SLIDING_BACK) or phase > HIP_STICKS


@compiled
def airborne(y: Vector) -> int:
    """The phase of a trailing foot in the air: in play until it swings forward."""
    return SINGLE_STANCE if y[6] > 0.0 else HOVERING


@compiled
def sliding(sign: float, y: Vector, p: Limited) -> Next:
    """The phase of a trailing foot that slips with `sign`, and whether its contact is no wedge."""
    phase, ratio = (SLIDING_FORWARD, -p.mu_d) if sign > 0.0 else (SLIDING_BACK, p.mu_d)
    if wedges(y, p, ratio):
        return phase, False
    _, force, _, _, _, _ = sliding_acceleration(phase, y, p)
    return (phase, True) if force[0] > 0.0 else (airborne(y), True)


@compiled
def from_rest(y: Vector, p: Limited) -> Next:
    """What a trailing foot at rest on the ground does next: roll, start to slip, or rise; and whether that is sure."""
    _, force, _, _, _, _ = double_acceleration(y, p)
    free, _ = single_acceleration(y, p)
    normal, roll, target1, target2 = contact_directions(y, p)
    rises = dot(normal, free) > target1
    if force[0] > 0.0 and abs(force[1]) <= p.mu_s * force[0]:
        return DOUBLE_STANCE, not rises
    if rises:
        return airborne(y), not (wedges(y, p, p.mu_d) or wedges(y, p, -p.mu_d))
    for sign in (1.0, -1.0):
        phase, sure = sliding(sign, y, p)
        if sure and in_contact(phase):
            qdd, _, _, _, _, _ = sliding_acceleration(phase, y, p)
            if sign * (dot(roll, qdd) - target2) > 0.0:
                return phase, True
    return airborne(y), False


@compiled
def contact_phase(y: Vector, p: Limited) -> Next:
    """The phase after an impact with limited friction, and whether the laws of contact decide it."""
    height_rate, slip = slip_speed(y, p)
    if height_rate > AT_REST:
        return airborne(y), True
    if abs(slip) > AT_REST:
        return sliding(slip, y, p)
    return from_rest(y, p)


@compiled
def rigid_phase(y: Vector, p: Rigid) -> Next:
    """`first_phase` of rigid legs."""
    return RIGID, True


@compiled
def rolling_phase(y: Vector, p: Rolling) -> Next:
    """`first_phase` of rolling feet."""
    return DOUBLE_STANCE, True


#: The phase just after heel strike, and whether it is decided: first_phase(y, p).
first_phase: Callable[..., Next] = ByKind({
    RubbingRigid: hip_phase, RubbingRolling: compliant_first_phase, Rigid: rigid_phase, Rolling: rolling_phase,
    Limited: contact_phase})


@inlined
def next_step(y: Vector, p: Kind) -> Next:
    """Cross heel strike, with the state and its variations in place: the first phase of the step that follows."""
    if not heel_strike_reset(y, p):
        return SINGLE_STANCE, False
    return first_phase(y, eq.exchanged(p))


@compiled
def rigid_succession(phase: int, y: Vector, p: Rigid) -> Next:
    """`succeed` of rigid legs."""
    return next_step(y, p)


@compiled
def rubbing_succession(phase: int, y: Vector, p: RubbingRigid) -> Next:
    """`succeed` of rigid legs with friction at the hip."""
    if has_landed(phase, y, p):
        return next_step(y, p)
    return after_hip_event(phase, y, p), True


@compiled
def rubbing_rolling_succession(phase: int, y: Vector, p: RubbingRolling) -> Next:
    """`succeed` of compliant legs with friction at the hip."""
    if compliant_has_landed(phase, y, p):
        return next_step(y, p)
    return within_a_step(phase, y, p), True


@compiled
def by_phase(phase: int, y: Vector, p: Kind) -> bool:
    """`ends_step` where the phase says it."""
    return phase <= SINGLE_STANCE


#: Whether the event that ended `phase`, at state `y`, is the heel strike that ends a step: ends_step(phase, y, p).
ends_step: Callable[..., bool] = ByKind({
    RubbingRigid | VariedRubbing: has_landed,
    RubbingRolling | VariedRubbingRolling: compliant_has_landed, tuple: by_phase})


@compiled
def rolling_succession(phase: int, y: Vector, p: Rolling) -> Next:
    """`succeed` of rolling feet."""
    return (SINGLE_STANCE, True) if phase == DOUBLE_STANCE else next_step(y, p)


@compiled
def limited_succession(phase: int, y: Vector, p: Limited) -> Next:
    """`succeed` with limited friction."""
    if phase == SINGLE_STANCE:
        return next_step(y, p)
    if phase == HOVERING:
        if foot_clearance(y, p, y, 4)[0] > -y[6]:
            return SINGLE_STANCE, True
        if not strike(y, p):
            return phase, False
        return contact_phase(y, p)
    if phase == DOUBLE_STANCE:
        _, force, _, _, _, _ = double_acceleration(y, p)
        return sliding(-force[1], y, p)
    _, force, _, _, _, _ = sliding_acceleration(phase, y, p)
    _, slip = slip_speed(y, p)
    if force[0] <= abs(slip):
        return airborne(y), True
    _, force, _, _, _, _ = double_acceleration(y, p)
    if force[0] > 0.0 and abs(force[1]) <= p.mu_s * force[0]:
        return DOUBLE_STANCE, True
    return sliding(-force[1], y, p)


#: Cross the event that ended `phase`, with the state and its variations in place; the phase that follows, and whether
#: the laws of contact decide it: succeed(phase, y, p).
succeed: Callable[..., Next] = ByKind({
    RubbingRigid: rubbing_succession, RubbingRolling: rubbing_rolling_succession, Rigid: rigid_succession,
    Rolling: rolling_succession, Limited: limited_succession})
