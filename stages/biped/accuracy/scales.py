"""The scales of a design: its own mass, length and time, which all that has no value of its own follows.

Two robots are similar if one's lengths, times and masses are those of the other times three numbers. Measured in their
own scales they have the same numbers, so tolerances, windows, rates and steps that are given in these mean the same for
every size of robot and for every gravity. Settings that are null follow the robot: what was chosen for Table 1's, in
each one's own time and size; rates go with its quickness, sensed forces go with gravity.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from stages.biped.design import Biped

#: Powers of mass, length and time in a unit's parts.
PARTS = {
    "kg": (1, 0, 0), "m": (0, 1, 0), "mm": (0, 1, 0), "s": (0, 0, 1), "Hz": (0, 0, -1), "N": (1, 1, -2),
    "J": (1, 2, -2), "rad": (0, 0, 0), "deg": (0, 0, 0), "1": (0, 0, 0), "-": (0, 0, 0),
}  # fmt: skip

S = TypeVar("S")


@lru_cache
def powers(unit: str, exponent: complex = 1.0) -> tuple[complex, ...]:
    """Powers of mass, length and time in a unit as "N s/m"; `exponent` is the e of "N/mm^e". Raises KeyError."""
    total: list[complex] = [0, 0, 0]
    above, _, below = unit.partition("/")
    for sign, part in ((1, above), (-1, below)):
        for token in part.split():
            name, _, power = token.partition("^")
            times = sign * (exponent if power == "e" else float(power or 1))
            total = [one + times * other for one, other in zip(total, PARTS[name], strict=True)]
    return tuple(total)


@dataclass(frozen=True)
class Scales:
    """A mass [kg], a length [m] and a time [s]; what any other unit is follows from them."""

    mass: float
    length: float
    time: float

    def size(self, unit: str, exponent: complex = 1.0) -> Any:
        """One of these scales' own in a unit: the speed for "m/s", the force for "N". Raises KeyError."""
        mass, length, time = powers(unit, exponent)
        return self.mass**mass * self.length**length * self.time**time

    def measure(self, section: S) -> S:
        """Parameters of a file with every number in these scales; a stiffness of the ground as if these were SI's."""
        given: Any = section
        exponent = getattr(given, "contact_exponent", 1.0)
        measured: S = replace(given, **{
            field.name: value / self.size(field.metadata["unit"], exponent) for field in fields(given)
            if isinstance(value := getattr(given, field.name), float | complex)})  # fmt: skip
        return measured


#: The scales of the units themselves.
SI = Scales(1.0, 1.0, 1.0)


def from_to(one: Scales, other: Scales) -> Scales:
    """The scales by which what is measured is as large in the `other` ones as it was in `one`."""
    return Scales(one.mass / other.mass, one.length / other.length, one.time / other.time)


def scales_of(biped: Biped, gravity: float) -> Scales:
    """Of a design under gravity [m/s^2]: whole mass, first leg's length, pendulum time sqrt(leg length / gravity)."""
    return Scales(biped.total_mass, biped.leg_length, math.sqrt(biped.leg_length / gravity))


#: Type of a number, or of several, that may be null in its file and is one wherever it is used.
if TYPE_CHECKING:
    Following: TypeAlias = float
    Followings: TypeAlias = tuple[float, ...]
else:
    Following, Followings = float | None, tuple[float, ...] | None
#: Leg length [m] and a leg's mass [kg] of Table 1, and the gravity [m/s^2] under which settings were chosen for it.
LEG_LENGTH, FOOT_MASS, GRAVITY = 0.333, 0.335, 9.81
#: Pendulum time [s] of Table 1's, and its scales.
TIME = math.sqrt(LEG_LENGTH / GRAVITY)
TABLE_1 = Scales(0.316 + 2 * FOOT_MASS, LEG_LENGTH, TIME)


def quickness(biped: Biped, gravity: float) -> float:
    """How many times as quick as Table 1's a pendulum as long as a robot's leg is; one for Table 1's own."""
    return TIME / scales_of(biped, gravity).time


def size(biped: Biped) -> float:
    """How many times as long as Table 1's a robot's leg is; one for Table 1's own."""
    return biped.leg_length / LEG_LENGTH


def outsole(biped: Biped) -> float:
    """Thickness [m] of an outsole where none is given: 2 mm of Table 1's leg, and no larger a share of its mass."""
    return 2e-3 * min(size(biped), biped.foot_mass / FOOT_MASS)


def followed(section: S, **values: float | tuple[float, ...]) -> S:
    """Parameters of a file with these values in place of nulls."""
    given: dict[str, object] = {key: value for key, value in values.items() if getattr(section, key) is None}
    return replace(section, **given)  # type: ignore[type-var]


def similar(section: S, of_table_1: Mapping[str, float | tuple[float, ...]], own: Scales, exponent: float = 1.0) -> S:
    """Parameters of a file with values in place of nulls: as large in a robot's `own` scales as those given are in
    Table 1's. `exponent` is the e of "N/mm^e"."""
    given: Any = section
    units = {field.name: field.metadata["unit"] for field in fields(given)}

    def grown(unit: str, value: float | tuple[float, ...]) -> float | tuple[float, ...]:
        by = own.size(unit, exponent) / TABLE_1.size(unit, exponent)
        return tuple(by * one for one in value) if isinstance(value, tuple) else by * value

    return followed(section, **{name: grown(units[name], value) for name, value in of_table_1.items()})
