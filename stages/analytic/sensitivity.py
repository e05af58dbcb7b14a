"""How the largest multiplier answers to each design parameter: is the design at a stability optimum?"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from stages.analytic.gait_search import by_stability
from stages.analytic.poincare import fixed_point
from stages.analytic.walker import Vector, build_walker
from stages.biped.design import Biped
from stages.biped.quantity import quantity
from stages.ground.slope import Slope

DESIGN = ("hip_mass", "foot_mass", "leg_length", "foot_radius", "foot_com", "stiffness", "damping")


@dataclass(frozen=True)
class Variation:
    """One design parameter changed alone, by the same share down and up."""

    name: str = quantity("-", "design parameter")
    change: float = quantity("1", "relative change")
    multiplier_below: float = quantity("1", "largest multiplier with the parameter lowered; NaN without a gait")
    multiplier_above: float = quantity("1", "largest multiplier with the parameter raised; NaN without a gait")


def largest_multiplier(biped: Biped, slope: Slope, z: Vector, tolerance: float) -> float:
    """Largest multiplier of the gait near section coordinates `z`; NaN if Newton's method does not find one there."""
    point = fixed_point(build_walker(biped, slope), z, tolerance)
    return by_stability(point) if point is not None else float("nan")


def vary_design(biped: Biped, slope: Slope, z: Vector, tolerance: float, change: float = 0.05) -> tuple[Variation, ...]:
    """The largest multiplier with each design parameter lowered and raised by `change`, the others fixed."""

    def with_factor(name: str, factor: float) -> float:
        changed = dataclasses.replace(biped, **{name: getattr(biped, name) * factor})
        return largest_multiplier(changed, slope, z, tolerance)

    names = [name for name in DESIGN if not (biped.legs == "rigid" and name in ("stiffness", "damping"))]
    return tuple(Variation(name, change, with_factor(name, 1 - change), with_factor(name, 1 + change)) for name in names)
