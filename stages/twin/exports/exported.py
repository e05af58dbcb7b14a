"""The twin as other programs take it: links, joints, feet, sensors, blocks, start, and where the ground is level.

It starts on the constraint model's gait, on blocks laid for its steps.

All frames of links stand at the middle of the hip axis while the machine stands straight: x forward, y up, z along the
hip axis. So the joints' values are the coordinates of `stages.twin.machine.tree`, in any format.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias
from xml.etree import ElementTree

import numpy as np

from stages.analytic.gait.gait_search import describe, find_gait
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.biped.design import BeyondModel
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.twin.exports.solids import BLOCK_HEIGHT, piece_place, shown_parts
from stages.twin.machine.contact import HINGE, PITCH, ROLL, SLIDE, YAW, X, Y, Z
from stages.twin.machine.machine import LEGS, Body, Machine, join
from stages.twin.machine.parts import FEET, FRAMES, Part
from stages.twin.machine.projection import machine_of
from stages.twin.parameters import Parameters, Settings
from stages.twin.ramp import Ramp, laid
from stages.twin.walking.simulate import Start, rolling_start

#: Programs want a body that moves to have mass and moments: at least this share of the machine's, and of its mass at a
#: leg's length; no moment below the last, which MuJoCo takes for none [kg m^2]; none above the sum of the others.
LEAST, LEAST_MOMENT = 1e-12, 1e-13
#: Radius of a foot that is a point, as a share of the leg: no shape that touches may be smaller.
POINT = 1e-3
FORWARD, UP, ACROSS = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
#: Names of the coordinates, in order; the axis of each, and those that turn about it.
NAMES = (
    "x", "y", "z", "yaw", "roll", "pitch", "inner left spring", "inner right spring", "hinge", "outer left spring",
    "outer right spring",
)  # fmt: skip
AXES = (FORWARD, UP, ACROSS, UP, FORWARD, ACROSS, UP, UP, ACROSS, UP, UP)
TURNING = (YAW, ROLL, PITCH, HINGE)
#: A right angle [rad], and the turns that bring z to an axis, as text.
QUARTER = "1.5707963267948966"
TURNS = {"x": f"0 {QUARTER} 0", "y": f"{QUARTER} 0 0", "z": "0 0 0"}
#: Colours of formats that know no materials.
COLOURS = {"inner": "0 0.62 0.45 1", "outer": "0.84 0.37 0 1", "block": "0.55 0.43 0.27 1"}
#: Thickness of the board under the blocks [m].
BOARD = 0.01


@dataclass(frozen=True)
class Joint:
    """A joint that is a coordinate: its row, spring, damper and Coulomb friction [SI], where the spring rests."""

    row: int
    stiffness: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    rest: float = 0.0

    @property
    def name(self) -> str:
        """Name of the coordinate."""
        return NAMES[self.row]

    @property
    def turns(self) -> bool:
        """Whether it turns or slides."""
        return self.row in TURNING

    @property
    def axis(self) -> tuple[float, float, float]:
        """Its axis."""
        return AXES[self.row]


@dataclass(frozen=True)
class Shape:
    """A box or cylinder by its `sizes` [m], in the axes of its link; a cylinder lies along z before its `turn`."""

    name: str
    kind: str
    sizes: dict[str, Any]
    place: tuple[float, float, float]
    turn: str = ""
    colour: str = ""


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

    def shapes(self) -> Iterator[Shape]:
        """What is seen of its pieces: a tube is drawn full, a rim as its whole wheel. A point is not seen."""
        for number, (part, side) in enumerate(self.parts):
            if part.shape == "point":
                continue
            kind, axis, sizes = "box", "z", {"size": part.size}
            if part.shape != "box":
                length = part.size[2] if part.shape == "arc" else part.size[-1]
                kind, axis, sizes = "cylinder", part.axis, {"radius": part.size[:1], "length": (length,)}
            place, colour = piece_place(part, side), part.group.split("_")[0]
            yield Shape(f"{number} {part.name}", kind, sizes, place, TURNS[axis], colour)


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
    def hinge(self) -> Joint:
        """The joint of both pairs at the hip."""
        machine = self.machine
        return Joint(HINGE, machine.hip_stiffness, machine.bearing_friction, machine.hip_friction,
                     0.0 - machine.hip_rest_angle)  # fmt: skip

    @property
    def slides(self) -> list[Joint]:
        """The joints of the legs' springs, in the order of `LEGS`; rigid legs have none."""
        return [joint for link in self.links for joint in link.joints if joint.row in SLIDE]

    @cached_property
    def links(self) -> tuple[Link, ...]:
        """Inner frame, its feet, outer frame, its feet; on rigid legs feet are part of their frame."""
        machine, found = self.machine, list[Link]()
        base = [Joint(row) for row in (X, Y, Z, YAW, ROLL, PITCH)]
        socket = self.settings.foot_sensor(machine.drawn_foot_com)
        sensors = {FRAMES[0]: ("hip sensor", self.settings.hip_socket),
                   LEGS[0 if socket[2] > 0.0 else 1]: ("foot sensor", socket)}  # fmt: skip
        for pair, joints in enumerate((base, [self.hinge])):
            legs, frame = (2 * pair, 2 * pair + 1), len(found)
            bodies = machine.bodies[3 * pair : 3 * pair + 3]
            parts = [self._parts(pair, leg) for leg in (None, *legs)]
            carriers = FRAMES[pair], *(LEGS[leg] for leg in legs)
            sites = [(sensors[name],) if name in sensors else () for name in carriers]
            if machine.rigid:
                bodies, parts, sites = (join(bodies),), [sum(parts, ())], [sum(sites, ())]
            name, carried = FRAMES[pair].replace("_", " "), legs if machine.rigid else ()
            body = self._moving(bodies[0])
            found.append(Link(name, pair - 1, tuple(joints), body, parts[0], carried, sites[0]))
            for leg, body, own, site in zip(legs, bodies[1:], parts[1:], sites[1:]):
                spring = Joint(SLIDE[leg], float(machine.stiffness[leg]), float(machine.damping[leg]))
                found.append(Link(f"{LEGS[leg]} foot", frame, (spring,), self._moving(body), own, (leg,), site))
        return tuple(found)

    def _parts(self, pair: int, leg: int | None) -> tuple[tuple[Part, float], ...]:
        """What is seen of a pair's frame, or of one of its feet."""
        group, wanted = (FRAMES[pair], 0.0) if leg is None else (FEET[pair], 1.0 - 2.0 * (leg % 2))
        pieces = [(part, side) for part in self.seen if part.group == group
                  for side in ((1.0, -1.0) if part.pieces == 2 else (1.0,))]  # fmt: skip
        return tuple((part, side) for part, side in pieces if leg is None or side * part.position[2] * wanted > 0.0)

    def chain(self, link: Link, ground: str) -> Iterator[tuple[Joint, str, str]]:
        """A link's joints with the names of what each joins, where no joint has more than one coordinate."""
        parent = ground if link.parent < 0 else self.links[link.parent].name
        for joint in link.joints:
            child = link.name if joint is link.joints[-1] else f"after {joint.name}"
            yield joint, parent, child
            parent = child

    def _moving(self, body: Body) -> Body:
        """A body with the least mass and moments that programs take: a point mass has none, an empty frame neither."""
        machine = self.machine
        moment = max(LEAST * machine.mass * machine.drawn_lengths[0] ** 2, LEAST_MOMENT)
        low, middle, high = map(float, np.linalg.eigvalsh(body.inertia))
        missing = max(0.0, moment - low, (1.0 + LEAST) * high - low - middle)
        mass = max(body.mass, LEAST * machine.mass)
        return Body(mass, body.centre, body.inertia + missing * np.eye(3)) if missing or mass > body.mass else body

    def foot(self, leg: int) -> Shape:
        """A foot's cylinder in its link; its axis is z."""
        machine = self.machine
        radius = max(float(machine.radius[leg]), POINT * machine.drawn_lengths[0])
        place = (0.0, radius - float(machine.length[leg]), float(machine.lane[leg]))
        return Shape(f"{LEGS[leg]} foot", "cylinder", {"radius": radius, "length": 2.0 * machine.half_width}, place)

    def blocks(self) -> Iterator[tuple[int, Shape]]:
        """All stepping blocks, set by set, each with the pair of feet it is for."""
        size = self.ramp.lanes[0].length, BLOCK_HEIGHT, self.ramp.width
        for number in range(self.ramp.sets):
            for side, name in ((1.0, "left"), (-1.0, "right")):
                pair, x = number % 2, number * self.ramp.step
                place = (x, -size[1] / 2, side * self.ramp.tracks[pair])
                yield pair, Shape(f"block {number + 1} {name}", "box", {"size": size}, place, colour="block")

    def board(self) -> Shape:
        """The board under the blocks."""
        ramp = self.ramp
        span = (ramp.sets - 1) * ramp.step
        size = (span + 2.0 * ramp.lanes[0].length, BOARD, 2.0 * (ramp.tracks[1] + ramp.width))
        return Shape("deck", "box", {"size": size}, (span / 2, -BLOCK_HEIGHT - BOARD / 2, 0.0))

    def coordinates(self) -> list[tuple[Joint, float, float]]:
        """Every joint with its value and rate at the start."""
        q, v = self.start.position, self.start.velocity
        joints = [joint for link in self.links for joint in link.joints]
        return [(joint, float(q[joint.row]) + 0.0, float(v[joint.row]) + 0.0) for joint in joints]


#: Of the gait; its step from mid-stance on is all that is taken.
TOLERANCE = 1e-9
SAMPLES_A_SECOND = 1000.0


def exported(parameters: Parameters) -> Exported:
    """The twin of these parameters as it starts in its stage; what is seen is the bill of its legs' plain designs.

    Raises NoGait, BlocksDoNotFit, BeyondModel.
    """
    biped, slope, settings = parameters.biped, parameters.slope, parameters.settings
    machine = machine_of(biped, settings)
    if machine.hip_weight:
        raise BeyondModel("no exported format knows a weight without a mass (hip_gravity_mass); stages multibody and "
                          "twin do")
    walker, point = find_gait(biped, slope, TOLERANCE, None)
    walk, upright = walk_from_mid_stance(walker, point.z, 1, TOLERANCE, SAMPLES_A_SECOND)
    start = rolling_start(machine, parameters.contact, upright, walk.standing_force)
    ramp = laid(settings, parameters.blocks, describe(walker, point).step_length_m)
    return Exported(machine, settings, slope, parameters.contact, start, ramp, shown_parts(settings, biped))


Element: TypeAlias = ElementTree.Element
#: Text, or numbers that become text which gives the same bits when read.
Value: TypeAlias = str | float | Iterable[Any]


def text(value: Value) -> str:
    """A value as it stands in a document."""
    if isinstance(value, str):
        return value
    return " ".join(repr(float(number)) for number in np.atleast_1d(np.asarray(value, dtype=float)))


def tag(name: str, /, *content: Element | Value, **attributes: Value) -> Element:
    """An element with its children, or its text."""
    made = ElementTree.Element(name, {key: text(value) for key, value in attributes.items()})
    for each in content:
        if isinstance(each, ElementTree.Element):
            made.append(each)
        else:
            made.text = text(each)
    return made


def tensor(inertia: np.ndarray) -> dict[str, float]:
    """Entries of a tensor of inertia by name."""
    return {f"i{'xyz'[i]}{'xyz'[j]}": inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))}


def document(root: Element, remark: str) -> bytes:
    """The document with a remark at its head."""
    ElementTree.indent(root)
    head = f'<?xml version="1.0"?>\n<!-- {remark.replace("--", "-")} -->\n'
    return (head + ElementTree.tostring(root, encoding="unicode") + "\n").encode()
