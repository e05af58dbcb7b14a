"""What a figure is, and what it is drawn from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from matplotlib.figure import Figure

from stages.analytic.result import Result as Analytic
from stages.calibrated_twin.result import Result as CalibratedTwin
from stages.calibration.result import Result as Calibration
from stages.comparison.result import Result as Comparison
from stages.contact_study.result import Result as ContactStudy
from stages.error_budget.result import Result as ErrorBudget
from stages.extremes.result import Result as Extremes
from stages.figures.parameters import Parameters
from stages.imu.result import Result as Ingested
from stages.model_error.result import Result as ModelError
from stages.multibody.result import Result as Multibody
from stages.rough_ground.result import Result as RoughGround
from stages.stability.result import Result as Stability
from stages.tradeoff.result import Result as Tradeoff
from stages.twin.result import Result as Twin
from stages.twin_ladder.result import Result as TwinLadder
from stages.twin_pushes.result import Result as TwinPushes


@dataclass(frozen=True)
class Inputs:
    """The results of all stages. Those that are not there are None, and `missing` says why."""

    analytic: Analytic
    stability: Stability
    rough_ground: RoughGround
    multibody: Multibody
    contact_study: ContactStudy
    error_budget: ErrorBudget
    twin: Twin
    twin_ladder: TwinLadder
    model_error: ModelError
    twin_pushes: TwinPushes
    tradeoff: Tradeoff
    extremes: Extremes
    imu: Ingested
    calibration: Calibration
    calibrated_twin: CalibratedTwin
    comparison: Comparison
    missing: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Given(Inputs):
    """What one figure is given: of the results those that its entry names, and the parameters."""

    parameters: Parameters = field(kw_only=True)


@dataclass(frozen=True)
class Entry:
    """A figure: its title, its place in the report (the paper's have their number, the others follow), and its maker.

    It is given the results that `inputs` name, and no others; None for one that is missing and that it is drawn
    `without`. `draw` gives a Matplotlib figure, or a fragment of a page
    as text; `caption` says what it shows. `claims` are those that it shows something of; one that `opens` stands first
    on the page, and one `beside_parameters` above their table.
    """

    title: str
    place: int
    inputs: tuple[str, ...]
    draw: Callable[[Given], Figure | str]
    caption: Callable[[Given], str]
    claims: tuple[str, ...] = ()
    opens: bool = False
    beside_parameters: bool = False
    without: tuple[str, ...] = ()
