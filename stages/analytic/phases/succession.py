"""Which phase follows which, and what happens to the state in between.

Rolling, eq. (6): double stance from heel strike to toe-off, single stance to the next heel strike. With limited
friction the trailing foot rolls, slides or hovers in between, as its forces have it: |lambda_2| <= mu_s lambda_1 while
it rolls, lambda_2 = -mu_d sign(slip) lambda_1 while it slides, no pull. Where more than one of these fits, or none
(Painleve's paradox), no phase follows.

Friction at the hip opposes the rate of theta + psi. Where that comes to zero, the torque that would hold it decides:
below friction's the hip sticks, above it rubs the other way. Where a trailing foot leaves, the force along the ground
that it bore ends at once, and it is decided anew whether a hip sticks.
"""

from collections.abc import Callable

import numpy as np

from stages.analytic.compiled import ByKind, compiled
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import dot
from stages.analytic.model.kinds import PASSING, Compliant, Directions, Kind, Rigid
from stages.analytic.model.walker import Vector
from stages.analytic.phases.guards import contact_rates, foot_clearance, wedges
from stages.analytic.phases.impact import heel_strike_reset, strike
from stages.analytic.phases.motion import (
    DOUBLE_STANCE,
    HIP_STICKS,
    HOVERING,
    ON_BOTH,
    PHASES,
    RIGID,
    RUBS_BACK,
    RUBS_FORWARD,
    SINGLE_STANCE,
    SLIDING_BACK,
    SLIDING_FORWARD,
    STICKS,
    accelerations,
    contact_directions,
    hip_rate,
    holding_torque,
    in_contact,
    shape,
)

#: The phase that follows, and whether the laws of contact decide it.
Next = tuple[int, bool]
#: Slower than this, in leg lengths and pendulum times, the trailing foot is at rest: round-off of an impact; slower
#: than this, in 1 / pendulum time, the legs do not move against each other.
AT_REST, HIP_AT_REST = 1e-11, 1e-13
#: Lower than this a foot has landed; a trailing foot that presses less than this, in the walker's weight, is leaving.
LANDED, LEAVING = 1e-11, 1e-9


@compiled
def from_standstill(both: bool, y: Vector, p: Kind, may_stick: bool) -> int:
    """The phase of a hip whose legs do not move against each other: it sticks if it may, or begins to rub."""
    more = ON_BOTH if both else 0
    torque = holding_torque(HIP_STICKS + more, y, p)
    if may_stick and abs(torque) < p.tau_h:
        return HIP_STICKS + more
    return (RUBS_BACK if torque > 0.0 else RUBS_FORWARD) + more


@compiled
def hip_phase(both: bool, y: Vector, p: Kind) -> int:
    """The phase of a hip with friction, with both feet on the ground, or one."""
    rate = hip_rate(y, 0, p)
    if abs(rate) > HIP_AT_REST:
        return (RUBS_FORWARD if rate > 0.0 else RUBS_BACK) + (ON_BOTH if both else 0)
    return from_standstill(both, y, p, True)


@compiled
def airborne(y: Vector) -> int:
    """The phase of a trailing foot in the air: in play until it swings forward."""
    return SINGLE_STANCE if y[6] > 0.0 else HOVERING


@compiled
def sliding(sign: float, y: Vector, p: Compliant) -> Next:
    """The phase of a trailing foot that slips with `sign`, and whether its contact is no wedge."""
    phase, ratio = (SLIDING_FORWARD, -p.mu_d) if sign > 0.0 else (SLIDING_BACK, p.mu_d)
    if wedges(y, p, ratio):
        return phase, False
    _, loads = accelerations(phase, y, p)
    return (phase, True) if loads[0] > 0.0 else (airborne(y), True)


@compiled
def from_rest(y: Vector, p: Compliant) -> Next:
    """What a trailing foot at rest on the ground does next: roll, start to slip, or rise; and whether that is sure."""
    _, loads = accelerations(DOUBLE_STANCE, y, p)
    free, _ = accelerations(SINGLE_STANCE, y, p)
    normal, roll, target1, target2 = contact_directions(y, p)
    rises = dot(normal, free) > target1
    if loads[0] > 0.0 and abs(loads[1]) <= p.mu_s * loads[0]:
        return DOUBLE_STANCE, not rises
    if rises:
        return airborne(y), not (wedges(y, p, p.mu_d) or wedges(y, p, -p.mu_d))
    for sign in (1.0, -1.0):
        phase, sure = sliding(sign, y, p)
        if sure and in_contact(phase):
            qdd, _ = accelerations(phase, y, p)
            if sign * (dot(roll, qdd) - target2) > 0.0:
                return phase, True
    return airborne(y), False


@compiled
def contact_phase(y: Vector, p: Compliant) -> Next:
    """The phase after an impact with limited friction, and whether the laws of contact decide it."""
    height_rate, slip = contact_rates(y, p)
    if height_rate > AT_REST:
        return airborne(y), True
    if abs(slip) > AT_REST:
        return sliding(slip, y, p)
    return from_rest(y, p)


@compiled
def rigid_first_phase(y: Vector, p: Rigid) -> Next:
    """`first_phase` of rigid legs."""
    return (hip_phase(False, y, p) if p.tau_h > 0.0 else RIGID), True


@compiled
def compliant_first_phase(y: Vector, p: Compliant) -> Next:
    """`first_phase` of compliant legs."""
    if p.mu_s < np.inf:
        return contact_phase(y, p)
    return (hip_phase(True, y, p) if p.tau_h > 0.0 else DOUBLE_STANCE), True


#: The phase just after heel strike, and whether it is decided: first_phase(y, p).
first_phase: Callable[..., Next] = ByKind({Rigid: rigid_first_phase, Compliant: compliant_first_phase})


@compiled
def single_stance(y: Vector, p: Kind) -> int:
    """The phase of a walker with one foot on the ground."""
    if p.tau_h > 0.0:
        return hip_phase(False, y, p)
    return RIGID if shape(p)[0] == 4 else SINGLE_STANCE


@compiled
def ends_step(phase: int, y: Vector, p: Kind) -> bool:
    """Whether the event that ended `phase`, at state `y`, is the heel strike that ends a step."""
    if phase < RUBS_FORWARD:
        return phase <= SINGLE_STANCE
    height, _, advance = foot_clearance(y, p, y, 0)
    return not in_contact(phase) and advance > PASSING and abs(height - p.h_ahead) < LANDED


@compiled
def leaves(phase: int, y: Vector, p: Kind) -> bool:
    """Whether the event that ended the phase of a hip with friction is the trailing foot's, which leaves the ground."""
    return in_contact(phase) and accelerations(phase, y, p)[1][0] <= LEAVING


@compiled
def of_hip(phase: int, y: Vector, p: Kind) -> bool:
    """Whether the event that ended `phase`, at state `y`, is the hip's: it stops, or lets go."""
    return phase >= RUBS_FORWARD and not (ends_step(phase, y, p) or leaves(phase, y, p))


@compiled
def hip_succession(phase: int, y: Vector, p: Kind) -> int:
    """The phase after an event of a walker with friction at the hip that ends no step."""
    sticks = PHASES[phase, STICKS] == 1
    if leaves(phase, y, p):
        return from_standstill(False, y, p, True) if sticks else phase - ON_BOTH
    return from_standstill(in_contact(phase), y, p, not sticks)


@compiled
def rigid_succession(phase: int, y: Vector, p: Rigid, directions: Directions | None = None) -> Next:
    """`within_a_step` of rigid legs."""
    return hip_succession(phase, y, p), True


@compiled
def compliant_succession(phase: int, y: Vector, p: Compliant, directions: Directions | None = None) -> Next:
    """`within_a_step` of compliant legs."""
    if phase >= RUBS_FORWARD:
        return hip_succession(phase, y, p), True
    if p.mu_s == np.inf:
        return SINGLE_STANCE, True
    if phase == HOVERING:
        if foot_clearance(y, p, y, 0)[0] > -y[6]:
            return SINGLE_STANCE, True
        if not strike(y, p, directions, False):
            return phase, False
        return contact_phase(y, p)
    _, held = accelerations(DOUBLE_STANCE, y, p)
    if phase == DOUBLE_STANCE:
        return sliding(-held[1], y, p)
    _, loads = accelerations(phase, y, p)
    if loads[0] <= abs(contact_rates(y, p)[1]):
        return airborne(y), True
    if held[0] > 0.0 and abs(held[1]) <= p.mu_s * held[0]:
        return DOUBLE_STANCE, True
    return sliding(-held[1], y, p)


#: The phase after an event that ends no step: within_a_step(phase, y, p, directions).
within_a_step: Callable[..., Next] = ByKind({Rigid: rigid_succession, Compliant: compliant_succession})


@compiled
def succeed(phase: int, y: Vector, p: Kind, directions: Directions | None = None) -> Next:
    """Cross the event that ended `phase`, with the state and its variations in place; the phase that follows, and
    whether the laws of contact decide it.
    """
    if not ends_step(phase, y, p):
        return within_a_step(phase, y, p, directions)
    if not heel_strike_reset(y, p, directions):
        return SINGLE_STANCE, False
    return first_phase(y, eq.exchanged(p))
