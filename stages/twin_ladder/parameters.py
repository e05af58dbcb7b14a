"""Settings of the ladder from the simple model to the twin."""

from dataclasses import dataclass
from typing import ClassVar

from stages.analytic.parameters import Settings as AnalyticSettings
from stages.biped.accuracy.scales import Following, followed, outsole
from stages.biped.accuracy.tolerances import CLOSER
from stages.biped.quantity import Bound, parameter
from stages.ground.contact_law import OnGround
from stages.ground.slope import Friction
from stages.multibody.parameters import Settings as PlanarSettings
from stages.twin.parameters import Settings as TwinSettings


@dataclass(frozen=True)
class Settings:
    """How each rung's gait is found, and what the last rung adds to the twin."""

    FILE: ClassVar[str] = "twin_ladder"

    outsole: Following = parameter(
        "m", "rubber on the feet, the variant after the twin; null: 2 mm for Table 1's robot",
        bound=Bound(above=0))
    tolerance: float = parameter(
        "1", "absolute tolerance of the solver in m, rad, m/s, rad/s",
        bound=Bound(minimum=1e-11, maximum=1e-6), closer=CLOSER)
    difference: float = parameter(
        "1", "step of the finite differences out of the plane, in the section's scales",
        bound=Bound(minimum=1e-5, maximum=1e-1))
    sideways: bool = parameter("-", "multipliers of roll, yaw and sideways motion as well")


@dataclass(frozen=True)
class Parameters(OnGround):
    """All parameters the stage uses."""

    friction: Friction
    analytic: AnalyticSettings
    planar: PlanarSettings
    twin: TwinSettings
    settings: Settings

    def __post_init__(self) -> None:
        """What is null follows the robot."""
        object.__setattr__(self, "settings", followed(self.settings, outsole=outsole(self.biped)))
