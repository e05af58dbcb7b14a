"""Settings that are null follow the robot: what was chosen for Table 1's, in each one's own time.

Rates go with its quickness, the inverse of a pendulum's time sqrt(leg length / gravity); forces felt go with gravity.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, TypeAlias, TypeVar

from stages.biped.accuracy.scales import scales_of
from stages.biped.design import Biped

#: Type of a number that may be null in its file and is one wherever it is used.
if TYPE_CHECKING:
    Following: TypeAlias = float
else:
    Following = float | None
#: Leg length [m] and a leg's mass [kg] of Table 1, and the gravity [m/s^2] under which settings were chosen for it.
LEG_LENGTH, FOOT_MASS, GRAVITY = 0.333, 0.335, 9.81
#: Pendulum time [s] of Table 1's.
TIME = math.sqrt(LEG_LENGTH / GRAVITY)
S = TypeVar("S")


def quickness(biped: Biped, gravity: float) -> float:
    """How many times as quick as Table 1's a pendulum as long as a robot's leg is; one for Table 1's own."""
    return TIME / scales_of(biped, gravity).time


def size(biped: Biped) -> float:
    """How many times as long as Table 1's a robot's leg is; one for Table 1's own."""
    return biped.leg_length / LEG_LENGTH


def outsole(biped: Biped) -> float:
    """Thickness [m] of an outsole where none is given: 2 mm of Table 1's leg, and no larger a share of its mass."""
    return 2e-3 * min(size(biped), biped.foot_mass / FOOT_MASS)


def followed(section: S, **values: float) -> S:
    """Parameters of a file with these values in place of nulls."""
    given: dict[str, object] = {key: value for key, value in values.items() if getattr(section, key) is None}
    return dataclasses.replace(section, **given)  # type: ignore[type-var]
