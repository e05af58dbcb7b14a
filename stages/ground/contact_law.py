"""Parameters of the ground contact: normal force (eq. 9) and friction (eq. 10)."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from stages.biped.quantity import Bound, Broken, parameter
from stages.ground.friction_coefficients import Friction, dynamic_friction, static_friction
from stages.ground.laws import FRICTIONS, NORMAL_FORCES, PointLaw


@dataclass(frozen=True)
class ContactLaw:
    """Normal force and friction of one leg's foot; the defaults of the choices are the paper's laws.

    `contact_stiffness` is in N/mm^e, as Adams and the paper give it, because its SI value depends on the exponent:
    k_c [N/m^e] = contact_stiffness * 1000^e.
    """

    FILE: ClassVar[str] = "ground"

    contact_stiffness: float = parameter("N/mm^e", "stiffness of the normal force", symbol="k_c", bound=Bound(above=0))
    contact_exponent: float = parameter("1", "force exponent", symbol="e", bound=Bound(minimum=1))
    contact_damping: float = parameter("N s/m", "largest contact damping", symbol="c_max", bound=Bound(minimum=0))
    damping_depth: float = parameter(
        "m", "penetration at which the damping is complete", symbol="d", bound=Bound(above=0)
    )
    static_friction: float = static_friction()
    dynamic_friction: float = dynamic_friction()
    stiction_velocity: float = parameter("m/s", "slip speed of greatest friction", symbol="v_s", bound=Bound(above=0))
    friction_velocity: float = parameter(
        "m/s", "least slip speed of dynamic friction", symbol="v_d", bound=Bound(above=0)
    )
    normal_force: str = parameter("-", "law of the normal force", choices=tuple(NORMAL_FORCES), default="impact")
    friction: str = parameter("-", "law of friction", choices=tuple(FRICTIONS), default="stribeck")
    restitution: float = parameter(
        "1",
        "part of impact_speed that is returned (law restitution only)",
        bound=Bound(minimum=0.05, maximum=1),
        default=0.1,
    )
    impact_speed: float = parameter(
        "m/s", "impact speed at which the restitution holds (law restitution only)", bound=Bound(above=0), default=0.3
    )

    def broken_rules(self) -> Iterator[Broken]:
        """Dynamic friction does not exceed static friction; the two transition velocities are in order."""
        yield from self.coefficients.broken_rules()
        if self.stiction_velocity >= self.friction_velocity:
            yield Broken("stiction_velocity", f"< friction_velocity = {self.friction_velocity:g} m/s")

    @property
    def coefficients(self) -> Friction:
        """The two friction coefficients alone."""
        return Friction(self.static_friction, self.dynamic_friction)

    @property
    def stiffness_si(self) -> float:
        """Contact stiffness in N/m^e."""
        stiffness: float = self.contact_stiffness * 1000.0**self.contact_exponent
        return stiffness

    @property
    def numbers(self) -> PointLaw:
        """The chosen laws with these parameters. Raises KeyError for a law that is none of the choices."""
        normal, friction = NORMAL_FORCES[self.normal_force], FRICTIONS[self.friction]
        return PointLaw(normal.of(self), friction.of(self), self.stiction_velocity)

    def shared_by(self, feet: int) -> ContactLaw:
        """The law of one of `feet` equal feet that stand side by side and together act as this law."""
        return dataclasses.replace(
            self,
            contact_stiffness=self.contact_stiffness / feet,
            contact_damping=self.contact_damping / feet,
        )
