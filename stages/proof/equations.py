"""The biped's mechanics from its points and their velocities, for the proof alone.

Nothing here comes from the derivation that the study computes with. A point has columns, its velocity for a unit rate
of each coordinate, and a bias, its acceleration when no rate changes. Newton's law is projected on the columns
(d'Alembert), so that no term of Coriolis is written down by itself.

Coordinates are theta, L_1, psi, L_2 of docs/model.md. Numbers may be of any kind that adds, multiplies, divides and has
`sin_cos`: balls, power series of balls, and both with derivatives.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from flint import arb

from stages.biped.accuracy.scales import Scales
from stages.biped.design import Biped, Leg
from stages.ground.slope import Slope

#: A number of any kind, a vector of the plane, and one number for each coordinate.
Number = Any
Plane = tuple[Number, Number]
Numbers = Sequence[Number]
THETA, LENGTH, PSI, SWING_LENGTH = range(4)
#: Units of the design's numbers.
UNITS = {field.name: field.metadata["unit"] for field in dataclasses.fields(Biped)}


class Machine(NamedTuple):
    """The biped in a step in which `stance` stands; the hip's spring is relaxed where theta + psi is `rest`.
    `free` are the coordinates that can change."""

    stance: Any
    swing: Any
    hip_mass: Number
    weighed_hip: Number
    hip_stiffness: Number
    hip_damping: Number
    rest: Number
    gravity: Plane
    free: tuple[int, ...]

    @classmethod
    def of(cls, biped: Biped, slope: Slope, scales: Scales) -> Machine:
        """A design in scales that are powers of two: balls that hold the decimals that are written as parameters."""

        def ball(value: float, unit: str) -> Number:
            return arb(repr(float(value))) / arb(scales.size(unit))

        stance, swing = (Leg(**{name: ball(value, UNITS[name])
                                for name, value in dataclasses.asdict(biped.leg(i)).items()}) for i in (0, 1))
        angle, pull = ball(slope.slope_deg, "deg") * arb.pi() / 180, ball(slope.gravity, "m/s^2")
        spring, damper = ball(biped.hip_stiffness, "N m/rad"), ball(biped.hip_damping, "N m s/rad")
        return cls(stance, swing, ball(biped.hip_mass, "kg"), ball(biped.weighed_hip, "kg"), spring, damper,
                   -ball(biped.hip_rest_angle, "rad"), (pull * angle.sin(), -pull * angle.cos()),
                   (THETA, PSI) if biped.legs == "rigid" else (THETA, LENGTH, PSI, SWING_LENGTH))  # fmt: skip

    @property
    def exchanged(self) -> Machine:
        """The biped in its next step."""
        return self._replace(stance=self.swing, swing=self.stance, rest=-self.rest)

    def full(self, state: Numbers) -> tuple[list[Number], list[Number]]:
        """All four coordinates and rates of a state; rigid legs have their natural lengths."""
        if LENGTH in self.free:
            return list(state[:4]), list(state[4:])
        theta, psi, turn, spin = state
        return [theta, self.stance.leg_length, psi, self.swing.leg_length], [turn, 0, spin, 0]


class Point(NamedTuple):
    """A mass, what it weighs in masses, its columns by coordinate, and its bias."""

    mass: Number
    weight: Number
    columns: dict[int, Plane]
    bias: Plane


def inner(pairs: Iterable[tuple[Number, Number]]) -> Number:
    """The sum of products."""
    return sum((one * other for one, other in pairs), 0)


def along(*terms: tuple[Number, Plane]) -> Plane:
    """The sum of sizes times directions."""
    return inner((size, way[0]) for size, way in terms), inner((size, way[1]) for size, way in terms)


def kinematics(machine: Machine, q: Numbers, v: Numbers) -> tuple[list[Point], Point]:
    """The points at coordinates q (4,) with rates v (4,): hip, what belongs to the legs by twos, stance leg first, and
    the swing foot's centre. How fast a leg turns is counted as a velocity of its inertia.
    """
    stance, swing = machine.stance, machine.swing
    (sine, cosine), (swing_sine, swing_cosine) = q[THETA].sin_cos(), q[PSI].sin_cos()
    # Along each leg, from the stance foot to the hip and on to the swing foot, and across: the first's derivative.
    ways = {THETA: ((sine, cosine), (cosine, -sine)), PSI: ((swing_sine, -swing_cosine), (swing_cosine, swing_sine))}
    turns = {angle: v[angle] * v[angle] for angle in ways}

    def on_leg(base: Point, angle: int, mass: Number, distance: Number, offset: Number, slides: int | None) -> Point:
        """A point that a leg carries from a base on its line; where the leg's length `slides` it goes along."""
        way, across = ways[angle]
        below = base.columns.get(angle, (0, 0))
        columns = {**base.columns, angle: along((1, below), (distance, across), (-offset, way))}
        bias = along((1, base.bias), (-(turns[angle] * distance), way), (-(turns[angle] * offset), across))
        if slides in machine.free:
            columns[slides] = way
            bias = along((1, bias), (2 * (v[slides] * v[angle]), across))
        return Point(mass, mass, columns, bias)

    sole = Point(0, 0, {THETA: (stance.foot_radius, 0)}, (0, 0))
    hip = on_leg(sole, THETA, machine.hip_mass, q[LENGTH] - stance.foot_radius, 0, LENGTH)
    points = [
        hip._replace(weight=machine.weighed_hip),
        on_leg(sole, THETA, stance.foot_mass, stance.foot_com - stance.foot_radius, stance.foot_offset, None),
        on_leg(hip, PSI, swing.foot_mass, q[SWING_LENGTH] - swing.foot_com, swing.foot_offset, SWING_LENGTH),
        Point(stance.leg_inertia + stance.frame_inertia, 0, {THETA: (1, 0)}, (0, 0)),
        Point(swing.leg_inertia + swing.frame_inertia, 0, {PSI: (-1, 0)}, (0, 0)),
    ]
    if not (stance.frame_mass.is_zero() and swing.frame_mass.is_zero()):
        points += [on_leg(hip, THETA, stance.frame_mass, -stance.frame_com, stance.frame_offset, None),
                   on_leg(hip, PSI, swing.frame_mass, swing.frame_com, swing.frame_offset, None)]  # fmt: skip
    return points, on_leg(hip, PSI, 0, q[SWING_LENGTH] - swing.foot_radius, 0, SWING_LENGTH)


def projected(machine: Machine, points: Sequence[Point], vectors: Sequence[Plane]) -> list[Number]:
    """The sum of vectors (one for each point) times the points' columns, for each free coordinate."""
    return [inner(pair for point, vector in zip(points, vectors) if i in point.columns
                  for pair in zip(point.columns[i], vector)) for i in machine.free]  # fmt: skip


def moved(machine: Machine, points: Sequence[Point], push: Numbers, other_foot: tuple[Point, Plane] | None
          ) -> tuple[list[Number], Number]:  # fmt: skip
    """x with mass x = push, and 0. With the other foot's centre and a change of its height and slip, these hold too, by
    a force on that foot, whose normal part is the second number.
    """
    matrix, size = [], len(machine.free)
    for i in machine.free:
        having = [point for point in points if i in point.columns]
        matrix.append(projected(machine, having, [along((point.mass, point.columns[i])) for point in having]))
    if other_foot is None:
        return solved(matrix, push), 0
    centre, change = other_foot
    slip, rise = ([centre.columns[i][part] for i in machine.free] for part in (0, 1))
    place = machine.free.index(PSI)
    slip[place] = slip[place] + machine.swing.foot_radius
    bordered = [[*row, -a, -b] for row, a, b in zip(matrix, rise, slip)]
    found = solved([*bordered, [*rise, 0, 0], [*slip, 0, 0]], [*push, *change])
    return found[:size], found[size]


def solved(matrix: Sequence[Numbers], push: Numbers) -> list[Number]:
    """The solution of a system by elimination without pivots: positive definite, or bordered by constraints."""
    size, rows = len(matrix), [[*row, each] for row, each in zip(matrix, push)]
    for i in range(size):
        pivot = 1 / rows[i][i]
        rows[i][i + 1 :] = [each * pivot for each in rows[i][i + 1 :]]
        for row in rows[i + 1 :]:
            row[i + 1 :] = [below - row[i] * above for below, above in zip(row[i + 1 :], rows[i][i + 1 :])]
    found: list[Number] = []
    for i in reversed(range(size)):
        found.insert(0, rows[i][size] - inner(zip(rows[i][i + 1 : size], found)))
    return found


def motion(machine: Machine, state: Numbers, both: bool) -> tuple[list[Number], Number, Number]:
    """Accelerations of the free coordinates at a state (q, v) in double (`both`) or single stance, and normal forces of
    the ground on the stance foot and on the other.
    """
    q, v = machine.full(state)
    points, centre = kinematics(machine, q, v)
    push = projected(machine, points, [along((one.weight, machine.gravity), (-one.mass, one.bias)) for one in points])
    torque = machine.hip_stiffness * (q[THETA] + q[PSI] - machine.rest) + machine.hip_damping * (v[THETA] + v[PSI])
    for place, i in enumerate(machine.free):
        if i in (THETA, PSI):
            push[place] = push[place] - torque
        else:
            leg = machine.stance if i == LENGTH else machine.swing
            push[place] = push[place] - leg.stiffness * (q[i] - leg.leg_length) - leg.damping * v[i]
    kept = (centre, (-centre.bias[1], -centre.bias[0])) if both else None
    accelerations, other_force = moved(machine, points, push, kept)
    rates = dict(zip(machine.free, accelerations))
    rises = [one.bias[1] + inner((way[1], rates[i]) for i, way in one.columns.items()) for one in points]
    lifted = inner((one.mass, rise) for one, rise in zip(points, rises))
    weight = inner((one.weight, machine.gravity[1]) for one in points)
    return accelerations, lifted - weight - other_force, other_force


def strike(machine: Machine, state: Numbers) -> list[Number]:
    """The state after heel strike, legs renamed.

    The new stance foot comes to rest and rolls: momenta along the columns of all motions that keep it rolling are kept.
    Compliant legs' other foot is met by the ground as well and rolls on.
    """
    after, (q, v) = machine.exchanged, machine.full(state)
    before, _ = kinematics(machine, q, v)
    renamed = [-q[PSI], q[SWING_LENGTH], -q[THETA], q[LENGTH]]
    points, centre = kinematics(after, renamed, v)
    velocities = [along(*((v[i], column) for i, column in before[old].columns.items()))
                  for old in (0, 2, 1, 4, 3, 6, 5)[: len(points)]]  # fmt: skip
    momenta = projected(after, points, [along((one.mass, each)) for one, each in zip(points, velocities)])
    rates, _ = moved(after, points, momenta, (centre, (0, 0)) if LENGTH in machine.free else None)
    return [*(renamed[i] for i in machine.free), *rates]


def foot(machine: Machine, state: Numbers) -> tuple[Number, Number, Number]:
    """The swing foot's height above ground, how far it is ahead of the other, and how far it would step."""
    q, _ = machine.full(state)
    (sine, cosine), (swing_sine, swing_cosine) = q[THETA].sin_cos(), q[PSI].sin_cos()
    radius, swing_radius = machine.stance.foot_radius, machine.swing.foot_radius
    stance, swing = q[LENGTH] - radius, q[SWING_LENGTH] - swing_radius
    ahead = stance * sine + swing * swing_sine
    height = stance * cosine - swing * swing_cosine + (radius - swing_radius)
    return height, ahead, ahead + radius * q[THETA] + swing_radius * q[PSI]
