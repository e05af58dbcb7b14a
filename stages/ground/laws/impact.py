"""Normal force of the Adams IMPACT function, eq. (9): a hardening spring and a damper that grows with depth."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from stages.ground.contact_law import ContactLaw
    from stages.ground.operations import Operations


class Impact(NamedTuple):
    """Stiffness k_c [N/m^e], exponent e, damping c_max [N s/m] and the depth d [m] at which it is complete."""

    stiffness: float
    exponent: float
    damping: float
    depth: float

    @classmethod
    def of(cls, contact: ContactLaw) -> Impact:
        """The numbers of these parameters."""
        return cls(contact.stiffness_si, contact.contact_exponent, contact.contact_damping, contact.damping_depth)

    def force(self, penetration: Any, rate: Any, ops: Operations) -> Any:
        """Normal force [N] at a penetration [m] and its rate [m/s]: max(0, k_c p^e + STEP(p, 0, 0, d, c_max) dp/dt).

        The maximum is part of Adams' function; eq. (9) omits it, and without it the ground would pull at lift-off.
        """
        spring = self.stiffness * ops.power(ops.maximum(penetration, 0.0), self.exponent)
        return ops.maximum(spring + ops.step(penetration, self.depth, self.damping) * rate, 0.0)
