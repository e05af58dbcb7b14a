"""Guards of a trailing foot whose friction is limited, each with its change for a variation of the state.

Sliding ends where the normal force or the slip falls to zero; hovering where the foot comes down, or starts to swing
forward, after which it is out of play until it is ahead of the other foot (stepping blocks, see `guards`). The
guard is the lesser of the two, so it falls through zero with the first.
"""

from __future__ import annotations

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import dot
from stages.analytic.model.kinds import Limited
from stages.analytic.model.walker import Vector
from stages.analytic.phases.flow import (
    SLIDING_FORWARD,
    contact_directions,
    double_jacobians,
    push_of,
    row4_times,
    single_acceleration,
    sliding_acceleration,
    sliding_variation,
)
from stages.analytic.phases.transitions import foot_clearance, trailing_force

#: Least share of its frictionless value to which friction may lower the mobility of a sliding contact.
LEAST_MOBILITY = 1e-3


@compiled
def slip_speed(y: Vector, p: Limited) -> tuple[float, float]:
    """Rate of the clearance of the trailing foot, and its slip velocity: Pi^T qd."""
    normal, roll, _, _ = contact_directions(y, p)
    rates = (y[4], y[5], y[6], y[7])
    return dot(normal, rates), dot(roll, rates)


@compiled
def sticking_guard(y: Vector, p: Limited, dy: Vector, start: int) -> tuple[float, float]:
    """Friction that a rolling trailing foot has left, and its change for the variation stored in `dy` from `start`."""
    force, change = trailing_force(y, p, dy, start)
    return p.mu_s * force[0] - abs(force[1]), p.mu_s * change[0] - np.sign(force[1]) * change[1]


@compiled
def hovering_guard(y: Vector, p: Limited, dy: Vector, start: int) -> tuple[float, float]:
    """The same for a foot that hovers: its height, or how fast it swings back if that is less."""
    height, change, _ = foot_clearance(y, p, dy, start)
    return (height, change) if height <= -y[6] else (-y[6], -dy[start + 6])


@compiled
def sliding_guard(phase: int, y: Vector, p: Limited, dy: Vector, start: int) -> tuple[float, float]:
    """The same for a foot that slides: its normal force, or how fast it slips if that is less."""
    sign = 1.0 if phase == SLIDING_FORWARD else -1.0
    qdd, force, factors, push, mobility, normal = sliding_acceleration(phase, y, p)
    _, roll, _, target = contact_directions(y, p)
    slip = sign * dot(roll, (y[4], y[5], y[6], y[7]))
    if slip < force[0] and start == 0:  # along the flow no derivative is needed
        return slip, sign * (dot(roll, qdd) - target)
    if slip < force[0]:
        by_contact = eq.contact_acceleration_jacobian(
            y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, y[4], y[5], y[6], y[7], p)
        rates = (dy[start + 4], dy[start + 5], dy[start + 6], dy[start + 7])
        return slip, sign * (dot(roll, rates) + row4_times(by_contact[8:12], dy, start))
    jacobians = double_jacobians(y, qdd, force, p)
    return force[0], sliding_variation(jacobians, (factors, push, mobility, normal), dy, start)[1]


@compiled
def wedges(y: Vector, p: Limited, ratio: float) -> bool:
    """Whether friction `ratio` (tangential over normal) takes away the mobility of the trailing foot's contact."""
    _, factors = single_acceleration(y, p)
    normal, roll, _, _ = contact_directions(y, p)
    _, free = push_of(factors, normal, roll, 0.0)
    _, mobility = push_of(factors, normal, roll, ratio)
    return mobility <= LEAST_MOBILITY * free
