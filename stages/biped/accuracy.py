"""How accurate a walk is asked to be: a word, or the largest error of something that is measured.

A stage's settings hold the request beside the solver's own settings. Before the stage runs, the pipeline puts in the
solver settings that were measured to keep it on Table 1; the stage's run checks them on the design it has, and refines
them (`stages.biped.error_estimate`). With `custom` they stay as they stand.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from stages.biped.quantity import Bound, Broken, parameter

CUSTOM, DRAFT, PAPER, REFERENCE = WORDS = ("custom", "draft", "paper", "reference")
#: Errors of the hip's position [m] that the words stand for. That of `paper` was measured, benchmarks/tradeoff.py: the
#: paper's setting for its constraint model, tolerance 1e-7, over four steps of Table 1.
HIP_ERRORS = {DRAFT: 1e-3, PAPER: 6e-7, REFERENCE: 1e-8}


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
    if not isinstance(asked, str):
        return asked.errors
    return {} if asked == CUSTOM else {"hip_position_m": HIP_ERRORS[asked]}


def accuracy(chosen: str) -> Any:
    """The field `accuracy: str | Accuracy` of a stage's settings; `chosen` names the settings that it decides."""
    return parameter(
        "-",
        f"error asked for; it decides {chosen}, which custom leaves as given",
        choices=WORDS,
        otherwise=f"errors by {', '.join(Accuracy.__annotations__)} as {{hip_position_m: 1e-5}}",
        default=CUSTOM,
    )
