"""Settings of the pushes to the side."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from stages.biped.accuracy.scales import Followings, Scales, scales_of, similar
from stages.biped.accuracy.tolerances import CLOSER
from stages.biped.quantity import Bound, Broken, parameter
from stages.ground.contact_law import OnGround
from stages.twin.parameters import Settings as TwinSettings

#: Each kind of push: the key that lists its sizes, the keyword of `rolling_start`, what a reader calls it, its unit.
KINDS = (
    ("sideways_speeds", "sideways", "speed to the side", "m/s"),
    ("roll_rates", "roll_rate", "rate of roll", "rad/s"),
    ("yaw_rates", "yaw_rate", "rate of yaw", "rad/s"),
    ("yaw_angles", "yaw", "angle of yaw", "rad"),
)


#: What null is for Table 1's robot, from a touch to a fall: all sizes, and few.
OF_TABLE_1: Mapping[str, Mapping[str, tuple[float, ...]]] = {
    "all": {"sideways_speeds": (0.02, 0.05, 0.1, 0.15, 0.2), "roll_rates": (0.2, 0.5, 1.0, 2.0),
            "yaw_rates": (0.5, 2.0, 8.0), "yaw_angles": (0.05, 0.2)},
    "few": {"sideways_speeds": (0.1, 0.15), "roll_rates": (1.0, 2.0), "yaw_rates": (2.0, 8.0), "yaw_angles": (0.2,)},
}  # fmt: skip


@dataclass(frozen=True)
class Settings:
    """Sizes of the pushes, rising; a push is given once, at mid-stance, on top of the simple model's gait."""

    FILE: ClassVar[str] = "twin_pushes"

    steps: int = parameter("1", "steps to walk after a push", bound=Bound(minimum=4, maximum=1000))
    tolerance: float | None = parameter(
        "1", "absolute tolerance of the solver in m, rad, m/s, rad/s; null: ten times twin.tolerance",
        bound=Bound(minimum=1e-11, maximum=1e-4), closer=CLOSER)
    rate_hz: float = parameter("Hz", "rate of the histories", bound=Bound(above=0, maximum=1e4))
    sideways_speeds: Followings = parameter("m/s", "speeds to the side; null: as large as for Table 1's robot")
    roll_rates: Followings = parameter("rad/s", "rates of roll; null: as large as for Table 1's robot")
    yaw_rates: Followings = parameter("rad/s", "rates of yaw; null: as large as for Table 1's robot")
    yaw_angles: Followings = parameter("rad", "angles of yaw; null: as large as for Table 1's robot")
    sizes: str = parameter("-", "how many sizes of each kind a null is", choices=tuple(OF_TABLE_1), default="all")

    def of(self, own: Scales) -> Settings:
        """The pushes of a robot of these scales, which decide what is null."""
        return similar(self, OF_TABLE_1[self.sizes], own)

    def broken_rules(self) -> Iterator[Broken]:
        """Sizes are positive and rise."""
        for key, *_ in KINDS:
            sizes = getattr(self, key)
            if sizes is None:
                continue
            if not sizes or sizes[0] <= 0.0 or any(a >= b for a, b in itertools.pairwise(sizes)):
                yield Broken(key, "positive sizes, at least one, each larger than the one before")


@dataclass(frozen=True)
class Parameters(OnGround):
    """All parameters the stage uses."""

    twin: TwinSettings
    settings: Settings

    def __post_init__(self) -> None:
        """Sizes that are null follow the robot."""
        object.__setattr__(self, "settings", self.settings.of(scales_of(self.biped, self.slope.gravity)))
