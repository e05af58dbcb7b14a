"""How a gait answers to each design parameter, and to rubber under the feet: its length and width, and its mass."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

from stages.analytic.gait.gait_search import by_stability
from stages.analytic.gait.poincare import fixed_point
from stages.analytic.model.walker import Vector, build_walker
from stages.analytic.result import OutsoleEffect, Variation
from stages.biped.design import Biped
from stages.biped.outsole.rubber import FEET, Rubber, soled
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


#: Steps of the secant method: the frequency is nearly linear in the mass, each leaves less than a hundredth.
ROUNDS = 4


def outsole_effect(near: Neighbours, rubber: Rubber, thickness: float) -> OutsoleEffect:
    """The gait with `thickness` [m] of rubber under the feet."""
    mass = FEET * rubber.mass(near.biped.foot_radius, thickness)

    def frequency(of_rubber: float) -> float:
        return near.of(soled(near.biped, rubber, thickness, of_rubber))[1]

    usual = near.of(near.biped)[1]
    alone, weighed = frequency(0.0), frequency(mass)
    turning = zero_of(lambda of_rubber: frequency(of_rubber) - usual, (0.0, alone - usual), (mass, weighed - usual))
    return OutsoleEffect(thickness, mass, alone, weighed, turning)


def zero_of(change: Callable[[float], float], first: tuple[float, float], second: tuple[float, float]) -> float:
    """Where a nearly linear function of a mass [kg] is zero, from two masses with its values; NaN below no mass."""
    for _ in range(ROUNDS):
        if second[1] == first[1]:
            break
        root = second[0] - second[1] * (second[0] - first[0]) / (second[1] - first[1])
        if not root > 0.0:
            return math.nan
        first, second = second, (root, change(root))
    return second[0]
