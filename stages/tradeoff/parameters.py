"""Settings of the study of speed against accuracy."""

from dataclasses import dataclass
from typing import ClassVar

from stages.analytic.parameters import Settings as ConstraintSettings
from stages.biped.quantity import Bound, parameter
from stages.ground.contact_law import OnGround
from stages.multibody.parameters import Settings as PlanarSettings
from stages.twin.parameters import Settings as TwinSettings


@dataclass(frozen=True)
class Settings:
    """How much is measured."""

    FILE: ClassVar[str] = "tradeoff"

    resolution: str = parameter(
        "-", "few: what claims rest on; coarse: some settings of each way; full: all of them, with the penalty model's "
        "multipliers and a detailed design", choices=("few", "coarse", "full"))
    walked_steps: int = parameter("1", "steps over which errors are taken", bound=Bound(minimum=2, maximum=20))


@dataclass(frozen=True)
class Parameters(OnGround):
    """All parameters the stage uses; the settings of the three models say which way is their default."""

    constraint: ConstraintSettings
    planar: PlanarSettings
    twin: TwinSettings
    settings: Settings
