"""An error asked for, turned into solver settings by the kept table of what was measured.

The kept table of errors and costs is measured by benchmarks/tradeoff.py for the study's own design and ground, over a
few steps. The hip's error grows with the steps walked, so a longer walk is given a tighter setting. Settings are those
that were measured: the cheapest that keeps the error, none in between.

Of the stages that solve, `FILES` have the key. `campaign` and `twin_pushes` walk other machines and starts than the
table's, `contact_study` and `extremes` other grounds, `twin_ladder` needs differences, `error_budget` varies the
tolerance itself: the table says nothing of them, and they keep tolerances of their own.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from stages.biped.accuracy import DRAFT, PAPER, REFERENCE

TABLE = Path(__file__).with_name("table.json")
#: Parameter files whose settings an accuracy decides; each is its stage's name.
FILES = ("analytic", "multibody", "twin")
#: What may be asked for: key -> (error in the table, whether it grows with the steps walked).
KEYS = {"hip_position_m": ("hip_position", True), "period_s": ("period", False),
        "multiplier": ("multiplier", False), "peak_force_n": ("peak_force", False)}  # fmt: skip
#: The errors that the words stand for; that of `paper` is in the table.
ERRORS = {DRAFT: {"hip_position_m": 1e-3}, REFERENCE: {"hip_position_m": 1e-8}}
#: Settings are taken that were measured this much better than asked: errors of adaptive steps scatter, and a stage
#: starts from a gait that has an error of its own. At 2 the analytic stage missed 5e-6 m by a factor 1.4.
MARGIN = 4.0

Row = dict[str, Any]


class NotMeasured(ValueError):
    """No measured setting is as accurate as asked; the second half of a sentence."""


@dataclass(frozen=True)
class Second:
    """Another measured setting of the same way, to be walked beside the chosen one.

    `budget` is its cost, `error_ratio` its error, both over the chosen one's; the errors are taken to go with the
    solver's tolerance, or step, to the power `order` that the table shows.
    """

    settings: Mapping[str, float]
    budget: float
    order: float
    error_ratio: float

    def estimate(self, difference: float) -> float:
        """Error of the chosen setting, given how far both walks differ."""
        return difference / abs(self.error_ratio - 1.0)


@dataclass(frozen=True)
class Choice:
    """Settings of one stage for the errors asked for, the hip's error expected of them [m], and how to verify it."""

    stage: str
    asked: Mapping[str, float]
    settings: Mapping[str, float]
    expected: float
    evaluations: float
    second: Second | None


def choose(stage: str, settings: Any) -> Choice:
    """What the accuracy in a stage's settings decides. Raises `NotMeasured`."""
    rows, walked = _rows()
    model, way, keys = _way(stage, vars(settings))
    mine = [row for row in rows if row["model"] == model and row["way"] == way]
    asked = settings.accuracy
    wanted = _by_word(asked, rows, model) if isinstance(asked, str) else asked.errors
    longer = max(1.0, float(settings.steps) / walked)
    said = asked if isinstance(asked, str) else _text(wanted)

    def found(row: Row, key: str) -> float:
        name, grows = KEYS[key]
        value = row["errors"][name]
        return math.inf if value is None else float(value) * MARGIN * (longer if grows else 1.0)

    for key, error in wanted.items():
        least = min((found(row, key) for row in mine), default=math.inf)
        if least > error:
            can = f"allowed: >= {least:.1g}" if math.isfinite(least) else "its error was not measured"
            raise NotMeasured(f"= {said}: stage {stage} cannot have {key} <= {error:g}; {can}")
    good = [row for row in mine if all(found(row, key) <= error for key, error in wanted.items())]
    if not good:
        raise NotMeasured(f"= {said}: stage {stage} has no measured setting with all these errors at once")
    best = min(good, key=lambda row: (row["evaluations"], row["errors"]["hip_position"]))
    expected = float(best["errors"]["hip_position"]) * longer
    return Choice(stage, dict(wanted), _settings(best, keys), expected, best["evaluations"], _second(best, mine, keys))


def decided(stage: str, values: Mapping[str, Any]) -> tuple[str, ...]:
    """Which settings of a stage its accuracy decides; `values` are all of its settings."""
    return _way(stage, values)[2]


@cache
def _rows() -> tuple[tuple[Row, ...], int]:
    table = json.loads(TABLE.read_text(encoding="utf-8"))
    return tuple(row for row in table["rows"] if row["outcome"] == "completed"), int(table["walked_steps"])


def _by_word(word: str, rows: tuple[Row, ...], model: str) -> Mapping[str, float]:
    """The error a word stands for; `paper` is what the paper's own setting, or what stands in for it, was measured."""
    if word != PAPER:
        return ERRORS[word]
    marked = [row["errors"]["hip_position"] for row in rows if row["model"] == model and PAPER in row["mark"]]
    rolling = [row["errors"]["hip_position"] for row in rows if "rolling" in row["model"] and PAPER in row["mark"]]
    return {"hip_position_m": float((marked or rolling)[0])}


def _second(best: Row, rows: list[Row], keys: tuple[str, ...]) -> Second | None:
    """The most accurate setting at no more than half the cost; where none is, the next more accurate one."""
    at = keys[0]
    held = [(_settings(row, keys), row) for row in rows if keys[1:] != ("largest_step",)
            or _settings(row, keys)["largest_step"] == _settings(best, keys)["largest_step"]]  # fmt: skip
    sizes = [math.log(settings[at]) for settings, _ in held]
    errors = [math.log(row["errors"]["hip_position"]) for _, row in held]
    others = [(settings, row) for settings, row in held if settings[at] != _settings(best, keys)[at]]
    cheap = [pair for pair in others if pair[1]["evaluations"] <= 0.5 * best["evaluations"]]
    finer = [pair for pair in others if pair[0][at] < _settings(best, keys)[at]]
    if not cheap and not finer:
        return None
    from statistics import linear_regression

    order = linear_regression(sizes, errors).slope
    settings, row = (min(cheap, key=lambda pair: pair[1]["errors"]["hip_position"]) if cheap
                     else max(finer, key=lambda pair: pair[0][at]))  # fmt: skip
    ratio = (settings[at] / _settings(best, keys)[at]) ** order
    return Second(settings, row["evaluations"] / best["evaluations"], order, ratio)


def _settings(row: Row, keys: tuple[str, ...]) -> dict[str, float]:
    """The row's settings under the names of the stage's parameters."""
    pairs = dict(part.rsplit(" ", 1) for part in row["setting"].split(", "))
    return {key: float(pairs[key]) for key in keys}


def _text(asked: Mapping[str, float]) -> str:
    return "{" + ", ".join(f"{key}: {value:g}" for key, value in asked.items()) + "}"


def _way(stage: str, values: Mapping[str, Any]) -> tuple[str, str, tuple[str, ...]]:
    """Model and way in the table, and the settings that the way has."""
    if stage == "analytic":
        return f"constraint model, {values['transition']}", "compiled", ("tolerance",)
    if stage == "twin":
        return "twin", "Exudyn tree in space, DOPRI5", ("tolerance", "largest_step")
    if values["assembly"] == "tree":
        return "penalty model", "Exudyn tree, DOPRI5", ("tolerance", "largest_step")
    way = f"Exudyn joints, {values['implicit_solver'].replace('_', ' ')}"
    return "penalty model", way, ("rolling_step", "impact_step")
