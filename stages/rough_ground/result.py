"""What walks over blocks of drawn heights hand on."""

from dataclasses import dataclass

from stages.biped.quantity import quantity, written_out
from stages.stability.result import Passage

CONSTRAINT, PENALTY, TWIN = MODELS = ("constraint model", "penalty contact", "twin")


@dataclass(frozen=True)
class OnHeight(Passage):
    """One model on blocks of one rms height."""

    model: str = quantity("-", "which model walks")
    block_height_rms: float = quantity("m", "rms of the blocks' heights")

    def in_words(self) -> str:
        """The model and its steps to a fall, with their interval where one was seen."""
        low, most, high = map(written_out, (self.steps_low, self.steps_to_fall, self.steps_high))
        made = f"{most} steps to a fall ({low} to {high})" if self.falls else f"no fall in {self.walked} steps"
        return f"{self.model}, {made}"


@dataclass(frozen=True)
class DesignNorm:
    """A design with one parameter changed."""

    parameter: str = quantity("-", "which parameter is changed, as file and key")
    share: float = quantity("1", "factor on its value")
    sensitivity_norm: float = quantity("s/m", "gait sensitivity norm; NaN where no stable gait is found")


@dataclass(frozen=True)
class Reached(Passage):
    """The design of the least gait sensitivity norm within a bound on its speed, on blocks of one rms height."""

    block_height_rms: float = quantity("m", "rms of the blocks' heights")
    speed_share: float = quantity("1", "by how much its speed may differ from the given design's, as a share")
    speed: float = quantity("m/s", "its speed")
    sensitivity_norm: float = quantity("s/m", "its gait sensitivity norm")
    stopped_by: str = quantity("-", "bounds that it lies on: speed, or a parameter and which")
    met: bool = quantity("-", "whether its speed is within the bound")


@dataclass(frozen=True)
class Result:
    """How long walks last on blocks, and what the design does to the spread of steps."""

    passages: tuple[OnHeight, ...] = quantity("-", "steps to a fall by model and height")
    norms: tuple[DesignNorm, ...] = quantity("-", "gait sensitivity norm of changed designs")
    sensitivity_norm: float = quantity("s/m", "gait sensitivity norm of the design")
    front: tuple[Reached, ...] = quantity("-", "designs of the least norm over the bound on their speed", default=())

    def of(self, model: str) -> tuple[OnHeight, ...]:
        """A model's rows, from the least height."""
        return tuple(row for row in self.passages if row.model == model)

    def summary(self) -> str:
        """What was found on the least height, in one line."""
        rows = [self.of(model)[0] for model in (CONSTRAINT, PENALTY)]
        return (f"on blocks of {1e3 * rows[0].block_height_rms:.2g} mm: {'; '.join(row.in_words() for row in rows)}; "
                f"gait sensitivity norm {self.sensitivity_norm:.3g} s/m")
