"""Which measures of a gait are computed, and within which error; read without what computes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stages.biped.question import Asking, WrongOption, refuse

if TYPE_CHECKING:
    from stages.model_error.result import Result

#: Measures of a gait: name, unit, and whether an error of it is stated as a share of it. The peak force is the
#: largest normal force on a foot. The last is the largest multiplier's magnitude.
MEASURES = (
    ("period", "s", True), ("step_frequency", "Hz", True), ("step_length", "m", True), ("speed", "m/s", True),
    ("peak_force", "N", True), ("multiplier", "1", False),
)  # fmt: skip
NAMES = tuple(name for name, _, _ in MEASURES)
UNITS = {name: unit for name, unit, _ in MEASURES}
#: Why the constraint models do not have a measure.
IMPULSIVE = {"peak_force": "its heel strikes are impulses"}
#: Said where the stage has not run; with what lies in its result's place.
NOT_KNOWN = "what the models miss is not known: {}; bipedstudy run model_error learns it"


@dataclass(frozen=True)
class Allowed:
    """An error requested: a number, and whether it is a share of the measure or in its unit."""

    error: float
    share: bool


def errors(texts: Sequence[str]) -> Mapping[str, Allowed]:
    """Errors by measure of texts as "1%" or "speed=0.01"; one for all measures is under "". Raises WrongOption."""
    found: dict[str, Allowed] = {}
    for text in texts:
        name, _, number = text.rpartition("=")
        share = number.endswith("%")
        try:
            error = float(number.removesuffix("%")) * (0.01 if share else 1.0)
        except ValueError:
            error = math.nan
        refuse(
            (bool(name) and name not in NAMES, f"--within {text}: {name} is no measure; known are {', '.join(NAMES)}"),
            (not 0.0 < error < math.inf, f"--within {text}: not a positive error, as 1% or, in a measure's unit, 0.01"),
            (share and name == "multiplier", f"--within {text}: a multiplier can be 0: its error is a number, as 0.01"),
            (name in found, f"--within {text}: there is an error for {name or 'all measures'} already"),
        )
        found[name] = Allowed(error, share)
    return found


def learnt_by(asking: Asking) -> Result:
    """The stage's result among the study's. Raises WrongOption without one, or with an earlier version's."""
    from stages.model_error.result import NUMBERS

    result, where = asking.result()
    if result is not None and result.numbers.shape[1] != len(NUMBERS):
        result, where = None, "the result is of other numbers of a design"
    if result is None:
        raise WrongOption(NOT_KNOWN.format(where))
    found: Result = result
    return found


def in_digits(probability: float, digits: int) -> str:
    """A probability in words, as they follow on "a probability": no closer to zero or one than it can be known."""
    return ("above 0.999" if probability > 0.999 else "below 0.001" if probability < 0.001 else
            f"of {probability:.{digits if probability < 0.99 else 3}g}")  # fmt: skip
