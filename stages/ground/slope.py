"""The plane the biped walks on."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from stages.biped.quantity import Bound, parameter


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
