"""How accurate a walk is asked to be: the largest error of something that is measured.

A stage's settings hold the request beside the solver's own settings. Before the stage runs, the pipeline puts in the
solver settings that were measured to keep it on Table 1; the stage's run checks them on the design it has, and refines
them (`stages.biped.accuracy.estimate`). With `custom` they stay as they stand, at the study's level (`accuracy.level`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from stages.biped.quantity import Bound, Broken, parameter

CUSTOM = "custom"


@dataclass(frozen=True)
class Accuracy:
    """Largest errors over the walk; None: not asked for."""

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
        """The errors asked for, by their keys."""
        return {key: value for key, value in vars(self).items() if value is not None}

    def broken_rules(self) -> Iterator[Broken]:
        """Something is asked for."""
        if not self.errors:
            yield Broken("hip_position_m", "at least one of " + ", ".join(vars(self)))


def errors_asked(asked: str | Accuracy) -> dict[str, float]:
    """The errors that an accuracy stands for, by the keys of `Accuracy`; none for `custom`."""
    return {} if isinstance(asked, str) else asked.errors


def accuracy(chosen: str) -> Any:
    """The field `accuracy: str | Accuracy` of a stage's settings; `chosen` names the settings that it decides."""
    return parameter(
        "-",
        f"error asked for; it decides {chosen}, which custom leaves as given",
        choices=(CUSTOM,),
        otherwise=f"errors by {', '.join(Accuracy.__annotations__)} as {{hip_position_m: 1e-5}}",
        default=CUSTOM,
    )
