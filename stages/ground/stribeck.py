"""Friction coefficient with Adams' transitions, eq. (10) and Fig. 6: creep, static peak, fall to dynamic friction."""

from __future__ import annotations

from typing import Any

from stages.ground.contact_law import ContactLaw
from stages.ground.operations import ARRAYS, Operations, rise, smoothstep


def stribeck_coefficient(law: ContactLaw, slip: Any, ops: Operations = ARRAYS) -> Any:
    """Friction coefficient, odd in the slip velocity [m/s].

    STEP from -mu_s at -v_s to mu_s at v_s (slope 1.5 mu_s / v_s at rest), STEP from mu_s at v_s to mu_d at v_d,
    mu_d beyond.
    """
    static = law.static_friction * rise(slip * (1.0 / law.stiction_velocity), ops)
    if law.dynamic_friction == law.static_friction:
        return static
    width = law.friction_velocity - law.stiction_velocity
    beyond = smoothstep((ops.absolute(slip) - law.stiction_velocity) * (1.0 / width), ops)
    return static - (law.static_friction - law.dynamic_friction) * ops.sign(slip) * beyond
