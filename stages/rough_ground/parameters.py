"""Settings of walks over blocks of drawn heights."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from stages.analytic.parameters import Settings as AnalyticSettings
from stages.biped.quantity import Bound, Broken, broken, parameter
from stages.ground.blocks import Blocks
from stages.ground.contact_law import OnGround
from stages.ground.slope import Friction
from stages.twin.parameters import Settings as TwinSettings


@dataclass(frozen=True)
class Settings:
    """Heights as shares of the leg, so that they fit another biped, and how far each model walks on each."""

    FILE: ClassVar[str] = "rough_ground"

    height_from: float = parameter("1", "least rms height of blocks, over the leg's length", bound=Bound(above=0))
    height_to: float = parameter("1", "largest rms height, over the leg's length", bound=Bound(above=0, maximum=0.1))
    heights: int = parameter("1", "heights, in equal ratios", bound=Bound(minimum=2, maximum=100))
    steps: int = parameter("1", "steps of the constraint model on each height", bound=Bound(minimum=100, maximum=10**8))
    penalty_steps: int = parameter(
        "1", "steps of the penalty walker on each height", bound=Bound(minimum=10, maximum=10**7))
    twin_steps: int = parameter(
        "1", "steps of the twin on each of the two largest heights", bound=Bound(minimum=2, maximum=10**5))
    ramps: int = parameter(
        "1", "walks of the constraint model over a ramp on each height; of the penalty walker a fifth",
        bound=Bound(minimum=10, maximum=10**6))
    share_to: float = parameter(
        "1", "largest factor on a parameter of the design, and least over it", bound=Bound(above=1, maximum=4))
    speed_shares: tuple[float, ...] = parameter(
        "1", "bounds on the change of speed in a search", bound=Bound(minimum=0))
    designs: int = parameter("1", "factors on each parameter", bound=Bound(minimum=3, maximum=99))

    def broken_rules(self) -> Iterator[Broken]:
        """Heights rise."""
        return broken((not self.height_from < self.height_to, "height_to", "more than height_from"))


@dataclass(frozen=True)
class Parameters(OnGround):
    """All parameters the stage uses."""

    friction: Friction
    blocks: Blocks
    analytic: AnalyticSettings
    twin: TwinSettings
    settings: Settings
