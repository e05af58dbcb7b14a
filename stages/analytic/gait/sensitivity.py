"""How the largest multiplier answers to each design parameter: is the design at a stability optimum?"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from stages.analytic.gait.gait_search import by_stability
from stages.analytic.gait.poincare import fixed_point
from stages.analytic.model.walker import Vector, build_walker
from stages.analytic.result import Variation
from stages.biped.design import Biped
from stages.ground.friction_coefficients import Friction
from stages.ground.slope import Slope

DESIGN = ("hip_mass", "foot_mass", "leg_length", "foot_radius", "foot_com", "stiffness", "damping")


@dataclass(frozen=True)
class Neighbours:
    """Gaits of designs near `biped`, whose own gait has section coordinates `z`."""

    biped: Biped
    slope: Slope
    z: Vector
    tolerance: float
    friction: Friction | None = None

    def of(self, biped: Biped) -> tuple[float, float]:
        """Largest multiplier and step frequency [Hz] of another design's gait; NaN if there is none."""
        walker = build_walker(biped, self.slope, self.friction)
        point = fixed_point(walker, self.z, self.tolerance)
        if point is None:
            return float("nan"), float("nan")
        return by_stability(point), 1 / (point.period * walker.time)


def vary_design(near: Neighbours, change: float = 0.05) -> tuple[Variation, ...]:
    """The gait with each design parameter lowered and raised by `change`, the others fixed."""
    biped = near.biped

    def with_factor(name: str, factor: float) -> tuple[float, float]:
        return near.of(dataclasses.replace(biped, **{name: getattr(biped, name) * factor}))

    variations = []
    for name in DESIGN:
        if biped.legs == "rigid" and name in ("stiffness", "damping"):
            continue
        below, above = with_factor(name, 1 - change), with_factor(name, 1 + change)
        variations.append(Variation(name, change, below[0], above[0], below[1], above[1]))
    return tuple(variations)
