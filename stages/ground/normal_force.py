"""Normal force of the ground on a foot, by the chosen law."""

from __future__ import annotations

from typing import Any

from stages.ground.contact_law import ContactLaw
from stages.ground.operations import ARRAYS, Operations


def normal_force(law: ContactLaw, penetration: Any, rate: Any, ops: Operations = ARRAYS) -> Any:
    """Normal force [N], never negative, zero out of contact; penetration [m] positive in contact, its rate [m/s]."""
    return law.numbers.normal.force(penetration, rate, ops)


def static_penetration(law: ContactLaw, force: float) -> float:
    """Penetration [m] at which the ground carries `force` [N] at rest: (F_N / k_c)^(1/e), the same for every law."""
    return float((force / law.stiffness_si) ** (1.0 / law.contact_exponent))
