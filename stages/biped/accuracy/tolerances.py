"""The level of the study, tolerances of the planar models, and the largest error of a walk that is requested.

A stage's settings hold the request beside the solver's own settings, which are those of the level (`accuracy.level`)
that goes with the request. The stage's run checks them on the design it has, and refines them
(`stages.biped.accuracy.estimate`). With `custom` they stay as they stand.

By the tolerances stages that compare the models integrate as well, unless set otherwise.
What is compared is known no better than what it is compared with. So a stage's own key is `null`, and its parameters
say in a property what then holds: an edit or another level reaches all that stand beside it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from stages.biped.quantity import Bound, Broken, parameter

DRAFT, PAPER, REFERENCE = LEVELS = ("draft", "paper", "reference")
#: Largest errors of the walks shown that each level is for, with Table 1's robot; every run estimates its own.
LEVEL_ERRORS = {
    level: {"hip_position_m": hip, "period_s": period, "multiplier": multiplier, "peak_force_n": force}
    for level, hip, period, multiplier, force in (
        (DRAFT, 2e-5, 3e-6, 2e-3, 5.0), (PAPER, 2e-6, 3e-7, 1e-6, 2.0), (REFERENCE, 1e-8, 1e-8, 1e-6, 0.1))
}  # fmt: skip


@dataclass(frozen=True)
class Level:
    """The level of the study, the least accurate first: every artefact says at which it was made."""

    FILE: ClassVar[str] = "accuracy"

    level: str = parameter("-", "accuracy of the whole study", choices=LEVELS, default=PAPER)


#: A stage is run once more at so many times its tolerances: what its numbers then differ by shows their errors. Looser
#: solvers show less: adaptive steps scatter, so two tolerances differ by too much or by little, by chance.
CLOSER = 0.1
#: Finest tolerance of the constraint model that is allowed.
FINEST = 1e-14
#: Engines are compared at this share of a stage's tolerance, and no finer than round-off lets Exudyn's solver go.
CHECKED, CHECKED_FINEST = 0.01, 1e-10


@dataclass(frozen=True)
class ConstraintTolerance:
    """How accurately the constraint model is integrated."""

    FILE: ClassVar[str] = "analytic"

    tolerance: float = parameter(
        "1", "absolute and relative tolerance of a step, in leg lengths and pendulum times",
        bound=Bound(minimum=FINEST, maximum=1e-3), closer=CLOSER)


@dataclass(frozen=True)
class PenaltyTolerance:
    """How accurately the planar penalty model is integrated."""

    FILE: ClassVar[str] = "multibody"

    tolerance: float = parameter(
        "1", "absolute tolerance of Exudyn's solver, one number in m, rad, m/s and rad/s, whatever the robot's size",
        bound=Bound(minimum=1e-11, maximum=1e-3), closer=CLOSER)


def checked(tolerance: float) -> float:
    """Tolerance at which Exudyn walks what a stage walked at `tolerance`: the difference is then the engines' own."""
    return max(scaled(tolerance, CHECKED), CHECKED_FINEST)


def scaled(tolerance: float, by: float) -> float:
    """A tolerance times a number, to twelve digits, so that ten times 1e-6 is the 1e-5 that a file would have."""
    return float(f"{tolerance * by:.12g}")


CUSTOM = "custom"


@dataclass(frozen=True)
class Accuracy:
    """Largest errors over the walk; None: not requested."""

    hip_position_m: float | None = parameter(
        "m", "error of the hip over the whole walk", bound=Bound(above=0), default=None
    )
    period_s: float | None = parameter("s", "error of a step's duration", bound=Bound(above=0), default=None)
    multiplier: float | None = parameter(
        "1", "error of the leading multiplier's magnitude", bound=Bound(above=0), default=None
    )
    peak_force_n: float | None = parameter(
        "N", "error of the largest normal force on a foot", bound=Bound(above=0), default=None
    )

    @property
    def errors(self) -> dict[str, float]:
        """The errors requested, by their keys."""
        return {key: value for key, value in vars(self).items() if value is not None}

    def broken_rules(self) -> Iterator[Broken]:
        """Something is requested."""
        if not self.errors:
            yield Broken("hip_position_m", "at least one of " + ", ".join(vars(self)))


def accuracy(chosen: str) -> Any:
    """The field `accuracy: str | Accuracy` of a stage's settings; `chosen` names the settings that it decides."""
    return parameter(
        "-",
        f"requested error, by which the study chooses {chosen}; custom leaves them as given",
        choices=(CUSTOM,),
        otherwise=f"errors by {', '.join(Accuracy.__annotations__)} as {{hip_position_m: 1e-5}}",
        default=CUSTOM,
        closer=CUSTOM,
    )
