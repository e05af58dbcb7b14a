"""The two friction coefficients of a foot, for what needs no more of the contact law."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from stages.biped.quantity import Bound, Broken, broken, parameter


def static_friction() -> Any:
    """The parameter mu_s."""
    return parameter("1", "static friction coefficient", symbol="mu_s", bound=Bound(minimum=0))


def dynamic_friction() -> Any:
    """The parameter mu_d."""
    return parameter("1", "dynamic friction coefficient", symbol="mu_d", bound=Bound(minimum=0))


@dataclass(frozen=True)
class Friction:
    """Coulomb friction: a foot at rest holds up to mu_s F_N, a slipping foot is held back with mu_d F_N.

    The limit of the friction of eq. (10) as both its transition velocities vanish.
    """

    FILE: ClassVar[str] = "ground"

    static_friction: float = static_friction()
    dynamic_friction: float = dynamic_friction()

    def broken_rules(self) -> Iterator[Broken]:
        """Dynamic friction does not exceed static friction."""
        return broken((self.dynamic_friction > self.static_friction, "dynamic_friction",
                       f"<= static_friction = {self.static_friction:g}"))  # fmt: skip
