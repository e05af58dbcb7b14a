"""Parameters of the ground contact: normal force (eq. 9) and friction (eq. 10), Adams' set, and sets nearer to rigid.

In the sets nearer to the rigid limit the ground neither gives way nor lets a standing foot creep. With the share s an
effect of penalty contact keeps about the part s of its size:

- creep: a foot at rest slips at a speed ~ v_s. The fall from static to dynamic friction, up to v_d, shrinks with it;
- an impact of finite stiffness: static penetration is ~ k_c^(-1/e), so k_c grows as s^-e. An impact stops where damping
  has taken the momentum, at a depth ~ (m v d^2 / c_max)^(1/3), so c_max grows as 1/s and d shrinks as s. What is left
  of the speed is ~ k_c p^e over the damping at depth p, so that it is ~ s too: the limit's impact is plastic, as the
  constraint model's is. (The law Restitution returns at most a speed ~ its impact_speed, which shrinks as s.)

Stiffness and damping are one effect, not two: with the damping as it was, a stiffer contact throws the foot back. If
damping grows only as the depth of an undamped impact shrinks, by s^(-e/(e+1)), the foot is as elastic in the limit as
in the law itself; it then flies for a time that no share shortens, and nothing falls as a power of s.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar

from stages.biped.accuracy.scales import Following, Scales, similar
from stages.biped.quantity import Bound, Broken, parameter
from stages.ground.laws import FRICTIONS, NORMAL_FORCES, PointLaw, has
from stages.ground.slope import Friction, OnSlope, dynamic_friction, law_of_friction, static_friction


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
    friction: str = law_of_friction()
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
        """Dynamic friction does not exceed static friction; the two transition velocities are in order; of a law that
        has both."""
        yield from Friction(self.static_friction, self.dynamic_friction, self.friction).broken_rules()
        if has(self.friction, "friction_velocity") and self.stiction_velocity >= self.friction_velocity:
            yield Broken("stiction_velocity", f"< friction_velocity = {self.friction_velocity:g} m/s")

    @property
    def coefficients(self) -> Friction:
        """Friction of the law's rigid limit, which no foot creeps in."""
        return Friction(self.static_friction, self.dynamic_friction, self.friction).coefficients

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
        return replace(
            self,
            contact_stiffness=self.contact_stiffness / feet,
            contact_damping=self.contact_damping / feet,
        )


@dataclass(frozen=True)
class OnGround(OnSlope):
    """What the parameters of a stage begin with that walks on ground with a contact law."""

    contact: ContactLaw


def with_impact(law: ContactLaw, share: float) -> ContactLaw:
    """The law with the part `share` of what its finite stiffness does."""
    return replace(
        law,
        contact_stiffness=law.contact_stiffness * share**-law.contact_exponent,
        contact_damping=law.contact_damping / share,
        damping_depth=law.damping_depth * share,
        impact_speed=law.impact_speed * share,
    )


def with_creep(law: ContactLaw, share: float) -> ContactLaw:
    """The law with the part `share` of its creep."""
    return replace(
        law, stiction_velocity=law.stiction_velocity * share, friction_velocity=law.friction_velocity * share
    )


def family_member(law: ContactLaw, share: float) -> ContactLaw:
    """The law with the part `share` of both: a member of its family towards the rigid limit, which is share 0."""
    return with_creep(with_impact(law, share), share)


#: What null is for Table 1's robot.
ADAMS = {"default_stiffness": 1e5, "default_damping": 1e4, "default_depth": 1e-4, "default_stiction_velocity": 0.1,
         "default_friction_velocity": 1.0}  # fmt: skip


@dataclass(frozen=True)
class DefaultSet:
    """The numbers of the contact set from which the study starts: Adams' default, as the paper's.

    Laws and friction coefficients are those of ground.yaml.
    """

    FILE: ClassVar[str] = "contact_study"

    default_stiffness: Following = parameter(
        "N/mm^e", "stiffness of the starting set", symbol="k_c", bound=Bound(above=0))
    default_exponent: float = parameter("1", "force exponent of the starting set", symbol="e", bound=Bound(minimum=1))
    default_damping: Following = parameter(
        "N s/m", "largest damping of the starting set", symbol="c_max", bound=Bound(above=0)
    )
    default_depth: Following = parameter(
        "m", "depth of complete damping of the starting set", symbol="d", bound=Bound(above=0)
    )
    default_stiction_velocity: Following = parameter(
        "m/s", "stiction velocity of the starting set", symbol="v_s", bound=Bound(above=0)
    )
    default_friction_velocity: Following = parameter(
        "m/s", "friction velocity of the starting set", symbol="v_d", bound=Bound(above=0)
    )

    def of(self, own: Scales) -> DefaultSet:
        """The set of a robot of these scales, which decide what is null."""
        return similar(self, ADAMS, own, self.default_exponent)

    def law(self, contact: ContactLaw) -> ContactLaw:
        """The default set with the laws and the friction coefficients of `contact`."""
        return replace(
            contact,
            contact_stiffness=self.default_stiffness,
            contact_exponent=self.default_exponent,
            contact_damping=self.default_damping,
            damping_depth=self.default_depth,
            stiction_velocity=self.default_stiction_velocity,
            friction_velocity=self.default_friction_velocity,
        )
