"""The section just after heel strike: coordinates z of the states there, the states, and both derivatives.

Rigid legs: z = (theta, dtheta, dpsi), or all of (theta, psi, dtheta, dpsi) where the foot was put down at a given time,
at any height. Compliant: z = (theta, L_1, L_2, dtheta, dL_1); the trailing foot's angle and two
rates follow from its constraints, eqs. (3) and (4). Limited friction: z goes on with the rate of the trailing foot's
clearance and its slip velocity, (..., v_N, v_T), zero for a foot that rolls. A foot on the ground has v_N = 0, and the
map does not require v_N below zero; where it is at rest, v_T = 0 has no neighbour either. Their columns of the
derivative are then zero: the derivative holds for the states that heel strikes lead to.
"""

from collections.abc import Callable
from math import acos, cos, sin

import numpy as np

from stages.analytic.compiled import ByKind, compiled
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import dot
from stages.analytic.model.kinds import H_BEHIND, Compliant, Directions, Kind, Rigid
from stages.analytic.model.walker import Vector
from stages.analytic.phases.guards import (
    contact_rate_tangents,
    contact_rates,
    contact_rates_along,
    foot_clearance,
)
from stages.analytic.phases.motion import contact_directions, number_along
from stages.analytic.phases.succession import AT_REST

#: Entries of the state (q, qd) that the section coordinates hold as they are.
RIGID_ENTRIES, TIMED_ENTRIES, ENTRIES = (0, 2, 3), (0, 1, 2, 3), (0, 1, 3, 4, 5)


@compiled
def trailing_angle(theta: float, stance: float, swing: float, p: Kind) -> float:
    """Angle of the trailing leg, of length `swing`, whose foot is on the ground; NaN where it is out of reach."""
    radius, _, _ = eq.swing_leg(p)
    if stance == swing and radius == p.r and p.h_behind == 0.0:  # acos would lose half the digits of a small angle
        return -abs(theta)
    return -acos(((stance - p.r) * cos(theta) + (p.r - radius) - p.h_behind) / (swing - radius))


@compiled
def swing_rates(y: Vector, p: Compliant, f1: float, f2: float) -> tuple[float, float]:
    """Rates of the trailing leg that give its clearance the rate f1 and its foot the slip f2, the others at rest."""
    normal, roll, _, _ = contact_directions(y, p)
    inverse = 1.0 / (normal[2] * roll[3] - normal[3] * roll[2])
    return inverse * (f1 * roll[3] - normal[3] * f2), inverse * (normal[2] * f2 - roll[2] * f1)


@compiled
def rigid_state(z: Vector, p: Rigid) -> Vector:
    """`section_state` of rigid legs."""
    if z.size == 4:
        return z.copy()
    _, length, _ = eq.swing_leg(p)
    return np.array([z[0], trailing_angle(z[0], p.L_nat, length, p), z[1], z[2]])


@compiled
def compliant_state(z: Vector, p: Compliant) -> Vector:
    """`section_state` of compliant legs; NaN where the trailing foot is out of reach."""
    y = np.empty(8)
    y[0], y[1], y[3], y[4], y[5] = z[0], z[1], z[2], z[3], z[4]
    y[2] = trailing_angle(z[0], z[1], z[2], p)
    y[6], y[7] = 0.0, 0.0
    rise, slip = (max(z[5], 0.0), z[6]) if z.size > 5 else (0.0, 0.0)
    height_rate, slide = contact_rates(y, p)
    y[6], y[7] = swing_rates(y, p, rise - height_rate, slip - slide)
    return y


#: State y just after heel strike from its section coordinates: section_state(z, p).
section_state: Callable[..., Vector] = ByKind({Rigid: rigid_state, Compliant: compliant_state})


@compiled
def rigid_coordinates(y: Vector, p: Rigid) -> Vector:
    """`section_coordinates` of rigid legs."""
    return y[:4].copy() if np.inf > p.T else np.array([y[0], y[2], y[3]])


@compiled
def compliant_coordinates(y: Vector, p: Compliant) -> Vector:
    """`section_coordinates` of compliant legs; speeds at round-off are zero."""
    if p.mu_s == np.inf:
        return np.array([y[0], y[1], y[3], y[4], y[5]])
    height_rate, slip = contact_rates(y, p)
    return np.array([y[0], y[1], y[3], y[4], y[5], height_rate if height_rate > AT_REST else 0.0,
                     slip if abs(slip) > AT_REST else 0.0])


#: Section coordinates of a state just after heel strike: section_coordinates(y, p).
section_coordinates: Callable[..., Vector] = ByKind({Rigid: rigid_coordinates, Compliant: compliant_coordinates})


@compiled
def rigid_tangent(z: Vector, y: Vector, p: Rigid, directions: Directions | None = None) -> Vector:
    """`section_tangent` of rigid legs: the clearance fixes psi, but where the foot was put down at a given time."""
    columns = z.size
    if directions is not None:
        columns += directions.rows.shape[0]
    tangents = np.zeros(4 * columns)
    if z.size == 4:
        for i in range(4):
            tangents[5 * i] = 1.0
        return tangents
    tangents[0], tangents[6], tangents[11] = 1.0, 1.0, 1.0
    radius, length, _ = eq.swing_leg(p)
    if length == p.L_nat and radius == p.r and p.h_behind == 0.0:
        tangents[1] = 1.0 if y[0] < 0.0 else -1.0
    else:
        tangents[1] = (p.L_nat - p.r) * sin(y[0]) / ((length - radius) * sin(y[1]))
    for s in range(12, tangents.size, 4):
        change = foot_clearance(y, p, tangents, s, directions)[1] - number_along(directions, tangents, s, 4, H_BEHIND)
        tangents[s + 1] = -change / ((length - radius) * sin(y[1])) if change != 0.0 else 0.0
    return tangents


@compiled
def compliant_tangent(z: Vector, y: Vector, p: Compliant, directions: Directions | None = None) -> Vector:
    """`section_tangent` of compliant legs: the clearance fixes dpsi, then both constraint rates two rates."""
    normal, _, _, _ = contact_directions(y, p)
    columns = z.size
    if directions is not None:
        columns += directions.rows.shape[0]
    tangents = np.zeros(8 * columns)
    for column in range(columns):
        if z.size > 5 and z[5] <= 0.0 and (column == 5 or (column == 6 and z[6] == 0.0)):
            continue
        s, rise, slip = 8 * column, 0.0, 0.0
        if column < 5:
            tangents[s + ENTRIES[column]] = 1.0
        elif column < z.size:
            rise, slip = (1.0, 0.0) if column == 5 else (0.0, 1.0)
        height = dot(normal, (tangents[s], tangents[s + 1], 0.0, tangents[s + 3]))
        if directions is not None and column >= z.size:
            d = eq.row_as(p, directions.rows, column - z.size)
            height = foot_clearance(y, p, tangents, s, directions)[1] - d.h_behind
            more = contact_rates_along(y, p, d)
            rise, slip = -more[0], -more[1]
        tangents[s + 2] = -height / normal[2]
        own = contact_rate_tangents(y, p, tangents, s)
        tangents[s + 6], tangents[s + 7] = swing_rates(y, p, rise - own[0], slip - own[1])
    return tangents


#: Derivative of `section_state` at its value y, columns one after another, (n * size,): those by the coordinates, then
#: those along the directions, at given coordinates: section_tangent(z, y, p, directions).
section_tangent: Callable[..., Vector] = ByKind({Rigid: rigid_tangent, Compliant: compliant_tangent})


@compiled
def speed_tangents(y: Vector, p: Compliant, derivative: np.ndarray, directions: Directions | None) -> None:
    """Write the derivative of the trailing foot's two speeds into rows 5 and 6 of `section_derivative`."""
    z = compliant_coordinates(y, p)
    for j in range(derivative.shape[1]):
        rise, slip = contact_rate_tangents(y, p, y, 8 * (j + 1))
        if directions is not None:
            row = j - derivative.shape[1] + directions.rows.shape[0]
            if row >= 0:
                more = contact_rates_along(y, p, eq.exchanged(eq.row_as(p, directions.rows, row)))
                rise, slip = rise + more[0], slip + more[1]
        if z[5] > 0.0:
            derivative[5, j] = rise
        if z[5] > 0.0 or z[6] != 0.0:
            derivative[6, j] = slip


def entries_of(p: Kind) -> tuple[int, ...]:
    """Entries of the state that the section coordinates hold as they are."""
    if isinstance(p, Rigid):
        return TIMED_ENTRIES if np.inf > p.T else RIGID_ENTRIES
    return ENTRIES


def section_derivative(y: Vector, p: Kind, directions: Directions | None = None) -> np.ndarray:
    """Derivative (j, n) of the j section coordinates from the state and its n variations in y ((1 + n) * size,).

    `p` is the walker after the heel strike, and `directions` those of the step before it, if the last variations go
    with any.
    """
    size, entries = 4 if isinstance(p, Rigid) else 8, entries_of(p)
    variations = y.reshape(-1, size)[1:]
    derivative: np.ndarray = variations[:, entries].T.copy()
    if isinstance(p, Rigid) or p.mu_s == np.inf:
        return derivative
    derivative = np.vstack([derivative, np.zeros((2, len(variations)))])
    speed_tangents(y, p, derivative, directions)
    return derivative
