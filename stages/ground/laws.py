"""The contact laws and their register: a class and an entry here are all that a new law needs.

A law is a NamedTuple of the numbers it needs, made from the parameters by `of`, with its formula as a method over
`Operations`. That one text serves the planar model's symbols, numpy and the twin's machine code, which knows the law by
the tuple's type. The tests run over these two tables.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from stages.ground.contact_law import ContactLaw
    from stages.ground.friction import Operations


class Coulomb(NamedTuple):
    """Coulomb friction: one coefficient mu_s, whatever the slip."""

    static: float

    @classmethod
    def of(cls, contact: ContactLaw) -> Coulomb:
        """The number of these parameters."""
        return cls(contact.static_friction)

    @staticmethod
    def coefficients(static: float, dynamic: float) -> tuple[float, float]:
        """What it makes of the two: coefficients of a foot at rest and of one that slides, where none creeps."""
        return static, static

    def coefficient(self, speed: Any, ops: Operations) -> Any:
        """Friction coefficient of a sliding foot."""
        return self.static


class Frictionless(NamedTuple):
    """No friction: the coefficient is zero."""

    zero: float = 0.0

    @classmethod
    def of(cls, contact: ContactLaw) -> Frictionless:
        """It needs nothing of these parameters (but machine code wants no tuple to be empty)."""
        return cls()

    @staticmethod
    def coefficients(static: float, dynamic: float) -> tuple[float, float]:
        """What it makes of the two: coefficients of a foot at rest and of one that slides, where none creeps."""
        return 0.0, 0.0

    def coefficient(self, speed: Any, ops: Operations) -> Any:
        """Friction coefficient of a sliding foot."""
        return self.zero


class Stribeck(NamedTuple):
    """Friction with Adams' transitions, eq. (10) and Fig. 6: creep, static peak, fall to dynamic friction.

    Coefficients mu_s and mu_d, slip speeds v_s and v_d [m/s].
    """

    static: float
    dynamic: float
    stiction_velocity: float
    friction_velocity: float

    @classmethod
    def of(cls, contact: ContactLaw) -> Stribeck:
        """The numbers of these parameters."""
        return cls(
            contact.static_friction, contact.dynamic_friction, contact.stiction_velocity, contact.friction_velocity
        )

    @staticmethod
    def coefficients(static: float, dynamic: float) -> tuple[float, float]:
        """What it makes of the two: coefficients of a foot at rest and of one that slides, where none creeps."""
        return static, dynamic

    def coefficient(self, speed: Any, ops: Operations) -> Any:
        """Friction coefficient of a sliding foot: STEP from mu_s at v_s to mu_d at v_d, and mu_d beyond."""
        if self.dynamic == self.static:
            return self.static
        width, fall = self.friction_velocity - self.stiction_velocity, self.static - self.dynamic
        return self.static - ops.step(speed - self.stiction_velocity, width, fall)


class Impact(NamedTuple):
    """Normal force of the Adams IMPACT function, eq. (9): a hardening spring and a damper that grows with depth.

    Stiffness k_c [N/m^e], exponent e, damping c_max [N s/m] and the depth d [m] at which it is complete.
    """

    stiffness: float
    exponent: float
    damping: float
    depth: float

    @classmethod
    def of(cls, contact: ContactLaw) -> Impact:
        """The numbers of these parameters."""
        return cls(contact.stiffness_si, contact.contact_exponent, contact.contact_damping, contact.damping_depth)

    def damping_under(self, load: float) -> float:
        """Damping [N s/m] of a foot that has sunk in: the largest, whatever its load [N]."""
        return self.damping

    def force(self, penetration: Any, rate: Any, ops: Operations) -> Any:
        """Normal force [N] at a penetration [m] and its rate [m/s]: max(0, k_c p^e + STEP(p, 0, 0, d, c_max) dp/dt).

        The maximum is part of Adams' function; eq. (9) omits it, and without it the ground would pull at lift-off.
        """
        spring = self.stiffness * ops.power(ops.maximum(penetration, 0.0), self.exponent)
        return ops.maximum(spring + ops.step(penetration, self.depth, self.damping) * rate, 0.0)


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
    """Normal force that returns a stated part of the impact speed: Hunt-Crossley damping set by the restitution.

    Stiffness k_c [N/m^e], exponent e, damping factor a [s/m]. Damping is proportional to the spring force:
    F = k_c p^e (1 + a dp/dt). Such an impact has a closed solution, whatever the mass, stiffness and exponent. A mass
    that arrives with speed v leaves with speed w where, with x = a v and y = a w, x - ln(1 + x) = -y - ln(1 - y).
    The factor a is chosen so that w = restitution * v at `impact_speed`. Adams offers a law of this name too but does
    not print its formula; this one keeps the promise of the name.
    """

    stiffness: float
    exponent: float
    factor: float

    @classmethod
    def of(cls, contact: ContactLaw) -> Restitution:
        """The numbers of these parameters."""
        factor = damping_factor(contact.restitution, contact.impact_speed)
        return cls(contact.stiffness_si, contact.contact_exponent, factor)

    def damping_under(self, load: float) -> float:
        """Damping [N s/m] of a foot at rest under a load [N], with which it grows."""
        return self.factor * load

    def force(self, penetration: Any, rate: Any, ops: Operations) -> Any:
        """Normal force [N] at a penetration [m] and its rate [m/s]: k_c p^e max(0, 1 + a dp/dt)."""
        spring = self.stiffness * ops.power(ops.maximum(penetration, 0.0), self.exponent)
        return spring * ops.maximum(1.0 + self.factor * rate, 0.0)


#: `force(penetration, rate, ops)` [N], never negative, and zero out of contact: penetration [m] is positive in contact,
#: its rate in m/s. At rest every law carries eq. (9)'s spring force k_c p^e.
NORMAL_FORCES: dict[str, Any] = {"impact": Impact, "restitution": Restitution}
#: `coefficient(speed, ops)` of a foot that slides with this speed [m/s], not negative. Below the stiction velocity each
#: law lets the foot creep alike, see `stages.ground.friction`. `coefficients` is what is left without creep.
FRICTIONS: dict[str, Any] = {"stribeck": Stribeck, "coulomb": Coulomb, "none": Frictionless}


def has(friction: str, number: str) -> bool:
    """Whether a law of friction has this number; a name that is no law's has none."""
    return number in getattr(FRICTIONS.get(friction), "_fields", ())


class PointLaw(NamedTuple):
    """The chosen laws in numbers, as they act at one contact point."""

    normal: Any
    friction: Any
    stiction_velocity: float
