"""The twin as other programs take it: links, joints, feet, sensors, blocks, start, and where the ground is level.

It starts on the constraint model's gait, on blocks laid for its steps.

All frames of links stand at the middle of the hip axis while the machine stands straight: x forward, y up, z along the
hip axis. So the joints' values are the coordinates of `stages.twin.machine.tree`, in any format.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stages.analytic.gait.gait_search import describe, find_gait
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.twin.exports.seen import shown_parts
from stages.twin.exports.solids import BLOCK_HEIGHT
from stages.twin.machine.bill import Body, join
from stages.twin.machine.contact import HINGE, PITCH, ROLL, SLIDE, YAW, X, Y, Z
from stages.twin.machine.machine import LEGS, Machine, build
from stages.twin.machine.parts import FRAMES, Part
from stages.twin.parameters import Parameters, Settings
from stages.twin.ramp import Ramp, laid
from stages.twin.walking.simulate import Start, rolling_start

#: Programs want a body that moves to have mass and moments: at least this share of the machine's, and of its mass at a
#: leg's length; no moment below the last, which MuJoCo takes for none [kg m^2]; none above the sum of the others.
LEAST, LEAST_MOMENT = 1e-12, 1e-13
#: Radius of a foot that is a point, as a share of the leg: no shape that touches may be smaller.
POINT = 1e-3
FORWARD, UP, ACROSS = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
#: Names of the coordinates, in order.
NAMES = (
    "x", "y", "z", "yaw", "roll", "pitch", "inner left spring", "inner right spring", "hinge", "outer left spring",
    "outer right spring",
)  # fmt: skip


@dataclass(frozen=True)
class Joint:
    """A joint that is a coordinate: its row, whether it turns or slides, its axis, its spring [N/m] and damper."""

    row: int
    turns: bool
    axis: tuple[float, float, float]
    stiffness: float = 0.0
    damping: float = 0.0

    @property
    def name(self) -> str:
        """Name of the coordinate."""
        return NAMES[self.row]


@dataclass(frozen=True)
class Link:
    """A rigid body on its parent (-1: the ground), moved against it by its joints, one after the other.

    `parts` are its pieces that are seen, each with its side of z, 1 or -1; `feet` are the legs whose feet it carries,
    `sites` its sensors by name and place [m].
    """

    name: str
    parent: int
    joints: tuple[Joint, ...]
    body: Body
    parts: tuple[tuple[Part, float], ...]
    feet: tuple[int, ...] = ()
    sites: tuple[tuple[str, tuple[float, ...]], ...] = ()


@dataclass(frozen=True)
class Block:
    """A stepping block: its set, counted from 0, and the middle of its top [m]."""

    number: int
    pair: int
    middle: tuple[float, float, float]


@dataclass(frozen=True)
class Exported:
    """Everything that a format may carry; `seen` are the parts to draw."""

    machine: Machine
    settings: Settings
    slope: Slope
    contact: ContactLaw
    start: Start
    ramp: Ramp
    seen: tuple[Part, ...] = ()

    @property
    def links(self) -> tuple[Link, ...]:
        """Inner frame, its feet, outer frame, its feet; on rigid legs feet are part of their frame."""
        machine = self.machine
        base = tuple(
            Joint(row, turns, axis)
            for row, turns, axis in (
                (X, False, FORWARD), (Y, False, UP), (Z, False, ACROSS), (YAW, True, UP), (ROLL, True, FORWARD),
                (PITCH, True, ACROSS),
            )
        )  # fmt: skip
        hinge = (Joint(HINGE, True, ACROSS, damping=machine.bearing_friction),)
        hip = ("hip sensor", self.settings.hip_socket)
        socket = self.settings.foot_sensor(machine.drawn_foot_com)
        foot = ("foot sensor", socket)
        sensed = 0 if socket[2] > 0.0 else 1
        found: list[Link] = []
        for pair, joints in enumerate((base, hinge)):
            frame, parent = len(found), -1 if pair == 0 else 0
            legs = (2 * pair, 2 * pair + 1)
            bodies, parts = machine.bodies[3 * pair : 3 * pair + 3], [self._parts(pair, leg) for leg in (None, *legs)]
            bodies = (join(bodies),) if machine.rigid else bodies
            bodies = tuple(self._moving(body) for body in bodies)
            sites = (hip,) if pair == 0 else ()
            if machine.rigid:
                every = tuple(piece for own in parts for piece in own)
                both = (*sites, foot) if pair == 0 else ()
                found.append(Link(f"{FRAMES[pair].replace('_', ' ')}", parent, joints, bodies[0], every, legs, both))
                continue
            found.append(Link(FRAMES[pair].replace("_", " "), parent, joints, bodies[0], parts[0], (), sites))
            for leg, body, own in zip(legs, bodies[1:], parts[1:], strict=True):
                spring = Joint(SLIDE[leg], False, UP, float(machine.stiffness[leg]), float(machine.damping[leg]))
                here = (foot,) if leg == sensed else ()
                found.append(Link(f"{LEGS[leg]} foot", frame, (spring,), body, own, (leg,), here))
        return tuple(found)

    def _parts(self, pair: int, leg: int | None) -> tuple[tuple[Part, float], ...]:
        """What is seen of a pair's frame, or of one of its feet."""
        group = f"{('inner', 'outer')[pair]}_{'frame' if leg is None else 'foot'}"
        pieces = [(part, side) for part in self.seen if part.group == group
                  for side in ((1.0, -1.0) if part.pieces == 2 else (1.0,))]  # fmt: skip
        if leg is None:
            return tuple(pieces)
        wanted = 1.0 if leg % 2 == 0 else -1.0
        return tuple((part, side) for part, side in pieces if side * part.position[2] * wanted > 0.0)

    def _moving(self, body: Body) -> Body:
        """A body with the least mass and moments that programs take: a point mass has none, an empty frame neither."""
        machine = self.machine
        moment = max(LEAST * machine.mass * machine.drawn_length**2, LEAST_MOMENT)
        low, middle, high = map(float, np.linalg.eigvalsh(body.inertia))
        missing = max(0.0, moment - low, (1.0 + LEAST) * high - low - middle)
        mass = max(body.mass, LEAST * machine.mass)
        return Body(mass, body.centre, body.inertia + missing * np.eye(3)) if missing or mass > body.mass else body

    def foot(self, leg: int) -> tuple[tuple[float, float, float], float]:
        """Middle [m] of a foot's cylinder in its link, and its radius [m]; its axis is z."""
        machine = self.machine
        radius = max(float(machine.radius[leg]), POINT * machine.drawn_length)
        return (0.0, radius - float(machine.length[leg]), float(machine.lane[leg])), radius

    def blocks(self) -> Iterator[Block]:
        """All stepping blocks, set by set."""
        for number in range(self.ramp.sets):
            pair = number % 2
            for side in (1.0, -1.0):
                yield Block(number, pair, (number * self.ramp.step, 0.0, side * self.ramp.tracks[pair]))

    @property
    def block_size(self) -> tuple[float, float, float]:
        """Length, height and width of a block [m]."""
        return self.ramp.lanes[0].length, BLOCK_HEIGHT, self.ramp.width

    def coordinates(self) -> list[tuple[Joint, float, float]]:
        """Every joint with its value and rate at the start."""
        q, v = self.start.position, self.start.velocity
        joints = [joint for link in self.links for joint in link.joints]
        return [(joint, float(q[joint.row]) + 0.0, float(v[joint.row]) + 0.0) for joint in joints]


#: Of the gait; its step from mid-stance on is all that is taken.
TOLERANCE = 1e-9
SAMPLES_A_SECOND = 1000.0


def exported(parameters: Parameters) -> Exported:
    """The twin of these parameters as it starts in its stage. Raises NoGait, BlocksDoNotFit."""
    biped, slope, settings = parameters.biped, parameters.slope, parameters.settings
    walker, point = find_gait(biped, slope, TOLERANCE, None)
    walk, upright = walk_from_mid_stance(walker, point.z, 1, TOLERANCE, SAMPLES_A_SECOND)
    machine = build(biped, settings)
    start = rolling_start(machine, parameters.contact, upright, walk.standing_force)
    ramp = laid(settings, describe(walker, point).step_length_m)
    return Exported(machine, settings, slope, parameters.contact, start, ramp, shown_parts(settings, biped))
