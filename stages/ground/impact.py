"""Normal force of the Adams IMPACT function, eq. (9): a hardening spring and a damper that grows with depth."""

from __future__ import annotations

from typing import Any

from stages.ground.contact_law import ContactLaw
from stages.ground.operations import ARRAYS, Operations, smoothstep


def impact_force(law: ContactLaw, penetration: Any, rate: Any, ops: Operations = ARRAYS) -> Any:
    """Normal force [N] at a penetration [m] and its rate [m/s]: max(0, k_c p^e + STEP(p, 0, 0, d, c_max) dp/dt).

    The maximum is part of Adams' function; eq. (9) omits it, and without it the ground would pull at lift-off.
    """
    depth = ops.maximum(penetration, 0.0)
    spring = law.stiffness_si * ops.power(depth, law.contact_exponent)
    damper = law.contact_damping * smoothstep(penetration * (1.0 / law.damping_depth), ops) * rate
    return ops.maximum(spring + damper, 0.0)
