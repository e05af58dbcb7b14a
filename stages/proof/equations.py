"""The biped's mechanics from its points and their velocities, for the proof alone.

Nothing here comes from the derivation that the study computes with. A point has columns, its velocity for a unit rate
of each coordinate, and a bias, its acceleration when no rate changes. Newton's law is projected on the columns
(d'Alembert), so that no term of Coriolis is written down by itself.

Coordinates are theta, L_1, psi, L_2 of docs/model.md. Numbers may be of any kind that adds, multiplies, divides and has
`sin_cos`: balls, power series of balls, and both with derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

#: A number of any kind, a vector of the plane, and one number for each coordinate.
Number = Any
Plane = tuple[Number, Number]
Numbers = Sequence[Number]
THETA, LENGTH, PSI, SWING_LENGTH = range(4)


class Leg(NamedTuple):
    """The numbers of one leg under their symbols in docs/model.md, in any units that fit together."""

    m: Number
    L_nat: Number
    r: Number
    l: Number  # noqa: E741 - the symbol of Table 1
    k: Number
    b: Number
    I: Number  # noqa: E741
    e: Number
    m_f: Number
    l_f: Number
    e_f: Number
    I_f: Number


class Machine(NamedTuple):
    """The biped in a step in which `stance` stands; the hip's spring is relaxed where theta + psi is `rest`."""

    M: Number
    weighed: Number
    stance: Leg
    swing: Leg
    hip_k: Number
    hip_b: Number
    rest: Number
    gravity: Plane
    rigid: bool
    alike: bool

    @property
    def exchanged(self) -> Machine:
        """The biped in its next step."""
        return self._replace(stance=self.swing, swing=self.stance, rest=-self.rest)

    @property
    def free(self) -> tuple[int, ...]:
        """Coordinates that can change."""
        return (THETA, PSI) if self.rigid else (THETA, LENGTH, PSI, SWING_LENGTH)


class Point(NamedTuple):
    """A mass, what it weighs in masses, its columns by coordinate, and its bias."""

    mass: Number
    weight: Number
    columns: dict[int, Plane]
    bias: Plane


class Kinematics(NamedTuple):
    """All points: hip, foot of the stance leg, of the swing leg, then their frames; and the swing foot's centre."""

    points: tuple[Point, ...]
    centre: Point


class Motion(NamedTuple):
    """Accelerations of the free coordinates, and normal forces of the ground on the stance and on the other foot."""

    accelerations: list[Number]
    stance_force: Number
    trailing_force: Number


def along(size: Number, direction: Plane, other: Number = 0, across: Plane = (0, 0)) -> Plane:
    """size * direction + other * across."""
    if is_nothing(other):
        return size * direction[0], size * direction[1]
    return size * direction[0] + other * across[0], size * direction[1] + other * across[1]


def is_nothing(number: Number) -> bool:
    """Whether a number is a zero without a doubt, so that its term need not be formed."""
    return bool(number.is_zero()) if hasattr(number, "is_zero") else number == 0


def plus(*vectors: Plane) -> Plane:
    """The sum of vectors."""
    first, *others = vectors
    for one in others:
        first = first[0] + one[0], first[1] + one[1]
    return first


def dot(one: Plane, other: Plane) -> Number:
    """The scalar product."""
    return one[0] * other[0] + one[1] * other[1]


def full(machine: Machine, numbers: Numbers, held: bool) -> list[Number]:
    """All four coordinates (`held`: rigid legs have their natural lengths), or all four rates."""
    if not machine.rigid:
        return list(numbers)
    lengths = (machine.stance.L_nat, machine.swing.L_nat) if held else (0, 0)
    return [numbers[0], lengths[0], numbers[1], lengths[1]]


def kinematics(machine: Machine, q: Numbers, v: Numbers) -> Kinematics:
    """The points at coordinates q (4,) with rates v (4,)."""
    stance, swing = machine.stance, machine.swing
    sine, cosine = q[THETA].sin_cos()
    up, forth = (sine, cosine), (cosine, -sine)  # from the stance foot to the hip, and across; d up = forth dtheta
    sine, cosine = q[PSI].sin_cos()
    down, ahead = (sine, -cosine), (cosine, sine)  # from the hip to the swing foot, and across; d down = ahead dpsi
    turn, spin = v[THETA] * v[THETA], v[PSI] * v[PSI]
    rolling: Plane = (stance.r, 0)

    def kept(columns: dict[int, Plane]) -> dict[int, Plane]:
        return {place: columns[place] for place in machine.free if place in columns}

    height = q[LENGTH] - stance.r
    hip = {THETA: plus(along(height, forth), rolling), LENGTH: up}
    hip_bias = along(-(height * turn), up)
    if not machine.rigid:
        hip_bias = plus(hip_bias, along(2 * (v[LENGTH] * v[THETA]), forth))
    lower = stance.l - stance.r
    foot = {THETA: plus(along(lower, forth, -stance.e, up), rolling)}
    points = [
        Point(machine.M, machine.weighed, kept(hip), hip_bias),
        Point(stance.m, stance.m, foot, along(-(turn * lower), up, -(turn * stance.e), forth)),
    ]

    def on_swing_leg(mass: Number, distance: Number, offset: Number, slides: bool) -> Point:
        columns = {**hip, PSI: along(distance, ahead, -offset, down)}
        bias = plus(hip_bias, along(-(spin * distance), down, -(spin * offset), ahead))
        if slides and not machine.rigid:
            columns[SWING_LENGTH] = down
            bias = plus(bias, along(2 * (v[SWING_LENGTH] * v[PSI]), ahead))
        return Point(mass, mass, kept(columns), bias)

    points.append(on_swing_leg(swing.m, q[SWING_LENGTH] - swing.l, swing.e, True))
    if not (is_nothing(stance.m_f) and is_nothing(swing.m_f)):
        frame = {**hip, THETA: plus(hip[THETA], along(-stance.l_f, forth, -stance.e_f, up))}
        bias = plus(hip_bias, along(turn * stance.l_f, up, -(turn * stance.e_f), forth))
        points += [Point(stance.m_f, stance.m_f, kept(frame), bias),
                   on_swing_leg(swing.m_f, swing.l_f, swing.e_f, False)]  # fmt: skip
    return Kinematics(tuple(points), on_swing_leg(0, q[SWING_LENGTH] - swing.r, 0 * swing.e, True))


def mass_matrix(machine: Machine, points: Sequence[Point]) -> list[list[Number]]:
    """The sum of masses times products of columns, and the legs' inertias, for the free coordinates."""
    spins = {THETA: machine.stance.I + machine.stance.I_f, PSI: machine.swing.I + machine.swing.I_f}
    matrix: list[list[Number]] = [[0] * len(machine.free) for _ in machine.free]
    for row, i in enumerate(machine.free):
        for column, j in enumerate(machine.free[: row + 1]):
            entry = spins.get(i, 0) if i == j else 0
            for point in points:
                if i in point.columns and j in point.columns:
                    entry = entry + point.mass * dot(point.columns[i], point.columns[j])
            matrix[row][column] = matrix[column][row] = entry
    return matrix


def solved(matrix: Sequence[Numbers], columns: Sequence[Numbers]) -> list[list[Number]]:
    """Solutions of a positive definite system for several right-hand sides, by elimination without pivots."""
    size = len(matrix)
    rows = [[*matrix[i], *(column[i] for column in columns)] for i in range(size)]
    for i in range(size):
        pivot = 1 / rows[i][i]
        for j in range(i + 1, size):
            factor = rows[j][i] * pivot
            rows[j][i + 1 :] = [below - factor * above for below, above in zip(rows[j][i + 1 :], rows[i][i + 1 :])]
        rows[i][i] = pivot
    found: list[list[Number]] = [[0] * size for _ in columns]
    for i in reversed(range(size)):
        for place, solution in enumerate(found):
            entry = rows[i][size + place]
            for j in range(i + 1, size):
                entry = entry - rows[i][j] * solution[j]
            solution[i] = entry * rows[i][i]
    return found


def inner(one: Numbers, other: Numbers) -> Number:
    """The sum of products."""
    total = one[0] * other[0]
    for a, b in zip(one[1:], other[1:]):
        total = total + a * b
    return total


def contact_columns(machine: Machine, centre: Point) -> tuple[list[Number], list[Number]]:
    """Rates of height and of slip of the other foot, for a unit rate of each free coordinate."""
    columns = [centre.columns[i] for i in machine.free]
    slip = [column[0] + machine.swing.r if i == PSI else column[0] for i, column in zip(machine.free, columns)]
    return [column[1] for column in columns], slip


def held(
    machine: Machine, mass: Sequence[Numbers], push: Numbers, centre: Point, targets: Plane
) -> tuple[list[Number], Number]:
    """x with mass x = push + a force at the other foot's contact, that changes height and slip by `targets`; and its
    normal force.
    """
    rise, slip = contact_columns(machine, centre)
    free, by_rise, by_slip = solved(mass, (push, rise, slip))
    a, b, d = inner(rise, by_rise), inner(rise, by_slip), inner(slip, by_slip)
    first, second = targets[0] - inner(rise, free), targets[1] - inner(slip, free)
    whole = 1 / (a * d - b * b)
    normal, friction = (d * first - b * second) * whole, (a * second - b * first) * whole
    return [x + normal * y + friction * z for x, y, z in zip(free, by_rise, by_slip)], normal


def motion(machine: Machine, state: Numbers, both: bool, forces: bool = True) -> Motion:
    """The motion in double (`both`) or single stance at a state (q, v); forces are None where they are not wanted."""
    size = len(machine.free)
    q, v = full(machine, state[:size], True), full(machine, state[size:], False)
    points, centre = kinematics(machine, q, v)
    gravity_x, gravity_y = machine.gravity
    push = []
    for i in machine.free:
        entry: Number = 0
        for point in points:
            if i in point.columns:
                x, y = point.columns[i]
                bias = point.bias
                entry = entry + (x * (point.weight * gravity_x - point.mass * bias[0])
                                 + y * (point.weight * gravity_y - point.mass * bias[1]))  # fmt: skip
        push.append(entry)
    if not machine.rigid:
        for place, leg in ((LENGTH, machine.stance), (SWING_LENGTH, machine.swing)):
            push[place] = push[place] - leg.k * (q[place] - leg.L_nat) - leg.b * v[place]
    if not (is_nothing(machine.hip_k) and is_nothing(machine.hip_b)):
        torque = machine.hip_k * (q[THETA] + q[PSI] - machine.rest) + machine.hip_b * (v[THETA] + v[PSI])
        for i in (THETA, PSI):
            push[machine.free.index(i)] = push[machine.free.index(i)] - torque
    mass = mass_matrix(machine, points)
    normal: Number = None
    if both:
        found, normal = held(machine, mass, push, centre, (-centre.bias[1], -centre.bias[0]))
    else:
        found = solved(mass, (push,))[0]
    if not forces:
        return Motion(found, None, normal)
    ground: Number = 0
    for point in points:
        rise = point.bias[1]
        for i, acceleration in zip(machine.free, found):
            if i in point.columns:
                rise = rise + point.columns[i][1] * acceleration
        ground = ground + point.mass * rise - point.weight * gravity_y
    return Motion(found, ground if normal is None else ground - normal, normal)


def strike(machine: Machine, state: Numbers) -> list[Number]:
    """The state after heel strike, legs renamed.

    The new stance foot comes to rest and rolls: momenta along the columns of all motions that keep it rolling are kept.
    Compliant legs' other foot is met by the ground as well and rolls on.
    """
    size = len(machine.free)
    after = machine.exchanged
    q, v = full(machine, state[:size], True), full(machine, state[size:], False)
    before = kinematics(machine, q, v).points
    renamed = [-q[PSI], q[SWING_LENGTH], -q[THETA], q[LENGTH]]
    points, centre = kinematics(after, renamed, v)
    was = dict(enumerate((0, 2, 1, 4, 3)))
    momenta = []
    for i in after.free:
        entry: Number = 0
        if i == THETA:
            entry = -(v[PSI] * (after.stance.I + after.stance.I_f))
        if i == PSI:
            entry = -(v[THETA] * (after.swing.I + after.swing.I_f))
        for place, point in enumerate(points):
            if i in point.columns:
                old = before[was[place]].columns
                velocity = plus(*(along(v[j], column) for j, column in old.items()))
                entry = entry + point.mass * dot(point.columns[i], velocity)
        momenta.append(entry)
    mass = mass_matrix(after, points)
    rates = solved(mass, (momenta,))[0] if machine.rigid else held(after, mass, momenta, centre, (0, 0))[0]
    return [renamed[i] for i in machine.free] + rates


def foot(machine: Machine, state: Numbers) -> tuple[Number, Number, Number]:
    """The swing foot's height above ground, how far it is ahead of the other, and how far it would step."""
    q = full(machine, state[: len(machine.free)], True)
    (sine, cosine), (swing_sine, swing_cosine) = q[THETA].sin_cos(), q[PSI].sin_cos()
    stance, swing = q[LENGTH] - machine.stance.r, q[SWING_LENGTH] - machine.swing.r
    ahead = stance * sine + swing * swing_sine
    height = stance * cosine - swing * swing_cosine + (machine.stance.r - machine.swing.r)
    return height, ahead, ahead + machine.stance.r * q[THETA] + machine.swing.r * q[PSI]
