"""How the largest multiplier answers to each design parameter: is the design at a stability optimum?"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from stages.analytic.gait.gait_search import by_stability
from stages.analytic.gait.poincare import fixed_point
from stages.analytic.model.walker import Vector, build_walker
from stages.biped.design import Biped
from stages.biped.quantity import quantity
from stages.ground.friction_coefficients import Friction
from stages.ground.slope import Slope

#: Name of the change that puts a layer under the feet: leg length, foot radius and height of the mass grow alike.
OUTSOLE = "outsole"
#: Its thickness over the leg length: 2 mm on the leg of Table 1.
OUTSOLE_SHARE = 0.006
DESIGN = ("hip_mass", "foot_mass", "leg_length", "foot_radius", "foot_com", "stiffness", "damping")


@dataclass(frozen=True)
class Variation:
    """One design parameter changed alone, by the same share down and up."""

    name: str = quantity("-", "design parameter, or outsole")
    change: float = quantity("1", "relative change")
    multiplier_below: float = quantity("1", "largest multiplier with the parameter lowered; NaN without a gait")
    multiplier_above: float = quantity("1", "largest multiplier with the parameter raised; NaN without a gait")
    frequency_below: float = quantity("Hz", "step frequency with the parameter lowered; NaN without a gait")
    frequency_above: float = quantity("Hz", "step frequency with the parameter raised; NaN without a gait")


def neighbour(
    biped: Biped, slope: Slope, z: Vector, tolerance: float, friction: Friction | None
) -> tuple[float, float]:
    """Largest multiplier and step frequency [Hz] of the gait near section coordinates `z`; NaN if there is none."""
    walker = build_walker(biped, slope, friction)
    point = fixed_point(walker, z, tolerance)
    if point is None:
        return float("nan"), float("nan")
    return by_stability(point), 1 / (point.steps[0].period * walker.time)


def vary_design(
    biped: Biped, slope: Slope, z: Vector, tolerance: float, friction: Friction | None = None, change: float = 0.05
) -> tuple[Variation, ...]:
    """The gait with each design parameter lowered and raised by `change`, the others fixed, and with an outsole."""

    def with_factor(name: str, factor: float) -> tuple[float, float]:
        changed = dataclasses.replace(biped, **{name: getattr(biped, name) * factor})
        return neighbour(changed, slope, z, tolerance, friction)

    def with_layer(thickness: float) -> tuple[float, float]:
        grown = {name: getattr(biped, name) + thickness for name in ("leg_length", "foot_radius", "foot_com")}
        return neighbour(dataclasses.replace(biped, **grown), slope, z, tolerance, friction)

    variations = []
    for name in DESIGN:
        if biped.legs == "rigid" and name in ("stiffness", "damping"):
            continue
        below, above = with_factor(name, 1 - change), with_factor(name, 1 + change)
        variations.append(Variation(name, change, below[0], above[0], below[1], above[1]))
    multiplier, frequency = with_layer(OUTSOLE_SHARE * biped.leg_length)
    variations.append(Variation(OUTSOLE, OUTSOLE_SHARE, float("nan"), multiplier, float("nan"), frequency))
    return tuple(variations)
