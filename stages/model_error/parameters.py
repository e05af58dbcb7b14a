"""Settings of what each model's error is learnt from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar

from stages.analytic.parameters import DesignDigits, Rounded, Settings as AnalyticSettings, SlopeDigits
from stages.biped.design import Biped
from stages.biped.quantity import Bound, Broken, broken, parameter
from stages.ground.blocks import Blocks
from stages.ground.contact_law import OnGround
from stages.ground.slope import Friction, Slope
from stages.twin.parameters import Settings as TwinSettings


@dataclass(frozen=True)
class Settings:
    """How many designs are drawn around the study's, and of how many of them the twin's gait is found."""

    FILE: ClassVar[str] = "model_error"

    designs: int = parameter("1", "designs sampled around the study's", bound=Bound(minimum=4, maximum=10_000))
    twins: int = parameter("1", "of these, designs of which the twin's gait is found", bound=Bound(minimum=1))
    seed: int = parameter("1", "seed of the draw", bound=Bound(minimum=0))

    def broken_rules(self) -> Iterator[Broken]:
        """The twins are some of the designs."""
        return broken((self.twins > self.designs, "twins", f"<= designs = {self.designs}"))


@dataclass(frozen=True)
class Parameters(Rounded, OnGround):
    """All parameters the stage uses."""

    friction: Friction
    analytic: AnalyticSettings
    twin: TwinSettings
    settings: Settings
    blocks: Blocks = Blocks()

    def with_exact(self, biped: Biped, slope: Slope) -> Parameters:
        """These of another biped and slope, whose numbers are exact."""
        return replace(self, biped=biped, slope=slope, design_digits=DesignDigits(),
                                   slope_digits=SlopeDigits())  # fmt: skip
