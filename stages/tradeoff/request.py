"""`--accuracy`: the level of the whole study, or the largest errors of the walks, for which these are refined."""

from collections.abc import Mapping
from typing import Any

from stages.biped.accuracy.tolerances import CUSTOM, LEVEL_ERRORS, LEVELS, REFERENCE, Accuracy

#: Parameter files that have the key, each its stage's name. Other stages walk other machines, starts and grounds, or
#: take differences: they have tolerances of their own.
FILES = ("analytic", "multibody", "twin")
#: What may be requested.
KEYS = tuple(Accuracy.__annotations__)
#: The key's value with which no accuracy is requested.
FREE = CUSTOM


def level(requested: str | Mapping[str, float]) -> str:
    """The level of the study that is requested, or the least accurate one that is for such errors, else the last."""
    if isinstance(requested, str):
        return requested
    return next((name for name in LEVELS if all(LEVEL_ERRORS[name][key] <= error for key, error in requested.items())),
                REFERENCE)  # fmt: skip


def verified(requested: Accuracy, result: Any) -> dict[str, Any]:
    """The estimates in a stage's result as plain values, beside those requested."""
    return {
        "asked": requested.errors,
        "estimated": {row.name: float(f"{row.estimated:.1e}") for row in result.errors},  # it has no more digits
        "settings": result.errors[0].settings,
    }


def line(found: Mapping[str, Any]) -> str:
    """A verification in one line."""
    estimated = ", ".join(f"{key} {value:.1e}" for key, value in found["estimated"].items())
    requested = ", ".join(f"{key} {value:g}" for key, value in found["asked"].items())
    return f"{found['stage']}: asked {requested}; used {found['settings']}; estimated {estimated} (from a coarser walk)"


NAME = "accuracy"
METAVAR = "WORD|KEY=VALUE"
HELP = (
    "Level of the whole study: draft, paper or reference. Or the largest error of the walks, as hip_position_m=1e-5: "
    "each walk is refined until its own error is smaller. Overrides the files of params/."
)
VERIFY_HELP = (
    "Show the estimated errors, and keep them in results/accuracy. Every run with a requested accuracy walks a second "
    "time with coarser settings; if that does not confirm the accuracy, the command ends with 3."
)
FORM = f"{', '.join(LEVELS)}, or an error of {', '.join(KEYS)}, as in hip_position_m=1e-5"


def words() -> tuple[str, ...]:
    """What the text after the option may be, or begin with, for hints at misspelt ones."""
    return (*KEYS, *LEVELS)


def parsed(text: str) -> str | dict[str, str]:
    """The text after `--accuracy` as a level, or as the errors requested. Raises KeyError with an unknown key."""
    if text in LEVELS:
        return text
    requested = {}
    for part in text.split(","):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or key not in KEYS:
            raise KeyError(key)
        requested[key] = value
    return requested
