"""The plane the biped walks on, and the friction of a foot on it, for what needs no more of the ground."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, ClassVar

from stages.biped.accuracy.tolerances import Level
from stages.biped.design import Biped
from stages.biped.quantity import Bound, Broken, broken, parameter
from stages.ground.laws import FRICTIONS, has


@dataclass(frozen=True)
class Slope:
    """Inclined plane. Slope frame: x down-slope in the walking direction, y normal to the ground, z = x cross y."""

    FILE: ClassVar[str] = "ground"

    slope_deg: float = parameter("deg", "inclination, positive downhill", symbol="a", bound=Bound(minimum=0, below=90))
    gravity: float = parameter("m/s^2", "magnitude of gravity", symbol="g", bound=Bound(above=0))

    @property
    def angle(self) -> float:
        """Inclination [rad]."""
        return math.radians(self.slope_deg)

    @property
    def gravity_vector(self) -> tuple[float, float]:
        """Acceleration of gravity in the slope frame [m/s^2]: g (sin a, -cos a)."""
        return self.gravity * math.sin(self.angle), -self.gravity * math.cos(self.angle)


@dataclass(frozen=True)
class OnSlope:
    """What the parameters of a stage begin with: a biped on a slope, and the level of the study."""

    biped: Biped
    slope: Slope
    level: Level = field(default=Level(), kw_only=True)


def static_friction() -> Any:
    """The parameter mu_s."""
    return parameter("1", "static friction coefficient", symbol="mu_s", bound=Bound(minimum=0))


def dynamic_friction() -> Any:
    """The parameter mu_d."""
    return parameter("1", "dynamic friction coefficient", symbol="mu_d", bound=Bound(minimum=0))


def law_of_friction() -> Any:
    """The parameter that chooses a law."""
    return parameter("-", "law of friction", choices=tuple(FRICTIONS), default="stribeck")


@dataclass(frozen=True)
class Friction:
    """Coulomb friction: a foot at rest holds up to mu_s F_N, a slipping foot is held back with mu_d F_N.

    The limit of the friction of eq. (10) as both its transition velocities vanish; of another law, of its own.
    """

    FILE: ClassVar[str] = "ground"

    static_friction: float = static_friction()
    dynamic_friction: float = dynamic_friction()
    friction: str = law_of_friction()

    @property
    def coefficients(self) -> Friction:
        """What its law makes of the two numbers."""
        return Friction(*FRICTIONS[self.friction].coefficients(self.static_friction, self.dynamic_friction))

    def moved_by(self, name: str) -> tuple[float, float]:
        """How much both coefficients grow with one of the two numbers, which its law need not use."""
        moved: tuple[float, float] = FRICTIONS[self.friction].coefficients(
            float(name == "static_friction"), float(name == "dynamic_friction"))
        return moved

    def broken_rules(self) -> Iterator[Broken]:
        """Dynamic friction, where the law has it, does not exceed static friction."""
        return broken((has(self.friction, "dynamic") and self.dynamic_friction > self.static_friction,
                       "dynamic_friction", f"<= static_friction = {self.static_friction:g}"))  # fmt: skip
