"""What both assemblies of the planar biped share, and the parts they are made of.

A detailed design has at the hip a spring, a damper, friction, a counterweight. All of it is Exudyn's: connectors
between the coordinates that are the legs' angles, and a load. What a design does not have is not assembled.
"""

import math
from abc import abstractmethod
from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np

from stages.biped.design import Biped, Leg
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.assembly.contact import Lanes, add_ground
from stages.multibody.assembly.system import OUTPUT, System, items
from stages.multibody.walking.watch import Look
from stages.planar.run import PlanarState, hip_creep
from stages.planar.signals import GROUND_REACTION, SIGNALS

#: Hip x, hip y, leg angles, leg lengths.
Pose = tuple[float, float, tuple[float, float], tuple[float, float]]


class PlanarBody(NamedTuple):
    """Mass [kg], mass centre [m] forward and up the leg from some point on its line, inertia about it [kg m^2]."""

    mass: float
    forward: float
    upward: float
    inertia: float


def below_spring(leg: Leg) -> PlanarBody:
    """The foot with all that moves with it, seen from the foot's centre."""
    return PlanarBody(leg.foot_mass, leg.foot_offset, leg.foot_com - leg.foot_radius, leg.leg_inertia)


def above_spring(leg: Leg) -> PlanarBody | None:
    """The frame, seen from the hip; None if the leg has none."""
    if not (leg.frame_mass or leg.frame_inertia):
        return None
    return PlanarBody(leg.frame_mass, leg.frame_offset, -leg.frame_com, leg.frame_inertia)


def joined(one: PlanarBody, other: PlanarBody | None) -> PlanarBody:
    """One rigid body of two seen from the same point, or the first alone."""
    if other is None:
        return one
    mass = one.mass + other.mass
    forward, upward = (
        (one.mass * here + other.mass * there) / mass for here, there in zip(one[1:3], other[1:3], strict=True)
    )
    apart = (one.forward - other.forward) ** 2 + (one.upward - other.upward) ** 2
    return PlanarBody(mass, forward, upward, one.inertia + other.inertia + one.mass * other.mass / mass * apart)


class Planar(System):
    """A system of the planar biped, with sensors for `signals`.

    A subclass adds its bodies with `discs`, the markers of both feet's disc centres, `angles`, node and coordinate of
    both legs' angles, and `hip`, a marker of the hip; and says where the hip and the legs are.
    """

    discs: list[Any]
    angles: tuple[tuple[Any, int], tuple[Any, int]]
    hip: Any

    def __init__(
        self, biped: Biped, slope: Slope, contact: ContactLaw, lanes: Lanes = None, *, compiled: bool = True,
        signals: Collection[str] = SIGNALS, rough: bool = False
    ) -> None:
        super().__init__()
        self.biped, self.legs = biped, (biped.leg(0), biped.leg(1))
        self.foot_radii = biped.foot_radii  # looked at after every step
        self.add_bodies(slope, signals)
        self.laws, self.contacts, self.grounds = add_ground(
            self.mbs, contact, self.foot_radii, self.discs, lanes, compiled=compiled, rough=rough)
        self.heights = [0.0, 0.0]
        self._add_hip(slope)
        for leg, connector in enumerate(self.contacts if GROUND_REACTION in signals else ()):
            self.keep(f"ground {leg}", items.SensorObject, objectNumber=connector,
                      outputVariableType=OUTPUT.ForceLocal)  # fmt: skip
        self.assemble()

    @abstractmethod
    def add_bodies(self, slope: Slope, signals: Collection[str]) -> None:
        """Add bodies, joints and springs."""

    @abstractmethod
    def start(self, state: PlanarState) -> None:
        """Make `state` the initial one."""

    @abstractmethod
    def pose(self) -> Pose:
        """Hip x, hip y, leg angles, leg lengths at the current step."""

    def _add_hip(self, slope: Slope) -> None:
        """Connectors that act on angle 0 minus angle 1; the weight by which the hip's for gravity exceeds its mass."""
        biped = self.biped
        if biped.hip_stiffness or biped.hip_damping:
            self._between_legs(items.ObjectConnectorCoordinateSpringDamper, stiffness=biped.hip_stiffness,
                               damping=biped.hip_damping, offset=biped.hip_rest_angle)  # fmt: skip
        if biped.hip_friction:
            self._between_legs(items.ObjectConnectorCoordinateSpringDamperExt, dynamicFrictionForce=biped.hip_friction,
                               frictionProportionalZone=hip_creep(biped, slope))  # fmt: skip
        self.add_weight(self.hip, biped.weighed_hip - biped.hip_mass, slope)

    def _between_legs(self, connector: Any, **numbers: float) -> None:
        """A connector takes the second marker's coordinate minus the first's."""
        markers = [self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=row))
                   for node, row in reversed(self.angles)]  # fmt: skip
        self.mbs.AddObject(connector(markerNumbers=markers, **numbers))

    def set_in_play(self, leg: int, acts: bool) -> None:
        """Let the ground act on a leg's foot, or not."""
        self.mbs.SetObjectParameter(self.contacts[leg], "activeConnector", bool(acts))

    def set_height(self, leg: int, height: float) -> None:
        """Put a block of this height [m] under a leg's foot; the ground is a rough one."""
        self.heights[leg] = height
        self.mbs.SetObjectParameter(self.grounds[leg], "referencePosition", [0.0, height, 0.0])

    def look(self) -> Look:
        """Where it is at the current step."""
        x, y, angles, lengths = self.pose()
        (a, b), (first, other), radii, under = angles, lengths, self.foot_radii, self.heights
        first, other = first - radii[0], other - radii[1]
        clearance = y - under[0] - first * math.cos(a) - radii[0], y - under[1] - other * math.cos(b) - radii[1]
        place = x + first * math.sin(a), x + other * math.sin(b)
        return Look(y, angles, clearance, place, x + y + a + b + lengths[0] + lengths[1])


def reactions(rows: dict[str, np.ndarray], count: int) -> np.ndarray:
    """Force of the ground on each foot from the signals `ground 0` and `ground 1`, (n, 2, 2) [N].

    (n, 0, 2) without them.
    """
    names = [name for name in ("ground 0", "ground 1") if name in rows]
    return np.stack([-rows[name][:, 1:3] for name in names], axis=1) if names else np.zeros((count, 0, 2))
