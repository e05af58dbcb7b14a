"""No friction at any slip."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from stages.ground.contact_law import ContactLaw
    from stages.ground.operations import Operations


class Frictionless(NamedTuple):
    """The coefficient, which is zero (machine code wants no tuple to be empty)."""

    zero: float = 0.0

    @classmethod
    def of(cls, contact: ContactLaw) -> Frictionless:
        """Nothing of these parameters."""
        return cls()

    def coefficient(self, speed: Any, ops: Operations) -> Any:
        """Friction coefficient of a sliding foot."""
        return self.zero
