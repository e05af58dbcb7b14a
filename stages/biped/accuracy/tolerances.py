"""The level of the study, and tolerances of the planar models.

By these stages that compare the models integrate as well, unless told otherwise.
What is compared is known no better than what it is compared with. So a stage's own key is `null`, and its parameters
say in a property what then holds: an edit, an accuracy asked for or another level reaches all that stand beside it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from stages.biped.quantity import Bound, parameter

DRAFT, PAPER, REFERENCE = LEVELS = ("draft", "paper", "reference")


@dataclass(frozen=True)
class Level:
    """The level of the study, the least accurate first: every artefact says at which it was made."""

    FILE: ClassVar[str] = "accuracy"

    level: str = parameter("-", "accuracy of the whole study", choices=LEVELS, default=PAPER)


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
        bound=Bound(minimum=FINEST, maximum=1e-3))


@dataclass(frozen=True)
class PenaltyTolerance:
    """How accurately the planar penalty model is integrated."""

    FILE: ClassVar[str] = "multibody"

    tolerance: float = parameter(
        "1", "absolute tolerance of Exudyn's solver, one number in m, rad, m/s and rad/s, whatever the robot's size",
        bound=Bound(minimum=1e-11, maximum=1e-3))


def checked(tolerance: float) -> float:
    """Tolerance at which Exudyn walks what a stage walked at `tolerance`: the difference is then the engines' own."""
    return max(scaled(tolerance, CHECKED), CHECKED_FINEST)


def scaled(tolerance: float, by: float) -> float:
    """A tolerance times a number, to twelve digits, so that ten times 1e-6 is the 1e-5 that a file would have."""
    return float(f"{tolerance * by:.12g}")
