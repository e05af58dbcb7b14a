"""What a figure is, and what it is drawn from."""

from collections.abc import Callable
from dataclasses import dataclass, field

from matplotlib.figure import Figure

from stages.calibration.result import Result as Calibration
from stages.comparison.result import Result as Comparison
from stages.comparison.sources import Results
from stages.extremes.result import Result as Extremes
from stages.figures.parameters import Parameters
from stages.model_error.result import Result as ModelError
from stages.stability.result import Result as Stability


@dataclass(frozen=True)
class Inputs(Results):
    """The results of all stages."""

    stability: Stability
    model_error: ModelError
    extremes: Extremes
    calibration: Calibration
    comparison: Comparison


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
