"""What the stability stage hands on."""

from dataclasses import dataclass

from stages.analytic.result import Basin, RecordedFamily
from stages.biped.quantity import count_of, quantity


@dataclass(frozen=True)
class Passage:
    """Steps to a fall on blocks of drawn heights, with intervals of 95 %."""

    steps_to_fall: float = quantity("1", "mean number of steps until the walker falls (mean first passage time)")
    steps_low: float = quantity("1", "its interval's lower end")
    steps_high: float = quantity("1", "its interval's upper end; infinite where no fall was seen")
    method: str = quantity("-", "counted, or importance sampling where falls are rare")
    falls: int = quantity("1", "falls that were counted, or as many as the weighed ones are worth")
    walked: int = quantity("1", "steps that were walked")
    ramp_steps: int = quantity("1", "steps of the ramp")
    ramp_chance: float = quantity("1", "chance to walk that many steps without a fall")
    ramp_low: float = quantity("1", "its interval's lower end")
    ramp_high: float = quantity("1", "its interval's upper end")


@dataclass(frozen=True)
class Result:
    """The gait on other slopes, and from other starts."""

    slope_deg: float = quantity("deg", "the design's slope")
    families: tuple[RecordedFamily, ...] = quantity(
        "-", "gaits over the slope [deg]: of one step, then of doubled periods; none where the gait cannot be followed")
    basin: Basin | None = quantity("-", "which starts lead to the gait; none where the gait is unstable")

    @property
    def cycle(self) -> int:
        """Fewest steps of a gait of doubled period that is stable on the design's slope; 0 without one."""
        return min((family.steps for family in self.families[1:] if family.stable_at(self.slope_deg)), default=0)

    def summary(self) -> str:
        """What was found, in one line."""
        cycles = ", ".join(f"{count_of(len(family.value), 'gait')} of cycle {family.steps}" for family in self.families)
        share = f"{100 * self.basin.share:.1f} % of the starts reach the gait" if self.basin else "the gait is unstable"
        return f"{cycles or 'no family'}; {share}"
