"""What rubber under the feet does to the gait: by the length and width it adds, and by its mass."""

from __future__ import annotations

import math
from collections.abc import Callable

from stages.analytic.gait.sensitivity import Neighbours
from stages.analytic.result import OutsoleEffect
from stages.biped.outsole.rubber import FEET, Rubber, soled

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
