"""Coulomb friction: one coefficient, whatever the slip."""

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
