"""The law of motion: a phase is a row of what holds, slides and rubs, and one solve serves every row and every tangent.

The state is y = (q, qd), followed by any number of variations dy, each as long as the state: q = (theta, psi) of rigid
legs, (theta, L_1, psi, L_2) of compliant ones. The stance foot rolls. M qdd = Q - C qd + what contacts and hip bear:

- a trailing foot that rolls is held along the ground's normal and along its roll, at acceleration level; given a
  consistent start both only drift;
- one that slides is held along the normal alone, and its normal force pushes it back along the ground by mu_d;
- a hip that sticks is held by a torque on theta + psi, one that rubs bears the torque tau_h against its rate.

What is held is solved for, contacts first. Variations are tangents of the same equations: the same factors solve for
their rates, whether they vary the state alone or the walker's numbers too (`Directions`).
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from stages.analytic.compiled import ByKind, Four, Jacobians, Numbers, compiled, inlined
from stages.analytic.model import terms as eq
from stages.analytic.model.elimination import dot, factor_constrained, solve
from stages.analytic.model.kinds import Compliant, Directions, Kind, Rigid
from stages.analytic.model.walker import Vector

RIGID, SINGLE_STANCE, DOUBLE_STANCE = 0, 1, 2
SLIDING_FORWARD, SLIDING_BACK, HOVERING = 3, 4, 5
#: Phases of a hip that rubs or sticks; with both feet of compliant legs on the ground they are `ON_BOTH` more.
RUBS_FORWARD, RUBS_BACK, HIP_STICKS, ON_BOTH = 6, 7, 8, 3
#: Columns of `PHASES`: whether the trailing foot is held along the normal, and along its roll; the sign of its slide;
#: whether the hip is held; the sign of its rate.
NORMAL, ROLL, SLIDE, STICKS, RUB = 0, 1, 2, 3, 4
PHASES = np.array([
    [0, 0, 0, 0, 0], [0, 0, 0, 0, 0], [1, 1, 0, 0, 0],
    [1, 0, 1, 0, 0], [1, 0, -1, 0, 0], [0, 0, 0, 0, 0],
    [0, 0, 0, 0, 1], [0, 0, 0, 0, -1], [0, 0, 0, 1, 0],
    [1, 1, 0, 0, 1], [1, 1, 0, 0, -1], [1, 1, 0, 1, 0]])

#: What the trailing foot and the hip bear: normal force, force along the roll, torque on theta + psi.
Loads = tuple[float, float, float]
#: What a direction of the numbers adds to the tangent of M qdd + C qd - Q - Pi lambda (4), to that of what the contacts
#: hold (2), and the torque that it gives the hip.
Added = tuple[float, float, float, float, float, float, float]
NOTHING = (0.0,) * 7
#: Derivatives of the residual and of what the contacts hold by the walker's numbers, the same for every direction.
By = tuple[Numbers, Numbers]
NO_ROW, SIXTEEN_ZEROS = (0.0, 0.0, 0.0, 0.0), tuple(16 * [0.0])


class Contact(NamedTuple):
    """What the trailing foot is held by: its two directions, accelerations by a unit force along each (that of friction
    with the normal one), the inverse of what they hold by rows without 21, and friction by normal force."""

    normal: Four
    roll: Four
    by_normal: Four
    by_roll: Four
    c11: float
    c12: float
    c22: float
    ratio: float


class System(NamedTuple):
    """What solves the equations of a phase again: factors of M, contact, and what a unit torque does to accelerations,
    to the contact's forces and to the acceleration of theta + psi."""

    factors: Any
    contact: Contact
    by_torque: Four
    forces: tuple[float, float]
    turn: float


IN_THE_AIR = Contact(NO_ROW, NO_ROW, NO_ROW, NO_ROW, 0.0, 0.0, 0.0, 0.0)


@compiled
def in_contact(phase: int) -> bool:
    """Whether both feet are on the ground."""
    return bool(PHASES[phase, NORMAL] == 1)


@compiled
def row4_times(row: Numbers, dy: Vector, start: int) -> float:
    """A row of four times what is stored from `start`. Written out: a loop over a tuple compiles to a long switch."""
    total: float = row[0] * dy[start] + row[1] * dy[start + 1] + row[2] * dy[start + 2] + row[3] * dy[start + 3]
    return total


@compiled
def row8_times(row: Numbers, dy: Vector, start: int) -> float:
    """A row of eight times the variation stored from `start`."""
    total: float = (
        row[0] * dy[start] + row[1] * dy[start + 1] + row[2] * dy[start + 2] + row[3] * dy[start + 3]
        + row[4] * dy[start + 4] + row[5] * dy[start + 5] + row[6] * dy[start + 6] + row[7] * dy[start + 7]
    )  # fmt: skip
    return total


@compiled
def plus(a: Four, b: Four, share: float) -> Four:
    """a + share b."""
    return a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2], a[3] + share * b[3]


@compiled
def contact_directions(y: Vector, p: Compliant) -> tuple[Four, Four, float, float]:
    """Pi^T by rows and -dPi^T/dt qd: the acceleration the constraints demand."""
    c = eq.contact_terms(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p)
    return (c[0], c[1], c[2], c[3]), (c[4], c[5], c[6], c[7]), -c[8], -c[9]


@compiled
def rolling(factors: Any, normal: Four, roll: Four) -> Contact:
    """The contact of a foot that rolls."""
    by_normal, by_roll, c11, c12, c22 = factor_constrained(factors, normal, roll)
    return Contact(normal, roll, by_normal, by_roll, c11, c12, c22, 0.0)


@compiled
def slipping(factors: Any, normal: Four, roll: Four, ratio: float) -> Contact:
    """The contact of a foot that slips with friction `ratio`, tangential over normal.

    c11 is the inverse of what a unit of normal force accelerates along it; friction can turn its sign (Painleve).
    """
    push = solve(factors, normal[0] + ratio * roll[0], normal[1] + ratio * roll[1],
                 normal[2] + ratio * roll[2], normal[3] + ratio * roll[3])
    return Contact(normal, roll, push, NO_ROW, 1.0 / dot(normal, push), 0.0, 0.0, ratio)


@inlined
def held(contact: Contact, free: Four, target1: float, target2: float) -> tuple[Four, tuple[float, float]]:
    """Accelerations or velocities with the contact's directions at their targets, from those without it; its forces."""
    t1, t2 = target1 - dot(contact.normal, free), target2 - dot(contact.roll, free)
    l1, l2 = contact.c11 * t1 + contact.c12 * t2, contact.c12 * t1 + contact.c22 * t2
    x = plus(plus(free, contact.by_normal, l1), contact.by_roll, l2)
    return x, (l1, contact.ratio * l1 + l2)


@inlined
def solved(phase: int, s: System, f: Four, target1: float, target2: float, torque: float) -> tuple[Four, Loads]:
    """Accelerations under the forces `f`, contacts held at their targets, and loads; `torque` is that of a hip that
    rubs. The same solves for their tangents."""
    x, force = solve(s.factors, f[0], f[1], f[2], f[3]), (0.0, 0.0)
    if PHASES[phase, NORMAL] == 1:
        x, force = held(s.contact, x, target1, target2)
    if phase >= RUBS_FORWARD:
        if PHASES[phase, STICKS] == 1:
            torque = -(x[0] + x[2]) / s.turn
        x = plus(x, s.by_torque, torque)
        force = (force[0] + s.forces[0] * torque, force[1] + s.forces[1] * torque)
    return x, (force[0], force[1], torque)


@inlined
def motion(phase: int, y: Vector, p: Compliant) -> tuple[Four, Loads, System]:
    """qdd and loads of compliant legs, and what solves the same equations again."""
    t = eq.compliant_terms(y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], p)
    factors, contact, target1, target2 = eq.mass_factors(t, p), IN_THE_AIR, 0.0, 0.0
    push, forces = NO_ROW, (0.0, 0.0)
    if PHASES[phase, NORMAL] == 1:
        normal, roll, target1, target2 = contact_directions(y, p)
        if PHASES[phase, ROLL] == 1:
            contact = rolling(factors, normal, roll)
        else:
            contact = slipping(factors, normal, roll, -PHASES[phase, SLIDE] * p.mu_d)
    if phase >= RUBS_FORWARD:
        push = solve(factors, 1.0, 0.0, 1.0, 0.0)
        if PHASES[phase, NORMAL] == 1:
            push, forces = held(contact, push, 0.0, 0.0)
    system = System(factors, contact, push, forces, push[0] + push[2])
    qdd, loads = solved(phase, system, (t[10], t[11], t[12], t[13]), target1, target2, -PHASES[phase, RUB] * p.tau_h)
    return qdd, loads, system


@inlined
def jacobians(phase: int, y: Vector, qdd: Four, loads: Loads, p: Compliant) -> Jacobians:
    """Derivatives by the state of the residual, of the contact's forces and of what it holds, at given qdd and loads.
    """
    by_state = eq.compliant_residual_jacobian(
        y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], qdd[0], qdd[1], qdd[2], qdd[3], p)
    by_force, by_contact = SIXTEEN_ZEROS, SIXTEEN_ZEROS
    if PHASES[phase, NORMAL] == 1:
        by_force = eq.contact_force_jacobian(y[0], y[1], y[2], y[3], loads[0], loads[1], p)
        by_contact = eq.contact_acceleration_jacobian(
            y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], qdd[0], qdd[1], qdd[2], qdd[3], p)
    return by_state, by_force, by_contact


@inlined
def by_numbers(y: Vector, qdd: Four, loads: Loads, p: Compliant) -> By:
    """Derivatives of the residual and of what the contacts hold by the walker's numbers."""
    residual = eq.compliant_residual_by(
        y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], qdd[0], qdd[1], qdd[2], qdd[3], loads[0], loads[1], p)
    return residual, eq.contact_acceleration_by(
        y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7], qdd[0], qdd[1], qdd[2], qdd[3], p)


@inlined
def along(phase: int, by: By, loads: Loads, roll: Four, d: Compliant) -> Added:
    """What the direction `d` of the numbers adds to tangents in a phase, where `loads` act."""
    f, drag = eq.compliant_residual_change(by[0], d), -PHASES[phase, SLIDE] * d.mu_d * loads[0]
    contact = eq.contact_acceleration_change(by[1], d)
    return (f[0] - drag * roll[0], f[1] - drag * roll[1], f[2] - drag * roll[2], f[3] - drag * roll[3],
            contact[0], contact[1], -PHASES[phase, RUB] * d.tau_h)


@inlined
def tangent(phase: int, s: System, j: Jacobians, dy: Vector, start: int, added: Added) -> tuple[Four, Loads]:
    """Tangents of qdd and loads along the variation of the state stored from `start` and what the numbers add."""
    by_state, by_force, by_contact = j
    f1, f2 = row8_times(by_state[0:8], dy, start) + added[0], row8_times(by_state[8:16], dy, start) + added[1]
    f3, f4 = row8_times(by_state[16:24], dy, start) + added[2], row8_times(by_state[24:32], dy, start) + added[3]
    target1, target2 = added[4], added[5]
    if PHASES[phase, NORMAL] == 1:
        f1, f2 = f1 - row4_times(by_force[0:4], dy, start), f2 - row4_times(by_force[4:8], dy, start)
        f3, f4 = f3 - row4_times(by_force[8:12], dy, start), f4 - row4_times(by_force[12:16], dy, start)
        target1 += row8_times(by_contact[0:8], dy, start)
        target2 += row8_times(by_contact[8:16], dy, start)
    return solved(phase, s, (-f1, -f2, -f3, -f4), -target1, -target2, added[6])


@compiled
def compliant_rates(phase: int, y: Vector, p: Compliant, rates: Vector, directions: Directions | None = None) -> None:
    """`flow` of compliant legs."""
    qdd, loads, system = motion(phase, y, p)
    for i in range(4):
        rates[i], rates[4 + i] = y[4 + i], qdd[i]
    if y.size > 8:
        j, first = jacobians(phase, y, qdd, loads, p), y.size
        if directions is not None:
            by, first = by_numbers(y, qdd, loads, p), y.size - 8 * directions.rows.shape[0]
        for start in range(8, y.size, 8):
            added = NOTHING
            if directions is not None and start >= first:
                d = eq.row_as(p, directions.rows, (start - first) // 8)
                added = along(phase, by, loads, system.contact.roll, d)
            dqdd, _ = tangent(phase, system, j, y, start, added)
            for i in range(4):
                rates[start + i] = y[start + 4 + i]
            rates[start + 4], rates[start + 5], rates[start + 6], rates[start + 7] = dqdd


@compiled
def rigid_solved(
    phase: int, inverse: tuple[float, float, float], f1: float, f2: float, torque: float
) -> tuple[float, float, float]:
    """`solved` of rigid legs: two accelerations and the hip's torque."""
    a1, a2 = inverse[0] * f1 + inverse[1] * f2, inverse[1] * f1 + inverse[2] * f2
    if phase >= RUBS_FORWARD:
        each1, each2 = inverse[0] + inverse[1], inverse[1] + inverse[2]
        if PHASES[phase, STICKS] == 1:
            torque = -(a1 + a2) / (each1 + each2)
        a1, a2 = a1 + each1 * torque, a2 + each2 * torque
    return a1, a2, torque


@compiled
def rigid_motion(
    phase: int, y: Vector, p: Rigid, driven: float = 0.0
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """qdd of rigid legs and the hip's torque, beside one that it is `driven` with; and the inverse of M (11, 12, 22).
    """
    m11, m12, m22, f1, f2 = eq.rigid_terms(y[0], y[1], y[2], y[3], p)
    scale = 1.0 / (m11 * m22 - m12 * m12)
    inverse = (m22 * scale, -m12 * scale, m11 * scale)
    torque = 0.0
    if phase >= RUBS_FORWARD:
        torque = -PHASES[phase, RUB] * p.tau_h
    return rigid_solved(phase, inverse, f1 + driven, f2 + driven, torque), inverse


@compiled
def rigid_tangent(
    phase: int, inverse: tuple[float, float, float], j: Numbers, dy: Vector, start: int,
    added: tuple[float, float, float],
) -> tuple[float, float, float]:  # fmt: skip
    """Tangents of what `rigid_motion` gives, like `tangent`; `added` to the residual (2), and the hip's torque."""
    f1, f2 = row4_times(j[0:4], dy, start) + added[0], row4_times(j[4:8], dy, start) + added[1]
    return rigid_solved(phase, inverse, -f1, -f2, added[2])


@compiled
def rigid_along(phase: int, by: Numbers, d: Rigid) -> tuple[float, float, float]:
    """`along` of rigid legs."""
    f, torque = eq.rigid_residual_change(by, d), 0.0
    if phase >= RUBS_FORWARD:
        torque = -PHASES[phase, RUB] * d.tau_h
    return f[0], f[1], torque


@compiled
def rigid_rates(phase: int, y: Vector, p: Rigid, rates: Vector, directions: Directions | None = None) -> None:
    """`flow` of rigid legs."""
    qdd, inverse = rigid_motion(phase, y, p)
    rates[0], rates[1], rates[2], rates[3] = y[2], y[3], qdd[0], qdd[1]
    if y.size > 4:
        j, first = eq.rigid_residual_jacobian(y[0], y[1], y[2], y[3], qdd[0], qdd[1], p), y.size
        if directions is not None:
            by = eq.rigid_residual_by(y[0], y[1], y[2], y[3], qdd[0], qdd[1], p)
            first = y.size - 4 * directions.rows.shape[0]
        for start in range(4, y.size, 4):
            added = (0.0, 0.0, 0.0)
            if directions is not None and start >= first:
                added = rigid_along(phase, by, eq.row_as(p, directions.rows, (start - first) // 4))
            rates[start], rates[start + 1] = y[start + 2], y[start + 3]
            rates[start + 2], rates[start + 3], _ = rigid_tangent(phase, inverse, j, y, start, added)


#: Write dy/dt of the phase into `rates`: flow(phase, y, p, rates, directions).
flow: Callable[..., None] = ByKind({Rigid: rigid_rates, Compliant: compliant_rates})


@compiled
def row_of(directions: Directions, dy: Vector, start: int, base: int) -> int:
    """The row of `directions` that goes with the variation stored from `start`; negative for one without."""
    row: int = start // base - (dy.size // base - directions.rows.shape[0])
    return row


@compiled
def number_along(directions: Directions | None, dy: Vector, start: int, size: int, place: int) -> float:
    """How the number at `place` moves with the variation stored from `start`."""
    if directions is not None:
        row = row_of(directions, dy, start, size)
        if row >= 0:
            return float(directions.rows[row, place])
    return 0.0


@compiled
def compliant_loads(
    phase: int, y: Vector, p: Compliant, dy: Vector, start: int, directions: Directions | None = None
) -> tuple[Loads, Loads]:
    """`loads` of compliant legs."""
    qdd, found, system = motion(phase, y, p)
    added = NOTHING
    if directions is not None:
        row = row_of(directions, dy, start, 8)
        if row >= 0:
            d = eq.row_as(p, directions.rows, row)
            added = along(phase, by_numbers(y, qdd, found, p), found, system.contact.roll, d)
    _, change = tangent(phase, system, jacobians(phase, y, qdd, found, p), dy, start, added)
    return found, change


@compiled
def rigid_loads(
    phase: int, y: Vector, p: Rigid, dy: Vector, start: int, directions: Directions | None = None
) -> tuple[Loads, Loads]:
    """`loads` of rigid legs: the torque alone."""
    qdd, inverse = rigid_motion(phase, y, p)
    added = (0.0, 0.0, 0.0)
    if directions is not None:
        row = row_of(directions, dy, start, 4)
        if row >= 0:
            by = eq.rigid_residual_by(y[0], y[1], y[2], y[3], qdd[0], qdd[1], p)
            added = rigid_along(phase, by, eq.row_as(p, directions.rows, row))
    j = eq.rigid_residual_jacobian(y[0], y[1], y[2], y[3], qdd[0], qdd[1], p)
    _, _, change = rigid_tangent(phase, inverse, j, dy, start, added)
    return (0.0, 0.0, qdd[2]), (0.0, 0.0, change)


#: Loads of a phase and their tangents along the variation stored in `dy` from `start`, which may go with a direction:
#: loads(phase, y, p, dy, start, directions).
loads: Callable[..., tuple[Loads, Loads]] = ByKind({Rigid: rigid_loads, Compliant: compliant_loads})


@compiled
def rigid_accelerations(phase: int, y: Vector, p: Rigid) -> tuple[Four, Loads]:
    """`accelerations` of rigid legs."""
    qdd, _ = rigid_motion(phase, y, p)
    return (qdd[0], 0.0, qdd[1], 0.0), (0.0, 0.0, qdd[2])


@compiled
def compliant_accelerations(phase: int, y: Vector, p: Compliant) -> tuple[Four, Loads]:
    """`accelerations` of compliant legs."""
    qdd, found, _ = motion(phase, y, p)
    return qdd, found


#: Accelerations of theta, L_1, psi, L_2, and loads: accelerations(phase, y, p).
accelerations: Callable[..., tuple[Four, Loads]] = ByKind({
    Rigid: rigid_accelerations, Compliant: compliant_accelerations})


@compiled
def rigid_shape(p: Rigid) -> tuple[int, float]:
    """`shape` of rigid legs."""
    return 4, p.T


@compiled
def compliant_shape(p: Compliant) -> tuple[int, float]:
    """`shape` of compliant legs."""
    return 8, np.inf


#: Length of a state, and the time at which a phase ends that no guard does, infinite where one does: shape(p).
shape: Callable[..., tuple[int, float]] = ByKind({Rigid: rigid_shape, Compliant: compliant_shape})


@compiled
def hip_rate(v: Vector, start: int, p: Kind) -> float:
    """Rate of theta + psi in the state stored from `start`, or its acceleration in such rates."""
    size, _ = shape(p)
    return float(v[start + size // 2] + v[start + size // 2 + size // 4])


@compiled
def holding_torque(phase: int, y: Vector, p: Kind) -> float:
    """Torque that would keep the rate of theta + psi, with the feet on the ground that are so in the phase."""
    _, found = accelerations(HIP_STICKS + ON_BOTH if PHASES[phase, NORMAL] == 1 else HIP_STICKS, y, p)
    return found[2]
