"""Settings of what becomes of the gait on other slopes and from other starts."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from stages.analytic.parameters import Settings as AnalyticSettings
from stages.biped.accuracy.tolerances import CLOSER
from stages.biped.quantity import Bound, Broken, broken, parameter
from stages.ground.blocks import Blocks
from stages.ground.slope import Friction, OnSlope


@dataclass(frozen=True)
class Settings:
    """Ranges as shares of the design's own slope and of the gait's own start, so that they fit another biped."""

    FILE: ClassVar[str] = "stability"

    slope_from: float = parameter("1", "least slope, over the design's", bound=Bound(above=0, maximum=1))
    slope_to: float = parameter("1", "largest slope, over the design's", bound=Bound(minimum=1, maximum=100))
    doublings: int = parameter("1", "period doublings to follow", bound=Bound(minimum=0, maximum=4))
    gait_distance: float = parameter(
        "1", "largest distance of two gaits of a family, in section coordinates and the range of slopes",
        bound=Bound(minimum=1e-3, maximum=0.5))
    tolerance: float = parameter(
        "1", "tolerance of a step of the families, in leg lengths and pendulum times",
        bound=Bound(minimum=1e-13, maximum=1e-9), closer=CLOSER)
    angle_from: float = parameter("1", "least stance angle of a start, over the gait's", bound=Bound(above=0))
    angle_to: float = parameter("1", "largest stance angle of a start, over the gait's", bound=Bound(above=0))
    rate_from: float = parameter("1", "least stance rate of a start, over the gait's", bound=Bound(minimum=0))
    rate_to: float = parameter("1", "largest stance rate of a start, over the gait's", bound=Bound(above=0))
    starts: int = parameter("1", "starts a side of the grid", bound=Bound(minimum=2, maximum=2000))
    most_steps: int = parameter("1", "most steps of a walk", bound=Bound(minimum=2, maximum=10_000))

    def broken_rules(self) -> Iterator[Broken]:
        """Ranges rise."""
        return broken((not self.angle_from < self.angle_to, "angle_to", "more than angle_from"),
                      (not self.rate_from < self.rate_to, "rate_to", "more than rate_from"))  # fmt: skip


@dataclass(frozen=True)
class Parameters(OnSlope):
    """All parameters the stage uses."""

    friction: Friction
    analytic: AnalyticSettings
    settings: Settings
    blocks: Blocks = Blocks()
