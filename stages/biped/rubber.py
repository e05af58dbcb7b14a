"""A layer of rubber under the feet: it lengthens the legs, widens the feet, and weighs something."""

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

from stages.biped.accuracy.scales import Following
from stages.biped.design import Biped, Leg
from stages.biped.quantity import Bound, parameter


class RingSector(NamedTuple):
    """Area [m^2], depth of the centroid under the ring's centre [m], mean squares from the centroid [m^2].

    `along` is the direction of symmetry, downwards; `across` lies square to it in the ring's plane.
    """

    area: float
    depth: float
    across: float
    along: float


def ring_sector(outer: float, thickness: float, half_angle: float) -> RingSector:
    """The sector within `half_angle` [rad] of straight down, between `outer` radius [m] less `thickness` [m] and it."""
    inner = outer - thickness
    area = half_angle * (outer**2 - inner**2)
    if area == 0.0:
        return RingSector(0.0, outer * math.sin(half_angle) / half_angle if half_angle else outer, 0.0, 0.0)
    depth = 2.0 * math.sin(half_angle) * (outer**3 - inner**3) / (3.0 * area)
    polar = 0.5 * (outer**2 + inner**2)
    share = math.sin(2.0 * half_angle) / (4.0 * half_angle)
    return RingSector(area, depth, polar * (0.5 - share), polar * (0.5 + share) - depth**2)


#: Feet of a leg: the machine's legs are pairs.
FEET = 2
#: Arc [m] that the cover of Table 1's foot reaches, and that foot's radius [m]. The parts' arcs scale with the radius.
ARC, RADIUS = 0.112, 0.083


@dataclass(frozen=True)
class Rubber:
    """What a layer's mass follows from, beside its thickness and the foot's radius."""

    FILE: ClassVar[str] = "twin"

    foot_width: float = parameter("m", "width of each foot's cylinder", bound=Bound(above=0))
    outsole_arc: Following = parameter(
        "m", "arc that an outsole covers, at its middle; null: 112 mm for Table 1's foot", bound=Bound(above=0))
    outsole_density: float = parameter("kg/m^3", "density of an outsole; 0: without mass", bound=Bound(minimum=0))

    def arc(self, radius: float) -> float:
        """Arc [m] that a layer covers of a foot of this radius [m]: where none is given, the share of Table 1's."""
        return ARC * (radius / RADIUS) if self.outsole_arc is None else self.outsole_arc

    def sector(self, radius: float, thickness: float) -> RingSector:
        """Shape of a layer [m] on a foot of this radius [m]."""
        return ring_sector(radius + thickness, thickness, min(self.arc(radius) / (2.0 * radius + thickness), math.pi))

    def mass(self, radius: float, thickness: float) -> float:
        """Mass of the layer under one foot [kg]."""
        return self.outsole_density * self.foot_width * self.sector(radius, thickness).area


def soled(biped: Biped, rubber: Rubber, thickness: float, mass: float) -> Biped:
    """The simple model's design on a layer of `thickness` [m] that weighs `mass` [kg] a leg.

    Leg mass and rubber become one: their centre, and their inertia about it.
    """
    first, other = (soled_leg(biped.leg(index), rubber, thickness, mass) for index in (0, 1))
    others = {f"other_{key}": value for key, value in other.items()} if biped.leg(0) != biped.leg(1) else {}
    return replace(biped, **first, **others)


def soled_leg(leg: Leg, rubber: Rubber, thickness: float, mass: float) -> dict[str, Any]:
    """The numbers of a leg that the layer changes."""
    layer = rubber.sector(leg.foot_radius, thickness)
    above, sole = leg.foot_com + thickness, leg.foot_radius + thickness - layer.depth  # the new foot's bottom
    whole = leg.foot_mass + mass
    apart = leg.foot_mass * mass / whole * ((above - sole) ** 2 + leg.foot_offset**2)
    return {
        "leg_length": leg.leg_length + thickness,
        "foot_radius": leg.foot_radius + thickness,
        "foot_mass": whole,
        "foot_com": (leg.foot_mass * above + mass * sole) / whole,
        "leg_inertia": leg.leg_inertia + apart + mass * (layer.across + layer.along),
        "foot_offset": leg.foot_mass * leg.foot_offset / whole,
    }
