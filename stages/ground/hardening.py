"""Contact sets nearer to the rigid limit, in which the ground neither gives way nor lets a standing foot creep.

With the share s an effect of penalty contact keeps about the part s of its size:

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

import dataclasses

from stages.ground.contact_law import ContactLaw


def with_impact(law: ContactLaw, share: float) -> ContactLaw:
    """The law with the part `share` of what its finite stiffness does."""
    return dataclasses.replace(
        law,
        contact_stiffness=law.contact_stiffness * share**-law.contact_exponent,
        contact_damping=law.contact_damping / share,
        damping_depth=law.damping_depth * share,
        impact_speed=law.impact_speed * share,
    )


def with_creep(law: ContactLaw, share: float) -> ContactLaw:
    """The law with the part `share` of its creep."""
    return dataclasses.replace(
        law, stiction_velocity=law.stiction_velocity * share, friction_velocity=law.friction_velocity * share
    )


def family_member(law: ContactLaw, share: float) -> ContactLaw:
    """The law with the part `share` of both: a member of its family towards the rigid limit, which is share 0."""
    return with_creep(with_impact(law, share), share)
