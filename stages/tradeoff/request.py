"""`--accuracy`: the level of the whole study, or an error, which also decides solver settings of the walks shown."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from stages.biped.accuracy.tolerances import LEVELS
from stages.tradeoff.accuracy.choice import FILES, KEYS, TABLE, Choice, decide, decided, level


def verified(choice: Choice, result: Any) -> dict[str, Any]:
    """The estimates in a stage's result as plain values, beside what the table proposed."""
    return {
        "asked": dict(choice.asked),
        "proposed": dict(choice.settings),
        "table": {kind: entry["made"] for kind, entry in json.loads(TABLE.read_text())["about"].items()},
        "estimated": {row.name: float(f"{row.estimated:.1e}") for row in result.errors},  # it has no more digits
        "settings": result.errors[0].settings,
    }


def line(found: Mapping[str, Any]) -> str:
    """A verification in one line."""
    estimated = ", ".join(f"{key} {value:.1e}" for key, value in found["estimated"].items())
    asked = ", ".join(f"{key} {value:g}" for key, value in found["asked"].items())
    return f"{found['stage']}: asked {asked}; used {found['settings']}; estimated {estimated} (from a coarser walk)"


NAME = "accuracy"
METAVAR = "WORD|KEY=VALUE"
HELP = (
    "Level of the whole study: draft, paper or reference. Or the largest error of the walks, as hip_position_m=1e-5, "
    "with the level that the study's own robot needs for it. Overrides the files of params/."
)
VERIFY_HELP = (
    "Show the estimated errors, and keep them in results/accuracy. Every run with a requested accuracy walks a second "
    "time with coarser settings; if that does not confirm the accuracy, the command ends with 3."
)
FORM = f"{', '.join(LEVELS)}, or an error of {', '.join(KEYS)}, as in hip_position_m=1e-5"
__all__ = ["FILES", "FORM", "HELP", "METAVAR", "NAME", "VERIFY_HELP", "decide", "decided", "level", "line", "parsed",
           "verified", "words"]  # fmt: skip


def words() -> tuple[str, ...]:
    """What the text after the option may be, or begin with, for hints at misspelt ones."""
    return (*KEYS, *LEVELS)


def parsed(text: str) -> str | dict[str, str]:
    """The text after `--accuracy` as a level, or as the errors asked for. Raises KeyError with an unknown key."""
    if text in LEVELS:
        return text
    asked = {}
    for part in text.split(","):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or key not in KEYS:
            raise KeyError(key)
        asked[key] = value
    return asked
