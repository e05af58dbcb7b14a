"""The results that both the comparison and the figures are made from."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from stages.analytic.result import Result as Analytic
from stages.calibrated_twin.result import Result as CalibratedTwin
from stages.contact_study.result import Result as ContactStudy
from stages.error_budget.result import Result as ErrorBudget
from stages.imu.result import Result as Ingested
from stages.multibody.result import Result as Multibody
from stages.rough_ground.result import Result as RoughGround
from stages.tradeoff.result import Result as Tradeoff
from stages.twin.result import Result as Twin
from stages.twin_ladder.result import Result as TwinLadder
from stages.twin_pushes.result import Result as TwinPushes


@dataclass(frozen=True)
class Results:
    """Results of stages. Those that are not there are None, and `missing` says why."""

    analytic: Analytic
    multibody: Multibody
    contact_study: ContactStudy
    error_budget: ErrorBudget
    twin: Twin
    twin_ladder: TwinLadder
    twin_pushes: TwinPushes
    rough_ground: RoughGround
    tradeoff: Tradeoff
    calibrated_twin: CalibratedTwin
    imu: Ingested
    missing: Mapping[str, str] = field(default_factory=dict, kw_only=True)
