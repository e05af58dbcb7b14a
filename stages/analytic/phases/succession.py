"""Which phase follows which, and what happens to the state in between.

Rolling, eq. (6): double stance from heel strike to toe-off, single stance to the next heel strike. With limited
friction the trailing foot rolls, slides or hovers in between, as its forces have it: |lambda_2| <= mu_s lambda_1 while
it rolls, lambda_2 = -mu_d sign(slip) lambda_1 while it slides, no pull. Where more than one of these fits, or none
(Painleve's paradox), no phase follows.
"""

from __future__ import annotations

import numpy as np

from stages.analytic.compiled import Numbers, compiled
from stages.analytic.model.elimination import dot
from stages.analytic.model.walker import Vector
from stages.analytic.phases.coulomb_guard import slip_speed, wedges
from stages.analytic.phases.coulomb_impact import strike
from stages.analytic.phases.coulomb_section import AT_REST
from stages.analytic.phases.flow import (
    DOUBLE_STANCE,
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
from stages.analytic.phases.transitions import foot_clearance, heel_strike_reset


@compiled
def in_contact(phase: int) -> bool:
    """Whether both feet are on the ground."""
    return phase in (DOUBLE_STANCE, SLIDING_FORWARD, SLIDING_BACK)


@compiled
def airborne(y: Vector) -> int:
    """The phase of a trailing foot in the air: in play until it swings forward."""
    return SINGLE_STANCE if y[6] > 0.0 else HOVERING


@compiled
def sliding(sign: float, y: Vector, p: Numbers) -> tuple[int, bool]:
    """The phase of a trailing foot that slips with `sign`, and whether its contact is no wedge."""
    phase, ratio = (SLIDING_FORWARD, -p[11]) if sign > 0.0 else (SLIDING_BACK, p[11])
    if wedges(y, p, ratio):
        return phase, False
    _, force, _, _, _, _ = sliding_acceleration(phase, y, p)
    return (phase, True) if force[0] > 0.0 else (airborne(y), True)


@compiled
def from_rest(y: Vector, p: Numbers) -> tuple[int, bool]:
    """What a trailing foot at rest on the ground does next: roll, start to slip, or rise; and whether that is sure."""
    _, force, _, _, _, _ = double_acceleration(y, p)
    free, _ = single_acceleration(y, p)
    normal, roll, target1, target2 = contact_directions(y, p)
    rises = dot(normal, free) > target1
    if force[0] > 0.0 and abs(force[1]) <= p[10] * force[0]:
        return DOUBLE_STANCE, not rises
    if rises:
        return airborne(y), not (wedges(y, p, p[11]) or wedges(y, p, -p[11]))
    for sign in (1.0, -1.0):
        phase, sure = sliding(sign, y, p)
        if sure and in_contact(phase):
            qdd, _, _, _, _, _ = sliding_acceleration(phase, y, p)
            if sign * (dot(roll, qdd) - target2) > 0.0:
                return phase, True
    return airborne(y), False


@compiled
def contact_phase(y: Vector, p: Numbers) -> tuple[int, bool]:
    """The phase after an impact with limited friction, and whether the laws of contact decide it."""
    height_rate, slip = slip_speed(y, p)
    if height_rate > AT_REST:
        return airborne(y), True
    if abs(slip) > AT_REST:
        return sliding(slip, y, p)
    return from_rest(y, p)


@compiled
def first_phase(rigid: bool, y: Vector, p: Numbers) -> tuple[int, bool]:
    """The phase just after heel strike, and whether it is decided."""
    if rigid:
        return RIGID, True
    if p[10] == np.inf:
        return DOUBLE_STANCE, True
    return contact_phase(y, p)


@compiled
def succeed(phase: int, y: Vector, p: Numbers) -> tuple[int, bool]:
    """Cross the event that ended `phase`, with the state and its variations in place.

    Returns the phase that follows, and whether the laws of contact decide it.
    """
    if phase in (RIGID, SINGLE_STANCE):
        decided = heel_strike_reset(phase, y, p)
        if not decided:
            return phase, False
        return first_phase(phase == RIGID, y, p)
    if p[10] == np.inf:
        return SINGLE_STANCE, True
    if phase == HOVERING:
        if foot_clearance(phase, y, p)[0] > -y[6]:
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
    if force[0] > 0.0 and abs(force[1]) <= p[10] * force[0]:
        return DOUBLE_STANCE, True
    return sliding(-force[1], y, p)
