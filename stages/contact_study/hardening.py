"""Contact sets nearer to the rigid limit: the same impact, only shorter and shallower, and less creep.

An impact's depth shrinks to the share h while its speed stays, so its time does too. The force law keeps its shape if
k_c grows as h^-(e+1), c_max as 1/h, and d shrinks as h: the foot rebounds as it did. Creep and the slip at heel strike
shrink as h if v_s and v_d do. All differences from the limit are then of first order in h, or of order e/(e+1) in the
static penetration, which is (F_N / k_c)^(1/e).
"""

from __future__ import annotations

import dataclasses

from stages.ground.contact_law import ContactLaw


def with_impact(law: ContactLaw, share: float) -> ContactLaw:
    """The law with impacts of the part `share` in depth and time."""
    return dataclasses.replace(
        law,
        contact_stiffness=law.contact_stiffness * share ** -(law.contact_exponent + 1.0),
        contact_damping=law.contact_damping / share,
        damping_depth=law.damping_depth * share,
    )


def with_creep(law: ContactLaw, share: float) -> ContactLaw:
    """The law with the part `share` of its creep."""
    return dataclasses.replace(
        law, stiction_velocity=law.stiction_velocity * share, friction_velocity=law.friction_velocity * share
    )


def member(law: ContactLaw, share: float) -> ContactLaw:
    """The member `share` of the law's family: both at once. The rigid limit is share 0."""
    return with_creep(with_impact(law, share), share)
