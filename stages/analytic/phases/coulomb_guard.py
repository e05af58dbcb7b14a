"""Events of a trailing foot that slides or hovers: guards with their rates, and how they vary.

Sliding ends where the normal force or the slip falls to zero; hovering where the foot comes down, or starts to swing
forward, after which it is out of play until it is ahead of the other foot (stepping blocks, see `phase.guard`). The
guard is the lesser of the two, so it falls through zero with the first.
"""

from __future__ import annotations

from stages.analytic.compiled import Numbers, compiled
from stages.analytic.model import equations as eq
from stages.analytic.model.elimination import dot
from stages.analytic.model.walker import Vector
from stages.analytic.phases.flow import (
    HOVERING,
    SLIDING_FORWARD,
    contact_directions,
    double_jacobians,
    push_of,
    row4_times,
    single_acceleration,
    sliding_acceleration,
    sliding_variation,
)
from stages.analytic.phases.transitions import clearance_variation, foot_clearance

#: Least share of its frictionless value to which friction may lower the mobility of a sliding contact.
LEAST_MOBILITY = 1e-3


@compiled
def slip_speed(y: Vector, p: Numbers) -> tuple[float, float]:
    """Rate of the clearance of the trailing foot, and its slip velocity: Pi^T qd."""
    normal, roll, _, _ = contact_directions(y, p)
    rates = (y[4], y[5], y[6], y[7])
    return dot(normal, rates), dot(roll, rates)


@compiled
def limited_guard(phase: int, y: Vector, p: Numbers, rates: Vector) -> tuple[float, float]:
    """Guard of a sliding or hovering phase and its rate along `rates` = dy/dt."""
    if phase == HOVERING:
        height, rate, _ = foot_clearance(phase, y, p)
        return (height, rate) if height <= -y[6] else (-y[6], -rates[6])
    sign = 1.0 if phase == SLIDING_FORWARD else -1.0
    qdd, force, factors, push, mobility, normal = sliding_acceleration(phase, y, p)
    _, roll, _, target = contact_directions(y, p)
    slip = sign * dot(roll, (y[4], y[5], y[6], y[7]))
    if slip < force[0]:
        return slip, sign * (dot(roll, qdd) - target)
    jacobians = double_jacobians(y, qdd, force, p)
    return force[0], sliding_variation(jacobians, (factors, push, mobility, normal), rates, 0)[1]


@compiled
def limited_variation(phase: int, y: Vector, p: Numbers, start: int) -> float:
    """Change of the guard of a sliding or hovering phase for the variation stored from `start`."""
    if phase == HOVERING:
        return clearance_variation(phase, y, p, start) if foot_clearance(phase, y, p)[0] <= -y[6] else -y[start + 6]
    sign = 1.0 if phase == SLIDING_FORWARD else -1.0
    qdd, force, factors, push, mobility, normal = sliding_acceleration(phase, y, p)
    _, roll, _, _ = contact_directions(y, p)
    if sign * dot(roll, (y[4], y[5], y[6], y[7])) < force[0]:
        by_contact = eq.contact_acceleration_jacobian(
            y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, y[4], y[5], y[6], y[7], p)
        rates = (y[start + 4], y[start + 5], y[start + 6], y[start + 7])
        return sign * (dot(roll, rates) + row4_times(by_contact[8:12], y, start))
    jacobians = double_jacobians(y, qdd, force, p)
    return sliding_variation(jacobians, (factors, push, mobility, normal), y, start)[1]


@compiled
def wedges(y: Vector, p: Numbers, ratio: float) -> bool:
    """Whether friction `ratio` (tangential over normal) takes away the mobility of the trailing foot's contact."""
    _, factors = single_acceleration(y, p)
    normal, roll, _, _ = contact_directions(y, p)
    _, free = push_of(factors, normal, roll, 0.0)
    _, mobility = push_of(factors, normal, roll, ratio)
    return mobility <= LEAST_MOBILITY * free
