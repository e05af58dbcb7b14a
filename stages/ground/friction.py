"""Forces of the ground on a foot by the chosen laws: normal, and friction F_T = mu(v) F_N against the slip.

Friction is regularised alike for every law: up to the stiction velocity the foot creeps, with a cubic from no friction
at rest to the law's coefficient. So it is odd, continuous and finite at rest whatever the law.
"""

from __future__ import annotations

from typing import Any

from stages.ground.contact_law import ContactLaw
from stages.ground.laws import PointLaw
from stages.ground.operations import ARRAYS, Operations


def normal_force(law: ContactLaw, penetration: Any, rate: Any, ops: Operations = ARRAYS) -> Any:
    """Normal force [N], never negative, zero out of contact; penetration [m] positive in contact, its rate [m/s]."""
    return law.numbers.normal.force(penetration, rate, ops)


def static_penetration(law: ContactLaw, force: float) -> float:
    """Penetration [m] at which the ground carries `force` [N] at rest: (F_N / k_c)^(1/e), the same for every law."""
    return float((force / law.stiffness_si) ** (1.0 / law.contact_exponent))


def friction_coefficient(law: ContactLaw, slip: Any, ops: Operations = ARRAYS) -> Any:
    """Signed friction coefficient, odd in the slip velocity [m/s]; the force on the foot is -mu(slip) F_N."""
    return signed_coefficient(law.numbers, slip, ops)


def signed_coefficient(law: PointLaw, slip: Any, ops: Operations = ARRAYS) -> Any:
    """`friction_coefficient` of a law in numbers."""
    return ops.rise(slip, law.stiction_velocity, law.friction.coefficient(ops.absolute(slip), ops))


def friction_slope(law: PointLaw, slip_x: Any, slip_z: Any, ops: Operations = ARRAYS) -> Any:
    """mu(|v|) / |v| [s/m] of a slip with two components [m/s]: the force on the foot is -slope F_N (slip_x, slip_z)."""
    speed = ops.length(slip_x, slip_z)
    return ops.creep(speed, law.stiction_velocity, law.friction.coefficient(speed, ops))
