"""The section just after heel strike: coordinates z of the states there, the states, and both derivatives.

Rigid legs: z = (theta, dtheta, dpsi), or all of (theta, psi, dtheta, dpsi) where the foot was put down at a given time,
at any height. Compliant: z = (theta, L_1, L_2, dtheta, dL_1); the trailing foot's angle and two
rates follow from its constraints, eqs. (3) and (4). Limited friction: z goes on with the rate of the trailing foot's
clearance and its slip velocity, (..., v_N, v_T), zero for a foot that rolls. A foot on the ground has v_N = 0, and the
map does not ask for v_N below zero; where it is at rest, v_T = 0 has no neighbour either. Their columns of the
derivative are then zero: the derivative holds for the states that heel strikes lead to.
"""

from __future__ import annotations

from collections.abc import Callable
from math import acos, cos, sin

import numpy as np

from stages.analytic.compiled import ByKind, compiled
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import dot
from stages.analytic.model.kinds import (
    Compliant,
    DetailedCompliant,
    DetailedRigid,
    Kind,
    Limited,
    PlainCompliant,
    PlainRigid,
    Rigid,
    Rolling,
    RubbingRigid,
    TimedRigid,
)
from stages.analytic.model.walker import Vector
from stages.analytic.phases.coulomb_guard import slip_speed
from stages.analytic.phases.flow import contact_directions, row4_times

#: Slower than this, in leg lengths and pendulum times, the trailing foot is at rest: round-off of an impact.
AT_REST = 1e-11
#: Entries of the state (q, qd) that the section coordinates hold as they are.
RIGID_ENTRIES, TIMED_ENTRIES, ENTRIES = (0, 2, 3), (0, 1, 2, 3), (0, 1, 3, 4, 5)


@compiled
def rigid_angle(z: Vector, p: PlainRigid) -> float:
    """`trailing_angle` of rigid legs."""
    return float(-abs(z[0]))


@compiled
def compliant_angle(z: Vector, p: PlainCompliant) -> float:
    """`trailing_angle` of compliant legs."""
    return -acos((z[1] - p.r) * cos(z[0]) / (z[2] - p.r))


@compiled
def detailed_rigid_angle(z: Vector, p: DetailedRigid) -> float:
    """`trailing_angle` of rigid legs that may differ."""
    return -acos(((p.L_nat - p.r) * cos(z[0]) + (p.r - p.r_2)) / (p.L_nat_2 - p.r_2))


@compiled
def detailed_angle(z: Vector, p: DetailedCompliant) -> float:
    """`trailing_angle` of compliant legs that may differ."""
    return -acos(((z[1] - p.r) * cos(z[0]) + (p.r - p.r_2)) / (z[2] - p.r_2))


#: Angle of the trailing leg whose foot is on the ground; NaN where it is out of reach: trailing_angle(z, p).
trailing_angle: Callable[..., float] = ByKind({
    PlainRigid: rigid_angle, PlainCompliant: compliant_angle,
    DetailedRigid | RubbingRigid: detailed_rigid_angle, DetailedCompliant: detailed_angle})


@compiled
def rigid_state(z: Vector, p: Rigid) -> Vector:
    """`section_state` of rigid legs."""
    return np.array([z[0], trailing_angle(z, p), z[1], z[2]])


@compiled
def timed_state(z: Vector, p: TimedRigid) -> Vector:
    """`section_state` of feet that are put down at a given time."""
    return z.copy()


@compiled
def compliant_state(z: Vector, p: Compliant) -> Vector:
    """`section_state` of compliant legs; NaN where the trailing foot is out of reach."""
    y = np.empty(8)
    y[0], y[1], y[3], y[4], y[5] = z[0], z[1], z[2], z[3], z[4]
    y[2] = trailing_angle(z, p)
    y[6], y[7] = 0.0, 0.0
    rise, slip = (max(z[5], 0.0), z[6]) if z.size > 5 else (0.0, 0.0)
    normal, roll, _, _ = contact_directions(y, p)
    rates = (y[4], y[5], 0.0, 0.0)
    f1, f2 = rise - dot(normal, rates), slip - dot(roll, rates)
    inverse = 1.0 / (normal[2] * roll[3] - normal[3] * roll[2])
    y[6] = inverse * (f1 * roll[3] - normal[3] * f2)
    y[7] = inverse * (normal[2] * f2 - roll[2] * f1)
    return y


#: State y just after heel strike from its section coordinates: section_state(z, p).
section_state: Callable[..., Vector] = ByKind({
    TimedRigid: timed_state, Rigid: rigid_state, Compliant: compliant_state})


@compiled
def rigid_coordinates(y: Vector, p: Rigid) -> Vector:
    """`section_coordinates` of rigid legs."""
    return np.array([y[0], y[2], y[3]])


@compiled
def timed_coordinates(y: Vector, p: TimedRigid) -> Vector:
    """`section_coordinates` of feet that are put down at a given time."""
    return y[:4].copy()


@compiled
def rolling_coordinates(y: Vector, p: Rolling) -> Vector:
    """`section_coordinates` of rolling feet."""
    return np.array([y[0], y[1], y[3], y[4], y[5]])


@compiled
def limited_coordinates(y: Vector, p: Limited) -> Vector:
    """`section_coordinates` with limited friction; speeds at round-off are zero."""
    height_rate, slip = slip_speed(y, p)
    return np.array([y[0], y[1], y[3], y[4], y[5], height_rate if height_rate > AT_REST else 0.0,
                     slip if abs(slip) > AT_REST else 0.0])


#: Section coordinates of a state just after heel strike: section_coordinates(y, p).
section_coordinates: Callable[..., Vector] = ByKind({
    TimedRigid: timed_coordinates, Rigid: rigid_coordinates, Rolling: rolling_coordinates,
    Limited: limited_coordinates})


@compiled
def rigid_trailing_change(y: Vector, p: PlainRigid) -> float:
    """`trailing_change` of equal legs."""
    return 1.0 if y[0] < 0.0 else -1.0


@compiled
def detailed_trailing_change(y: Vector, p: DetailedRigid) -> float:
    """`trailing_change` of legs that may differ."""
    return (p.L_nat - p.r) * sin(y[0]) / ((p.L_nat_2 - p.r_2) * sin(y[1]))


#: Change of the trailing leg's angle with that of the stance leg, both rigid: trailing_change(y, p).
trailing_change: Callable[..., float] = ByKind({
    PlainRigid: rigid_trailing_change, DetailedRigid | RubbingRigid: detailed_trailing_change})


@compiled
def rigid_tangent(z: Vector, y: Vector, p: Rigid) -> Vector:
    """`section_tangent` of rigid legs."""
    tangent = np.zeros(12)
    tangent[0], tangent[1] = 1.0, trailing_change(y, p)
    tangent[6], tangent[11] = 1.0, 1.0
    return tangent


@compiled
def timed_tangent(z: Vector, y: Vector, p: TimedRigid) -> Vector:
    """`section_tangent` of feet that are put down at a given time."""
    return np.eye(4).ravel()


@compiled
def compliant_tangent(z: Vector, y: Vector, p: Compliant) -> Vector:
    """`section_tangent` of compliant legs: the clearance fixes dpsi, then both constraint rates two rates."""
    normal, roll, _, _ = contact_directions(y, p)
    by_state = eq.contact_acceleration_jacobian(
        y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, y[4], y[5], y[6], y[7], p)
    inverse = 1.0 / (normal[2] * roll[3] - normal[3] * roll[2])
    tangent = np.zeros(8 * z.size)
    for column in range(z.size):
        if (column == 5 and z[5] <= 0.0) or (column == 6 and z[5] <= 0.0 and z[6] == 0.0):
            continue
        s = 8 * column
        if column < 5:
            tangent[s + ENTRIES[column]] = 1.0
        tangent[s + 2] = -(normal[0] * tangent[s] + normal[1] * tangent[s + 1] + normal[3] * tangent[s + 3]) / normal[2]
        rates = (tangent[s + 4], tangent[s + 5], 0.0, 0.0)
        f1 = (1.0 if column == 5 else 0.0) - dot(normal, rates) - row4_times(by_state[0:4], tangent, s)
        f2 = (1.0 if column == 6 else 0.0) - dot(roll, rates) - row4_times(by_state[8:12], tangent, s)
        tangent[s + 6] = inverse * (f1 * roll[3] - normal[3] * f2)
        tangent[s + 7] = inverse * (normal[2] * f2 - roll[2] * f1)
    return tangent


#: Derivative of `section_state` at its value y, columns one after another, (j * size,): section_tangent(z, y, p).
section_tangent: Callable[..., Vector] = ByKind({
    TimedRigid: timed_tangent, Rigid: rigid_tangent, Compliant: compliant_tangent})


@compiled
def limited_speeds(y: Vector, p: Limited, derivative: np.ndarray) -> None:
    """Write the derivative of the trailing foot's two speeds into rows 5 and 6 of `section_derivative`."""
    normal, roll, _, _ = contact_directions(y, p)
    by_state = eq.contact_acceleration_jacobian(
        y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, y[4], y[5], y[6], y[7], p)
    z = limited_coordinates(y, p)
    for j in range(derivative.shape[1]):
        s = 8 * (j + 1)
        rates = (y[s + 4], y[s + 5], y[s + 6], y[s + 7])
        if z[5] > 0.0:
            derivative[5, j] = dot(normal, rates) + row4_times(by_state[0:4], y, s)
        if z[5] > 0.0 or z[6] != 0.0:
            derivative[6, j] = dot(roll, rates) + row4_times(by_state[8:12], y, s)


def entries_of(p: Kind) -> tuple[int, ...]:
    """Entries of the state that the section coordinates hold as they are."""
    if isinstance(p, TimedRigid):
        return TIMED_ENTRIES
    return RIGID_ENTRIES if isinstance(p, Rigid) else ENTRIES


def section_derivative(y: Vector, p: Rigid | Compliant) -> np.ndarray:
    """Derivative (j, n) of the j section coordinates from the state and its n variations in y ((1 + n) * size,)."""
    size, entries = 4 if isinstance(p, Rigid) else 8, entries_of(p)
    variations = y.reshape(-1, size)[1:]
    derivative = np.zeros((7 if isinstance(p, Limited) else len(entries), len(variations)))
    derivative[: len(entries)] = variations[:, entries].T
    if isinstance(p, Limited):
        limited_speeds(y, p, derivative)
    return derivative
