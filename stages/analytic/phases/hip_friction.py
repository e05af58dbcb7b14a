"""Coulomb friction at the hip of rigid legs: it slips with either sign, or sticks while less than its torque holds it.

Friction opposes the rate of the angle between the legs, theta + psi. Where that rate comes to zero, the torque that
would hold it decides: below friction's the hip sticks, above it slips the other way. A hip that sticks slips when the
torque that holds it reaches friction's. An impact has no part in this: a finite torque gives no impulse.
"""

from __future__ import annotations

from collections.abc import Callable

from stages.analytic.compiled import ByKind, compiled, extend
from stages.analytic.model import terms as eq
from stages.analytic.model.kinds import Rigid, RubbingRigid, Smooth
from stages.analytic.model.varied import VariedRubbing, plain
from stages.analytic.model.walker import Vector
from stages.analytic.phases.flow import (
    HIP_STICKS,
    ON_BOTH,
    RUBS_BACK,
    RUBS_FORWARD,
    flow,
    rigid_acceleration,
    row4_times,
)
from stages.analytic.phases.guards import PASSING
from stages.analytic.phases.transitions import foot_clearance

#: Slower than this, in 1 / pendulum time, the legs do not move against each other; lower than this a foot has landed.
AT_REST, LANDED = 1e-13, 1e-11


@compiled
def sign_of(phase: int) -> int:
    """Sign of the rate of theta + psi while the hip slips; zero while it sticks."""
    if phase in (HIP_STICKS, HIP_STICKS + ON_BOTH):
        return 0
    return 1 if phase in (RUBS_FORWARD, RUBS_FORWARD + ON_BOTH) else -1


@compiled
def rigid_hip_rate(v: Vector, start: int, p: Rigid) -> float:
    """`hip_rate` of rigid legs."""
    return float(v[start + 2] + v[start + 3])


#: Rate of theta + psi in the state stored from `start`, or its acceleration in such rates: hip_rate(v, start, p).
hip_rate: Callable[..., float] = ByKind({Rigid: rigid_hip_rate})


@compiled
def holding_torque(y: Vector, p: Rigid, torque: float) -> tuple[float, float]:
    """Torque beside another `torque` that would keep the rate of theta + psi, and that angle's acceleration by torque.
    """
    qdd, inverse = rigid_acceleration(y, p)
    each = inverse[0] + 2.0 * inverse[1] + inverse[2]
    return -(qdd[0] + qdd[1]) / each - torque, each


@compiled
def rubbing_rates(phase: int, y: Vector, p: RubbingRigid, rates: Vector) -> None:
    """`flow` of rigid legs with friction at the hip."""
    qdd, inverse = rigid_acceleration(y, p)
    each1, each2 = inverse[0] + inverse[1], inverse[1] + inverse[2]
    torque = -sign_of(phase) * p.tau_h
    if phase == HIP_STICKS:
        torque = -(qdd[0] + qdd[1]) / (each1 + each2)
    a1, a2 = qdd[0] + each1 * torque, qdd[1] + each2 * torque
    rates[0], rates[1], rates[2], rates[3] = y[2], y[3], a1, a2
    if y.size > 4:
        jacobian = eq.rigid_residual_jacobian(y[0], y[1], y[2], y[3], a1, a2, p)
        for start in range(4, y.size, 4):
            f1, f2 = -row4_times(jacobian[0:4], y, start), -row4_times(jacobian[4:8], y, start)
            d1, d2 = inverse[0] * f1 + inverse[1] * f2, inverse[1] * f1 + inverse[2] * f2
            if phase == HIP_STICKS:
                held = -(d1 + d2) / (each1 + each2)
                d1, d2 = d1 + each1 * held, d2 + each2 * held
            rates[start], rates[start + 1], rates[start + 2], rates[start + 3] = y[start + 2], y[start + 3], d1, d2


extend(flow, {RubbingRigid: rubbing_rates})


@compiled
def rigid_hip_guard(phase: int, y: Vector, p: RubbingRigid) -> float:
    """`hip_guard` of rigid legs."""
    if phase == HIP_STICKS:
        return float(p.tau_h - abs(holding_torque(y, p, 0.0)[0]))
    return float(sign_of(phase) * (y[2] + y[3]))


#: Positive while the hip goes on as it does: its rate in the direction of slip, or what friction has left:
#: hip_guard(phase, y, p).
hip_guard: Callable[..., float] = ByKind({RubbingRigid: rigid_hip_guard})


@compiled
def slipping(y: Vector, p: RubbingRigid) -> int:
    """The phase in which a hip begins to slip: against the torque that would hold it."""
    return RUBS_BACK if holding_torque(y, p, 0.0)[0] > 0.0 else RUBS_FORWARD


@compiled
def hip_phase(y: Vector, p: RubbingRigid) -> tuple[int, bool]:
    """`first_phase` with friction at the hip."""
    rate = y[2] + y[3]
    if abs(rate) > AT_REST:
        return (RUBS_FORWARD if rate > 0.0 else RUBS_BACK), True
    if abs(holding_torque(y, p, 0.0)[0]) < p.tau_h:
        return HIP_STICKS, True
    return slipping(y, p), True


@compiled
def has_landed(phase: int, y: Vector, p: RubbingRigid | VariedRubbing) -> bool:
    """`ends_step` with friction at the hip: the swing foot is on the ground, ahead."""
    height, _, advance = foot_clearance(y, plain(p), y, 2)
    return advance > PASSING and abs(height) < LANDED


@compiled
def hip_decides(phase: int, y: Vector, p: RubbingRigid) -> bool:
    """`of_hip` of rigid legs."""
    return not has_landed(phase, y, p)


@compiled
def no_hip_event(phase: int, y: Vector, p: Smooth) -> bool:
    """`of_hip` of a hip without friction."""
    return False


#: Whether the event that ended `phase`, at state `y`, is the hip's: it stops, or lets go: of_hip(phase, y, p).
of_hip: Callable[..., bool] = ByKind({Smooth: no_hip_event, RubbingRigid: hip_decides})


@compiled
def after_hip_event(phase: int, y: Vector, p: RubbingRigid | VariedRubbing) -> int:
    """The phase after a hip that slipped has stopped, or one that stuck has let go."""
    numbers = plain(p)
    if phase == HIP_STICKS or abs(holding_torque(y, numbers, 0.0)[0]) >= numbers.tau_h:
        return slipping(y, numbers)
    return HIP_STICKS
