"""`--accuracy`: an error asked for, turned into solver settings by the kept table of errors and costs.

The table is measured by benchmarks/tradeoff.py for the study's own design and ground, over a few steps. The hip's error
grows with the steps walked, so a longer walk is given a tighter setting. Settings are those that were measured:
the cheapest that keeps the error, none in between.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from pipeline.errors import StudyError, nearest
from pipeline.parameter_value import shown

TABLE = Path(__file__).with_name("accuracy_table.json")
#: What may be asked for: key -> (error in the table, whether it grows with the steps walked).
KEYS = {"hip_position_m": ("hip_position", True), "period_s": ("period", False),
        "multiplier": ("multiplier", False), "peak_force_n": ("peak_force", False)}  # fmt: skip
DRAFT, PAPER, REFERENCE = "draft", "paper", "reference"
WORDS = {DRAFT: {"hip_position_m": 1e-3}, REFERENCE: {"hip_position_m": 1e-8}}
#: Settings are taken that were measured this much better than asked: errors of adaptive steps scatter, and a stage
#: starts from a gait that has an error of its own. At 2 the analytic stage missed 5e-6 m by a factor 1.4.
MARGIN = 4.0
_FORM = "the form is draft, paper, reference, or an error as in hip_position_m=1e-5"


@dataclass(frozen=True)
class Choice:
    """Settings of one stage for an error asked for; `half` are the most accurate at no more than half the cost."""

    stage: str
    asked: Mapping[str, float]
    settings: Mapping[str, float]
    expected: float
    half: Mapping[str, float] | None

    def texts(self, settings: Mapping[str, float]) -> tuple[str, ...]:
        """Settings as texts for `--set`."""
        return tuple(f"{self.stage}.{key}={value!r}" for key, value in settings.items())


def parsed(text: str) -> dict[str, float] | str:
    """The text after `--accuracy` as errors by key, or one of the words. Raises `StudyError`."""
    if text in (DRAFT, PAPER, REFERENCE):
        return text
    asked: dict[str, float] = {}
    for part in text.split(","):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or key not in KEYS:
            raise StudyError(f"--accuracy {text}: {_FORM}{nearest(key, [*KEYS, DRAFT, PAPER, REFERENCE])}")
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not (number > 0.0 and math.isfinite(number)):
            raise StudyError(f"--accuracy {text}: {key} = {value!r} is not a number; allowed: > 0")
        asked[key] = number
    return asked


@cache
def _rows() -> tuple[tuple[dict[str, Any], ...], int]:
    table = json.loads(TABLE.read_text(encoding="utf-8"))
    return tuple(row for row in table["rows"] if row["outcome"] == "completed"), int(table["walked_steps"])


def resolve(text: str, sections: Mapping[str, Mapping[str, Any]]) -> Iterator[Choice]:
    """Settings of each stage that the table knows, for the error asked for.

    `sections` is stage -> key -> value of the stage's own settings file. Raises `StudyError` if no measured setting
    is as accurate, with the least error that is.
    """
    asked = parsed(text)
    rows, walked = _rows()
    for stage, values in sections.items():
        if stage not in _MODELS:
            continue
        model, way, keys = _MODELS[stage](values)
        mine = [row for row in rows if row["model"] == model and row["way"] == way]
        wanted = _by_word(asked, rows, model) if isinstance(asked, str) else asked
        longer = max(1.0, float(values["steps"]) / walked)
        yield _choose(text, stage, wanted, mine, longer, keys)


def _by_word(word: str, rows: tuple[dict[str, Any], ...], model: str) -> Mapping[str, float]:
    """The error a word stands for; `paper` is what the paper's own setting, or what stands in for it, was measured."""
    if word != PAPER:
        return WORDS[word]
    marked = [row["errors"]["hip_position"] for row in rows if row["model"] == model and PAPER in row["mark"]]
    rolling = [row["errors"]["hip_position"] for row in rows if "rolling" in row["model"] and PAPER in row["mark"]]
    return {"hip_position_m": float((marked or rolling)[0])}


def _choose(text: str, stage: str, asked: Mapping[str, float], rows: list[dict[str, Any]], longer: float,
            keys: tuple[str, ...]) -> Choice:  # fmt: skip
    def found(row: dict[str, Any], key: str) -> float:
        name, grows = KEYS[key]
        value = row["errors"][name]
        return math.inf if value is None else float(value) * MARGIN * (longer if grows else 1.0)

    for key, error in asked.items():
        least = min((found(row, key) for row in rows), default=math.inf)
        if least > error:
            can = f"the least measured is {least:.1g}" if math.isfinite(least) else "its error was not measured"
            raise StudyError(f"--accuracy {text}: stage {stage} cannot have {key} <= {shown(error)}; {can}")
    good = [row for row in rows if all(found(row, key) <= error for key, error in asked.items())]
    if not good:
        raise StudyError(f"--accuracy {text}: stage {stage}: no measured setting has all these errors at once")
    best = min(good, key=lambda row: (row["evaluations"], row["errors"]["hip_position"]))
    cheap = [row for row in rows if row["evaluations"] <= 0.5 * best["evaluations"]]
    rough = min(cheap, key=lambda row: row["errors"]["hip_position"]) if cheap else None
    key = next(iter(asked))
    return Choice(stage, dict(asked), _settings(best, keys), found(best, key) / MARGIN,
                  _settings(rough, keys) if rough else None)


def _settings(row: dict[str, Any], keys: tuple[str, ...]) -> dict[str, float]:
    """The row's settings under the names of the stage's parameters."""
    pairs = dict(part.rsplit(" ", 1) for part in row["setting"].split(", "))
    return {key: float(pairs[key]) for key in keys}


def _constraint(values: Mapping[str, Any]) -> tuple[str, str, tuple[str, ...]]:
    return f"constraint model, {values['transition']}", "compiled", ("tolerance",)


def _penalty(values: Mapping[str, Any]) -> tuple[str, str, tuple[str, ...]]:
    if values["assembly"] == "tree":
        return "penalty model", "Exudyn tree, DOPRI5", ("tolerance", "largest_step")
    way = f"Exudyn joints, {values['implicit_solver'].replace('_', ' ')}"
    return "penalty model", way, ("rolling_step", "impact_step")


def _twin(_: Mapping[str, Any]) -> tuple[str, str, tuple[str, ...]]:
    return "twin", "Exudyn tree in space, DOPRI5", ("tolerance", "largest_step")


_MODELS = {"analytic": _constraint, "multibody": _penalty, "twin": _twin}
