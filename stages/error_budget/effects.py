"""What sets the penalty model apart from the constraint model, each effect with its limit.

With share s an effect that is off keeps about the part s of its size; towards s = 0 it vanishes to first order in s:

- creep: a foot at rest slips below v_s; off, s v_s. The fall from static to dynamic friction over the slip speeds up
  to v_d goes with it; off, v_d = 2 s v_s. Alone it moves the hip by less than 1e-5 mm.
- compliance: the static penetration p ~ k_c^(-1/e); off, s^(-e) k_c. An impact of the same speed reaches a depth ~
  k_c^(-1/(e+1)); so that it stays as plastic as it was, c_max grows by the inverse of that depth.
- damping ramp: damping is complete at the depth d; off, d shrinks as the depth of an impact does.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection

from stages.ground.contact_law import ContactLaw

CREEP, COMPLIANCE, RAMP = "creep below v_s", "compliance k_c", "damping ramp d"
#: Effects of penalty contact in the order in which the path switches them on, and the same path backwards.
CONTACT = (CREEP, COMPLIANCE, RAMP)

SLIP, UNEXPLAINED = "trailing foot slips", "unexplained"
INTEGRATION_CONSTRAINT, INTEGRATION_PENALTY = "integration, constraint model", "integration, penalty model"
#: All contributions, in the order in which results hold them.
EFFECTS = (INTEGRATION_CONSTRAINT, SLIP, UNEXPLAINED, *CONTACT, INTEGRATION_PENALTY)


def switched(law: ContactLaw, on: Collection[str], share: float) -> ContactLaw:
    """The law with the effects in `on` as they are, and the others reduced to the part `share`."""
    stiffer = share**-law.contact_exponent
    shallower = stiffer ** (-1.0 / (law.contact_exponent + 1.0))
    stiction = share * law.stiction_velocity
    creeps, rigid = CREEP in on, COMPLIANCE not in on
    return dataclasses.replace(
        law,
        contact_stiffness=law.contact_stiffness * (stiffer if rigid else 1.0),
        contact_damping=law.contact_damping / (shallower if rigid else 1.0),
        damping_depth=law.damping_depth * (1.0 if RAMP in on else shallower),
        stiction_velocity=law.stiction_velocity if creeps else stiction,
        friction_velocity=law.friction_velocity if creeps else 2.0 * stiction,
    )
