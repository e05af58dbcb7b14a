"""Friction of the ground on a foot, by the chosen law: F_T = mu(v) F_N against the slip.

Friction is regularised alike for every law: up to the stiction velocity the foot creeps, with a cubic from no friction
at rest to the law's coefficient. So it is odd, continuous and finite at rest whatever the law.
"""

from __future__ import annotations

from typing import Any

from stages.ground.contact_law import ContactLaw
from stages.ground.laws import PointLaw
from stages.ground.operations import ARRAYS, Operations


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
