"""The guards of each phase: the first that falls through zero ends it. With each comes its tangent.

Heel strike: clearance falls to the height of the ground ahead with the swing foot ahead of the stance foot. The legs
are equally long, so the swing foot also falls below ground behind the stance foot and rises again; that is no heel
strike. Rigid legs do so where they are parallel, with one foot at the very place of the other: only round-off says
which is ahead.

A trailing foot that rolls leaves where its normal force falls to zero, or with limited friction slips where the
friction it has left does. Sliding ends where the normal force or the slip falls to zero; hovering where the foot comes
down, or starts to swing forward, after which it is out of play until it is ahead of the other foot (stepping blocks).
Of two such the guard is the lesser, so it falls through zero with the first.

A hip that rubs stops where its rate falls to zero; one that sticks lets go where the torque that holds it reaches
friction's.
"""

from collections.abc import Callable
from math import cos, sin

import numpy as np

from stages.analytic.compiled import ByKind, compiled
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import dot, solve
from stages.analytic.model.kinds import H_AHEAD, MU_S, TAU_H, Compliant, Directions, Kind, Rigid
from stages.analytic.model.walker import Vector
from stages.analytic.phases.motion import (
    HOVERING,
    NORMAL,
    PHASES,
    RUB,
    SLIDE,
    STICKS,
    accelerations,
    contact_directions,
    hip_rate,
    loads,
    number_along,
    row4_times,
    row_of,
    shape,
)

#: Value, tangent, and whether a fall through zero is the event.
Guard = tuple[float, float, bool]
#: Which guard of a phase: that of the feet, or that of a hip that rubs or sticks.
FEET, HIP = 0, 1
#: Least share of its frictionless value to which friction may lower the mobility of a sliding contact.
LEAST_MOBILITY = 1e-3


@compiled
def rigid_clearance(
    y: Vector, p: Rigid, dy: Vector, start: int, directions: Directions | None = None
) -> tuple[float, float, float]:
    """`foot_clearance` of rigid legs."""
    radius, length, _ = eq.swing_leg(p)
    stance, swing, theta, psi = p.L_nat - p.r, length - radius, y[0], y[1]
    ahead, behind = swing * sin(psi), stance * sin(theta)
    change = ahead * dy[start + 1] - behind * dy[start]
    if directions is not None:
        row = row_of(directions, dy, start, 4)
        if row >= 0:
            by = eq.rigid_clearance_by(theta, psi, p)
            change += eq.rigid_clearance_change(by, eq.row_as(p, directions.rows, row))[0]
    return stance * cos(theta) - swing * cos(psi) + (p.r - radius), change, behind + ahead


@compiled
def compliant_clearance(
    y: Vector, p: Compliant, dy: Vector, start: int, directions: Directions | None = None
) -> tuple[float, float, float]:
    """`foot_clearance` of compliant legs."""
    radius, _, _ = eq.swing_leg(p)
    theta, stance, psi, swing = y[0], y[1] - p.r, y[2], y[3] - radius
    height = stance * cos(theta) - swing * cos(psi) + (p.r - radius)
    change = (cos(theta) * dy[start + 1] - stance * sin(theta) * dy[start]
              - cos(psi) * dy[start + 3] + swing * sin(psi) * dy[start + 2])
    if directions is not None:
        row = row_of(directions, dy, start, 8)
        if row >= 0:
            change += clearance_along(y, p, eq.row_as(p, directions.rows, row))
    return height, change, stance * sin(theta) + swing * sin(psi)


#: Height of the swing foot above the ground, its tangent along the variation of the coordinates stored in `dy` from
#: `start`, and its advance on the stance foot, eq. (3): foot_clearance(y, p, dy, start, directions).
foot_clearance: Callable[..., tuple[float, float, float]] = ByKind({
    Rigid: rigid_clearance, Compliant: compliant_clearance})


@compiled
def clearance_along(y: Vector, p: Compliant, d: Compliant) -> float:
    """Tangent of the swing foot's height along the direction `d` of the numbers, at given configuration."""
    return eq.compliant_clearance_change(eq.compliant_clearance_by(y[0], y[1], y[2], y[3], p), d)[0]


@compiled
def contact_rates(y: Vector, p: Compliant) -> tuple[float, float]:
    """Rate of the clearance of the trailing foot, and its slip velocity: Pi^T qd."""
    normal, roll, _, _ = contact_directions(y, p)
    rates = (y[4], y[5], y[6], y[7])
    return dot(normal, rates), dot(roll, rates)


@compiled
def contact_rates_along(y: Vector, p: Compliant, d: Compliant) -> tuple[float, float]:
    """Tangents of `contact_rates` along the direction `d` of the numbers, at a given state."""
    by = eq.contact_acceleration_by(y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, y[4], y[5], y[6], y[7], p)
    change = eq.contact_acceleration_change(by, d)
    return change[0], change[1]


@compiled
def contact_rate_tangents(y: Vector, p: Compliant, dy: Vector, start: int) -> tuple[float, float]:
    """Tangents of `contact_rates` along the variation of the state stored in `dy` from `start`."""
    normal, roll, _, _ = contact_directions(y, p)
    by_place = eq.contact_acceleration_jacobian(
        y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, y[4], y[5], y[6], y[7], p)
    rates = (dy[start + 4], dy[start + 5], dy[start + 6], dy[start + 7])
    return (dot(normal, rates) + row4_times(by_place[0:4], dy, start),
            dot(roll, rates) + row4_times(by_place[8:12], dy, start))


@compiled
def hip_guard(phase: int, y: Vector, p: Kind, dy: Vector, start: int, directions: Directions | None) -> Guard:
    """Rate of the hip in the direction in which it rubs, or what friction has left of a hip that sticks."""
    sign = PHASES[phase, RUB]
    if PHASES[phase, STICKS] == 0:
        return sign * hip_rate(y, 0, p), sign * hip_rate(dy, start, p), True
    found, change = loads(phase, y, p, dy, start, directions)
    size, _ = shape(p)
    more = number_along(directions, dy, start, size, TAU_H)
    return p.tau_h - abs(found[2]), more - np.sign(found[2]) * change[2], True


@compiled
def sliding_guard(
    phase: int, y: Vector, p: Compliant, dy: Vector, start: int, directions: Directions | None
) -> Guard:
    """Normal force of a foot that slides, or how fast it slips if that is less."""
    sign, (_, slip) = PHASES[phase, SLIDE], contact_rates(y, p)
    qdd, found = accelerations(phase, y, p)
    if sign * slip >= found[0]:
        found, change = loads(phase, y, p, dy, start, directions)
        return found[0], change[0], True
    if start == 0:  # along the flow no derivative is needed
        _, roll, _, target = contact_directions(y, p)
        return sign * slip, sign * (dot(roll, qdd) - target), True
    _, change_of_slip = contact_rate_tangents(y, p, dy, start)
    if directions is not None:
        row = row_of(directions, dy, start, 8)
        if row >= 0:
            change_of_slip += contact_rates_along(y, p, eq.row_as(p, directions.rows, row))[1]
    return sign * slip, sign * change_of_slip, True


@compiled
def compliant_guard(
    phase: int, y: Vector, p: Compliant, dy: Vector, start: int, directions: Directions | None = None, which: int = FEET
) -> Guard:
    """`guard` of compliant legs."""
    if which == HIP:
        return hip_guard(phase, y, p, dy, start, directions)
    if PHASES[phase, SLIDE] != 0:
        return sliding_guard(phase, y, p, dy, start, directions)
    if PHASES[phase, NORMAL] == 1:
        found, change = loads(phase, y, p, dy, start, directions)
        if p.mu_s == np.inf:
            return found[0], change[0], True
        left = (p.mu_s * change[0] + number_along(directions, dy, start, 8, MU_S) * found[0]
                - np.sign(found[1]) * change[1])
        return p.mu_s * found[0] - abs(found[1]), left, True
    height, rise, advance = foot_clearance(y, p, dy, start, directions)
    if phase == HOVERING and height > -y[6]:
        return -y[6], -dy[start + 6], True
    rise -= number_along(directions, dy, start, 8, H_AHEAD)
    return height - p.h_ahead, rise, advance > p.x_ahead or phase == HOVERING


@compiled
def rigid_guard(
    phase: int, y: Vector, p: Rigid, dy: Vector, start: int, directions: Directions | None = None, which: int = FEET
) -> Guard:
    """`guard` of rigid legs."""
    if which == HIP:
        return hip_guard(phase, y, p, dy, start, directions)
    height, rise, advance = foot_clearance(y, p, dy, start, directions)
    rise -= number_along(directions, dy, start, 4, H_AHEAD)
    return height - p.h_ahead, rise, advance > p.x_ahead


#: A guard of the phase, its tangent along the variation of the state stored in `dy` from `start`, which may go with a
#: direction, and whether its fall through zero is the event: guard(phase, y, p, dy, start, directions, which). Along
#: the flow, `dy` is dy/dt and `start` zero.
guard: Callable[..., Guard] = ByKind({Rigid: rigid_guard, Compliant: compliant_guard})


@compiled
def wedges(y: Vector, p: Compliant, ratio: float) -> bool:
    """Whether friction `ratio` (tangential over normal) takes away the mobility of the trailing foot's contact."""
    t = eq.compliant_terms(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p)
    factors = eq.mass_factors(t, p)
    normal, roll, _, _ = contact_directions(y, p)
    by_normal = solve(factors, normal[0], normal[1], normal[2], normal[3])
    by_roll = solve(factors, roll[0], roll[1], roll[2], roll[3])
    free = dot(normal, by_normal)
    return free + ratio * dot(normal, by_roll) <= LEAST_MOBILITY * free
