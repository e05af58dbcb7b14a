"""Coulomb friction: one coefficient, whatever the slip; or none."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from stages.ground.contact_law import ContactLaw
    from stages.ground.operations import Operations


class Coulomb(NamedTuple):
    """The coefficient mu_s."""

    static: float

    @classmethod
    def of(cls, contact: ContactLaw) -> Coulomb:
        """The number of these parameters."""
        return cls(contact.static_friction)

    def coefficient(self, speed: Any, ops: Operations) -> Any:
        """Friction coefficient of a sliding foot."""
        return self.static


class Frictionless(NamedTuple):
    """The coefficient, which is zero."""

    zero: float = 0.0

    @classmethod
    def of(cls, contact: ContactLaw) -> Frictionless:
        """It needs nothing of these parameters (but machine code wants no tuple to be empty)."""
        return cls()

    def coefficient(self, speed: Any, ops: Operations) -> Any:
        """Friction coefficient of a sliding foot."""
        return self.zero
