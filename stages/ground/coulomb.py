"""Regularised Coulomb friction: one coefficient, reached at the stiction velocity."""

from __future__ import annotations

from typing import Any

from stages.ground.contact_law import ContactLaw
from stages.ground.operations import ARRAYS, Operations, rise


def coulomb_coefficient(law: ContactLaw, slip: Any, ops: Operations = ARRAYS) -> Any:
    """Friction coefficient, odd in the slip velocity [m/s]: mu_s beyond v_s, a smooth rise below it."""
    return law.static_friction * rise(slip * (1.0 / law.stiction_velocity), ops)
