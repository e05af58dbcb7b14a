"""Normal force that returns a stated part of the impact speed: Hunt-Crossley damping set by the restitution.

The damping is proportional to the spring force, F = k_c p^e (1 + a dp/dt). Such an impact has a closed solution: a mass
that arrives with speed v leaves with speed w where, with x = a v and y = a w, x - ln(1 + x) = -y - ln(1 - y),
whatever the mass, the stiffness and the exponent. The factor a is chosen so that w = restitution * v at `impact_speed`.
Adams offers a law of this name too but does not print its formula; this one keeps the promise of the name.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from stages.ground.contact_law import ContactLaw
    from stages.ground.operations import Operations


@lru_cache(maxsize=64)
def damping_factor(restitution: float, impact_speed: float) -> float:
    """Factor a [s/m] that gives `restitution` (0.05 to 1; below, y is 1 to the last bit) at `impact_speed` [m/s].

    A restitution with a small imaginary part gives a factor with that part's consequence (complex step).
    """
    share = restitution.real
    if share == 1.0:  # the first term of a series
        return 1.5 * (1.0 - restitution) / impact_speed

    def excess(x: float) -> float:
        return x - math.log1p(x) + share * x + math.log1p(-share * x)

    # Positive for small x (losses too small), falling to -infinity at x = 1 / restitution: bisection to the last bit.
    low, high = 0.0, 1.0 / share
    while True:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if excess(middle) > 0.0:
            low = middle
        else:
            high = middle
    slope = middle / (1.0 + middle) - share**2 * middle / (1.0 - share * middle)
    carried = share * middle**2 / (1.0 - share * middle) / slope * (restitution - share)
    return (middle + carried) / impact_speed


class Restitution(NamedTuple):
    """Stiffness k_c [N/m^e], exponent e, damping factor a [s/m]."""

    stiffness: float
    exponent: float
    factor: float

    @classmethod
    def of(cls, contact: ContactLaw) -> Restitution:
        """The numbers of these parameters."""
        factor = damping_factor(contact.restitution, contact.impact_speed)
        return cls(contact.stiffness_si, contact.contact_exponent, factor)

    def force(self, penetration: Any, rate: Any, ops: Operations) -> Any:
        """Normal force [N] at a penetration [m] and its rate [m/s]: k_c p^e max(0, 1 + a dp/dt)."""
        spring = self.stiffness * ops.power(ops.maximum(penetration, 0.0), self.exponent)
        return spring * ops.maximum(1.0 + self.factor * rate, 0.0)
