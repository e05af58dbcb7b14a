"""The twin as a mechanism: six rigid bodies put together from its bill of parts, four legs with springs, four feet."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stages.biped.design import Biped
from stages.twin.machine.bill import check
from stages.twin.machine.parts import FRAMES, Part, solid
from stages.twin.parameters import Settings

#: A thin rod's tensor along a leg, by its moment about the hip axis: no body has that moment alone.
ROD = np.diag([1.0, 0.0, 1.0])


@dataclass(frozen=True)
class Body:
    """Mass [kg], mass centre [m] (3,) and tensor of inertia about it [kg m^2] (3, 3), in the axes of the parts."""

    mass: float
    centre: np.ndarray
    inertia: np.ndarray

    def inertia_about(self, point: np.ndarray) -> np.ndarray:
        """Tensor of inertia about a point, by the parallel-axis theorem."""
        d = self.centre - np.asarray(point)
        return np.asarray(self.inertia + self.mass * (np.dot(d, d) * np.eye(3) - np.outer(d, d)))


def join(bodies: Iterable[Body]) -> Body:
    """One rigid body made of several."""
    pieces = list(bodies)
    mass = sum(piece.mass for piece in pieces)
    centre = sum((piece.mass * piece.centre for piece in pieces), np.zeros(3)) / mass if mass else np.zeros(3)
    return Body(mass, centre, sum((piece.inertia_about(centre) for piece in pieces), np.zeros((3, 3))))


def pieces(part: Part) -> Iterator[Body]:
    """The piece a row describes, and its mirror image if it has one."""
    shape = solid(part.shape, part.size, part.axis)
    place = np.array(part.position, dtype=float) + np.array(shape.centroid)
    inertia = np.diag(shape.inertia(part.mass))
    yield Body(part.mass, place, inertia)
    if part.pieces == 2:
        yield Body(part.mass, place * np.array([1.0, 1.0, -1.0]), inertia)


def bodies(parts: Iterable[Part]) -> tuple[Body, ...]:
    """Six rigid bodies: inner frame, left and right inner foot, outer frame, left and right outer foot."""
    gathered: list[list[Body]] = [[] for _ in range(6)]
    for part in parts:
        first = 3 * part.group.startswith("outer")
        for piece in pieces(part):
            side = 0 if part.group in FRAMES else (1 if piece.centre[2] > 0.0 else 2)
            gathered[first + side].append(piece)
    return tuple(join(group) for group in gathered)


def turning_as(bodies: Sequence[Body], leg_inertia: float) -> tuple[Body, ...]:
    """Bodies whose pairs of feet have this moment [kg m^2]; 0: as they are.

    A foot's whole tensor scales. Exact where the left and the right foot of a pair are alike.
    """
    found = list(bodies)
    for first in (1, 4) if leg_inertia > 0.0 else ():
        have = float(join(found[first : first + 2]).inertia[2, 2])
        for number in (first, first + 1):
            inertia = found[number].inertia * (leg_inertia / have) if have else 0.5 * leg_inertia * ROD
            found[number] = replace(found[number], inertia=inertia)
    return tuple(found)


#: Legs in order. "Left" is the side of z > 0, as seen against the walking direction; leg // 2 is its pair, 0 inner.
LEGS = ("inner left", "inner right", "outer left", "outer right")
FRAME_BODY = (0, 3)
FOOT_BODY = (1, 2, 4, 5)


@dataclass(frozen=True)
class Build:
    """How one built machine departs from the drawing. Bodies and legs in the order of `Machine`.

    Factors on masses (with their inertia), stiffness and damping; additions [m] to leg lengths and to the outsole.
    """

    body_mass: tuple[float, ...] = (1.0,) * 6
    stiffness: tuple[float, ...] = (1.0,) * 4
    damping: tuple[float, ...] = (1.0,) * 4
    leg_length: tuple[float, ...] = (0.0,) * 4
    outsole: float = 0.0


@dataclass(frozen=True)
class Machine:
    """Bodies: inner frame, inner left and right foot, outer frame, outer left and right foot. Legs as in `LEGS`.

    Per leg: `lane` z of the foot's middle [m], `radius` [m], `length` hip to foot bottom unloaded [m], `stiffness`
    [N/m], `damping` [N s/m]. `half_width` [m] of a foot's cylinder, `bearing_friction` [N m s].
    Of the design, without outsole [m]: `drawn_lengths` of each pair, `drawn_foot_com` from the hip axis up to a foot's
    mass.
    Feet do not slide on `rigid` legs, whatever their stiffness and damping.
    Between the frames: `hip_stiffness` [N m/rad], relaxed where the inner pair is `hip_rest_angle` [rad] ahead of the
    outer one, `hip_friction` [N m]. `hip_weight` [kg] is what gravity pulls at on the axis beside the masses.
    """

    bodies: tuple[Body, ...]
    lane: np.ndarray
    radius: np.ndarray
    length: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    half_width: float
    bearing_friction: float
    drawn_lengths: tuple[float, float]
    drawn_foot_com: float
    rigid: bool
    hip_stiffness: float = 0.0
    hip_rest_angle: float = 0.0
    hip_friction: float = 0.0
    hip_weight: float = 0.0

    @property
    def mass(self) -> float:
        """Mass of the whole machine [kg]."""
        return sum(body.mass for body in self.bodies)

    @property
    def feet(self) -> np.ndarray:
        """What the contact needs of each foot, (4, 4): lane, radius, length, half width [m]."""
        return np.column_stack([self.lane, self.radius, self.length, np.full(4, self.half_width)])


AS_DRAWN = Build()


def build(biped: Biped, settings: Settings, departure: Build = AS_DRAWN) -> Machine:
    """The machine of a plain design, on an outsole if the settings or the departure have one.

    Raises ValueError if its parts are no design's (`Settings.bill`).
    """
    if settings.inertia == "planar":
        drawn = planar_equivalent(biped, settings)
    else:
        check(settings.parts, settings.materials, settings.drawn_for(biped), biped)
        drawn = turning_as(bodies(settings.bill(biped)), biped.leg_inertia)
    scaled = tuple(
        Body(factor * body.mass, body.centre, factor * body.inertia)
        for factor, body in zip(departure.body_mass, drawn, strict=True)
    )
    rubber = settings.outsole + departure.outsole
    if rubber > 0.0:
        scaled = tuple(
            join([body, under_foot(index, biped, settings, rubber)]) if index in FOOT_BODY else body
            for index, body in enumerate(scaled)
        )
    inner, outer = settings.inner_lane, settings.outer_lane
    return Machine(
        bodies=scaled,
        lane=np.array([inner, -inner, outer, -outer]),
        radius=np.full(4, biped.foot_radius + rubber),
        length=biped.leg_length + rubber + np.array(departure.leg_length),
        stiffness=0.5 * biped.stiffness * np.array(departure.stiffness),
        damping=0.5 * biped.damping * np.array(departure.damping) + settings.slider_friction,
        half_width=0.5 * settings.foot_width,
        bearing_friction=settings.bearing_friction,
        drawn_lengths=(biped.leg_length, biped.leg_length),
        drawn_foot_com=biped.foot_com - biped.leg_length,
        rigid=biped.legs == "rigid",
    )


def under_foot(index: int, biped: Biped, settings: Settings, thickness: float) -> Body:
    """The outsole under the foot that is body `index`, on top of the drawing."""
    layer = settings.sector(biped.foot_radius, thickness)
    mass = settings.mass(biped.foot_radius, thickness)
    lane = (settings.inner_lane, settings.outer_lane)[index // 3] * (1.0 if index % 3 == 1 else -1.0)
    x2, y2, z2 = layer.across, layer.along, settings.foot_width**2 / 12
    centre = np.array([0.0, biped.foot_radius - biped.leg_length - layer.depth, lane])
    return Body(mass, centre, mass * np.diag([y2 + z2, z2 + x2, x2 + y2]))


def planar_equivalent(biped: Biped, settings: Settings) -> tuple[Body, ...]:
    """Bodies that move in the plane exactly as the simple model: a point at the hip, half a leg's mass at each foot.

    A leg's moment is that of a thin rod along it.
    """
    place = biped.foot_com - biped.leg_length
    lanes = (settings.inner_lane, -settings.inner_lane, settings.outer_lane, -settings.outer_lane)
    foot = [
        Body(0.5 * biped.foot_mass, np.array([0.0, place, z]), 0.5 * biped.leg_inertia * ROD)
        for z in lanes
    ]
    hip, empty = (Body(mass, np.zeros(3), np.zeros((3, 3))) for mass in (biped.hip_mass, 0.0))
    return (hip, foot[0], foot[1], empty, foot[2], foot[3])
