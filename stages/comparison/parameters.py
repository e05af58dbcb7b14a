"""Settings of the comparison."""

from dataclasses import dataclass

from stages.analytic.parameters import Rounded, Settings as ConstraintSettings
from stages.biped.accuracy.scales import scales_of
from stages.biped.quantity import Bound, parameter
from stages.calibration.parameters import Settings as CalibrationSettings
from stages.campaign.parameters import RadioSettings, RunSettings, SensorSettings
from stages.comparison.claims.paper import (
    Limits,
)
from stages.contact_study.parameters import Settings as StudySettings
from stages.error_budget.parameters import Settings as BudgetSettings
from stages.ground.blocks import Blocks
from stages.ground.contact_law import DefaultSet, OnGround
from stages.imu.parameters import Drawing, Limits as IngestLimits, Settings as IngestSettings
from stages.multibody.parameters import Settings as PlanarSettings
from stages.rough_ground.parameters import Settings as RoughSettings
from stages.tradeoff.parameters import Settings as TradeoffSettings
from stages.twin.parameters import Settings as TwinSettings
from stages.twin_ladder.parameters import Settings as LadderSettings
from stages.twin_pushes.parameters import Settings as PushSettings


@dataclass(frozen=True)
class Settings(Limits):
    """What counts as agreement."""

    frequency_tolerance: float = parameter(
        "1", "largest relative difference of step frequencies called equal", bound=Bound(above=0, maximum=1)
    )
    similarity_limit: float = parameter(
        "1",
        "rms difference over range below which two curves are called nearly identical",
        bound=Bound(above=0, maximum=1),
    )
    hip_path_share: float = parameter(
        "1", "error of the hip's way that is considerable, of the way", bound=Bound(above=0, maximum=1)
    )
    enclosure_share: float = parameter(
        "1",
        "share of the stride from which the measurements are said to enclose a curve",
        bound=Bound(above=0, maximum=1),
    )
    unaffected_limit: float = parameter(
        "1", "relative change of a gait that counts as none", bound=Bound(above=0, maximum=1)
    )
    small_change: float = parameter("1", "factor on a parameter that is a small change", bound=Bound(above=1))
    moderate_change: float = parameter("1", "factor on a parameter that is a moderate change", bound=Bound(above=1))
    multiplier_gain: float = parameter(
        "1", "part by which a better design lowers the largest multiplier", bound=Bound(above=0, below=1)
    )
    drift_limit: float = parameter(
        "1", "drift of a constraint that is more than an integration error, in leg lengths and pendulum times",
        bound=Bound(above=0),
    )
    impact_share: float = parameter(
        "1", "largest part of a step that may count as impact", bound=Bound(above=0, maximum=1)
    )
    passing_chance: float = parameter(
        "1", "chance of a walk over the ramp from which its blocks are good enough", bound=Bound(above=0, below=1))
    skipped_steps: int = parameter(
        "1", "heel strikes of the twin left out where runs are compared with it", bound=Bound(minimum=0, maximum=100)
    )


@dataclass(frozen=True)
class Parameters(Rounded, OnGround):
    """Parameters of the comparison stage: its own, and those of all stages above it, which claims rest on."""

    constraint: ConstraintSettings
    planar: PlanarSettings
    default: DefaultSet
    study: StudySettings
    budget: BudgetSettings
    twin: TwinSettings
    pushes: PushSettings
    rough: RoughSettings
    tradeoff: TradeoffSettings
    runs: RunSettings
    sensor: SensorSettings
    radio: RadioSettings
    calibration: CalibrationSettings
    ladder: LadderSettings
    ingest: IngestSettings
    ingest_limits: IngestLimits
    drawing: Drawing
    settings: Settings
    blocks: Blocks = Blocks()

    def __post_init__(self) -> None:
        """Sizes that are null follow the robot."""
        own = scales_of(self.biped, self.slope.gravity)
        object.__setattr__(self, "default", self.default.of(own))
        object.__setattr__(self, "pushes", self.pushes.of(own))
