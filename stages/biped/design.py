"""The biped's design parameters (Table 1 of the paper)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from stages.biped.quantity import Bound, Broken, parameter


@dataclass(frozen=True)
class Biped:
    """Hip mass and two equal legs with an axial spring and damper, a round foot and a foot mass.

    Lengths run along the leg from the hip to the bottom of the foot. The foot mass sits below the spring.
    """

    FILE: ClassVar[str] = "biped"

    legs: str = parameter("-", "axial degree of freedom of the legs", choices=("compliant", "rigid"))
    hip_mass: float = parameter("kg", "mass lumped at the hip", symbol="M", bound=Bound(minimum=0))
    foot_mass: float = parameter("kg", "mass of one leg, at foot_com", symbol="m", bound=Bound(above=0))
    leg_length: float = parameter(
        "m", "natural leg length, hip to bottom of foot", symbol="L_nat", bound=Bound(above=0)
    )
    foot_radius: float = parameter("m", "radius of the round foot", symbol="r", bound=Bound(minimum=0))
    foot_com: float = parameter(
        "m", "height of the leg's mass above the foot's bottom", symbol="l", bound=Bound(minimum=0)
    )
    stiffness: float = parameter("N/m", "axial stiffness of a leg", symbol="k", bound=Bound(above=0))
    damping: float = parameter("N s/m", "axial damping of a leg", symbol="b", bound=Bound(minimum=0))
    leg_inertia: float = parameter(
        "kg m^2", "inertia of a leg about its mass centre", symbol="I", bound=Bound(minimum=0)
    )

    def broken_rules(self) -> Iterator[Broken]:
        """Rules between the values: the foot and the mass lie below the hip; compliant legs carry mass everywhere."""
        if self.foot_radius >= self.leg_length:
            yield Broken("foot_radius", f"< leg_length = {self.leg_length:g} m")
        if self.foot_com >= self.leg_length:
            yield Broken("foot_com", f"< leg_length = {self.leg_length:g} m")
        if self.legs == "compliant" and self.hip_mass <= 0:
            yield Broken(
                "hip_mass", "> 0 kg with compliant legs (a massless hip between two springs has no equation of motion)"
            )

    @property
    def total_mass(self) -> float:
        """Mass of the whole machine [kg]."""
        return self.hip_mass + 2 * self.foot_mass
