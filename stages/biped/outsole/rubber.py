"""A layer of rubber under the feet: it lengthens the legs, widens the feet, and weighs something."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import ClassVar

from stages.biped.design import Biped, require_plain
from stages.biped.outsole.ring_sector import RingSector, ring_sector
from stages.biped.quantity import Bound, parameter

#: Feet of a leg: the machine's legs are pairs.
FEET = 2


@dataclass(frozen=True)
class Rubber:
    """What a layer's mass follows from, beside its thickness and the foot's radius."""

    FILE: ClassVar[str] = "twin"

    foot_width: float = parameter("m", "width of each foot's cylinder", bound=Bound(above=0))
    outsole_arc: float = parameter("m", "arc of a foot that an outsole covers, at its middle", bound=Bound(above=0))
    outsole_density: float = parameter("kg/m^3", "density of an outsole; 0: without mass", bound=Bound(minimum=0))

    def sector(self, radius: float, thickness: float) -> RingSector:
        """Shape of a layer [m] on a foot of this radius [m]."""
        return ring_sector(radius + thickness, thickness, min(self.outsole_arc / (2.0 * radius + thickness), math.pi))

    def mass(self, radius: float, thickness: float) -> float:
        """Mass of the layer under one foot [kg]."""
        return self.outsole_density * self.foot_width * self.sector(radius, thickness).area


def soled(biped: Biped, rubber: Rubber, thickness: float, mass: float) -> Biped:
    """The simple model's design on a layer of `thickness` [m] that weighs `mass` [kg] a leg.

    Leg mass and rubber become one: their centre, and their inertia about it. Raises BeyondModel.
    """
    require_plain(biped, "the effect of outsoles")
    layer = rubber.sector(biped.foot_radius, thickness)
    leg, sole = biped.foot_com + thickness, biped.foot_radius + thickness - layer.depth  # above the new foot's bottom
    whole = biped.foot_mass + mass
    apart = biped.foot_mass * mass / whole * (leg - sole) ** 2
    return dataclasses.replace(
        biped,
        leg_length=biped.leg_length + thickness,
        foot_radius=biped.foot_radius + thickness,
        foot_mass=whole,
        foot_com=(biped.foot_mass * leg + mass * sole) / whole,
        leg_inertia=biped.leg_inertia + apart + mass * (layer.across + layer.along),
    )
