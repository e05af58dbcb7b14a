"""Friction with Adams' transitions, eq. (10) and Fig. 6: creep, static peak, fall to dynamic friction."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from stages.ground.contact_law import ContactLaw
    from stages.ground.operations import Operations


class Stribeck(NamedTuple):
    """Coefficients mu_s and mu_d, slip speeds v_s and v_d [m/s]."""

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

    def coefficient(self, speed: Any, ops: Operations) -> Any:
        """Friction coefficient of a sliding foot: STEP from mu_s at v_s to mu_d at v_d, and mu_d beyond."""
        if self.dynamic == self.static:
            return self.static
        width, fall = self.friction_velocity - self.stiction_velocity, self.static - self.dynamic
        return self.static - ops.step(speed - self.stiction_velocity, width, fall)
