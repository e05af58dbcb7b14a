"""What sets the penalty model apart from the constraint model, each effect with its limit.

With share s an effect that is off keeps about the part s of its size, and so does what it does to the hip:

- creep: a foot at rest slips below v_s; off, s v_s. The fall from static to dynamic friction over the slip speed up
  to v_d goes with it; off, v_d = 2 s v_s. Alone it moves the hip by less than 1e-5 mm.
- an impact of finite stiffness: the landing foot sinks in and comes back, and a standing foot sinks in as the force on
  it grows. Stiffness and damping are one effect, not two, see `stages.ground.hardening`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection

from stages.ground.contact_law import ContactLaw
from stages.ground.hardening import with_impact

CREEP, IMPACT = "creep below v_s", "impact of finite stiffness"
#: Effects of penalty contact in the order in which the path switches them on; then the same path backwards.
CONTACT = (CREEP, IMPACT)

SLIP, UNEXPLAINED = "trailing foot slips", "unexplained"
INTEGRATION_CONSTRAINT, INTEGRATION_PENALTY = "integration, constraint model", "integration, penalty model"
#: All contributions, in the order in which results hold them.
EFFECTS = (INTEGRATION_CONSTRAINT, SLIP, UNEXPLAINED, *CONTACT, INTEGRATION_PENALTY)


def switched(law: ContactLaw, on: Collection[str], share: float) -> ContactLaw:
    """The law with the effects in `on` as they are, and the others reduced to the part `share`."""
    if CREEP not in on:
        stiction = share * law.stiction_velocity
        law = dataclasses.replace(law, stiction_velocity=stiction, friction_velocity=2.0 * stiction)
    if IMPACT not in on:
        law = with_impact(law, share)
    return law
