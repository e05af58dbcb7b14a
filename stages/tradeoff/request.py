"""`--accuracy`: an error asked for decides the solver settings of every stage that has the key `accuracy`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stages.biped.accuracy import CUSTOM, WORDS
from stages.tradeoff.accuracy import choice
from stages.tradeoff.accuracy.choice import FILES, KEYS, Choice
from stages.tradeoff.accuracy.reached import line, verified

NAME = "accuracy"
METAVAR = "WORD|KEY=VALUE"
HELP = (
    "Solver settings of every walk for an error: draft, paper, reference, or as hip_position_m=1e-5. "
    "Goes before the key accuracy of the parameter files."
)
VERIFY_HELP = (
    "Show the errors that the run estimated, and keep them in results/accuracy. Every run that an accuracy is asked of "
    "walks a second time with coarser settings; what it cannot show to be met it refuses, and the command ends with 3."
)
FORM = "custom, draft, paper, reference, or an error as in hip_position_m=1e-5"
__all__ = ["FILES", "FORM", "HELP", "METAVAR", "NAME", "VERIFY_HELP", "decide", "decided", "line", "parsed", "verified",
           "words"]  # fmt: skip


def words() -> tuple[str, ...]:
    """What the text after the option may be, or begin with, for hints at misspelt ones."""
    return (*KEYS, *WORDS)


def parsed(text: str) -> str | dict[str, str]:
    """The text after `--accuracy` as a word, or as the errors asked for. Raises KeyError with an unknown key."""
    if text in WORDS:
        return text
    asked = {}
    for part in text.split(","):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or key not in KEYS:
            raise KeyError(key)
        asked[key] = value
    return asked


def decide(file: str, settings: Any) -> Choice | None:
    """What the accuracy in these settings of a parameter file decides, None if nothing is asked.

    Raises `NotMeasured` if no measured setting is as accurate.
    """
    return None if settings.accuracy == CUSTOM else choice.choose(file, settings)


def decided(file: str, values: Mapping[str, Any]) -> tuple[str, ...]:
    """Which of a file's plain values the accuracy among them decides; none where nothing is asked."""
    return () if values[NAME] == CUSTOM else choice.decided(file, values)
