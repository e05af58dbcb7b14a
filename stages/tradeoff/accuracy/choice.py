"""An error asked for, turned into solver settings by the kept table of what was measured: a proposal for other designs.

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

from stages.biped.accuracy.tolerances import CUSTOM, LEVEL_ERRORS, LEVELS, REFERENCE, errors_asked

TABLE = Path(__file__).with_name("table.json")
#: Parameter files whose settings an accuracy decides; each is its stage's name.
FILES = ("analytic", "multibody", "twin")
#: What may be asked for: key -> (error in the table, whether it grows with the steps walked).
KEYS = {"hip_position_m": ("hip_position", True), "period_s": ("period", False),
        "multiplier": ("multiplier", False), "peak_force_n": ("peak_force", False)}  # fmt: skip
#: The analytic stage takes no looser tolerance: nothing worth having is saved, a third of a millisecond a step.
LOOSEST_ANALYTIC = 1e-11
#: Settings are taken that were measured this much better than asked: errors of adaptive steps scatter, and a stage
#: starts from a gait that has an error of its own. At 2 the analytic stage missed 5e-6 m by a factor 1.4.
MARGIN = 4.0

Row = dict[str, Any]


class NotMeasured(ValueError):
    """No measured setting is as accurate as asked; the second half of a sentence."""


@dataclass(frozen=True)
class Choice:
    """Settings of one stage proposed for the errors asked for, and the hip's error expected of them on Table 1 [m]."""

    stage: str
    asked: Mapping[str, float]
    settings: Mapping[str, float]
    expected: float


def decide(stage: str, settings: Any) -> Choice | None:
    """What the accuracy in these settings of a stage's parameter file decides, None if nothing is requested.

    Raises `NotMeasured` if no measured setting is as accurate.
    """
    if settings.accuracy == CUSTOM:
        return None
    rows, walked = _rows()
    model, way, keys = _way(stage, vars(settings))
    mine = [row for row in rows if row["model"] == model and row["way"] == way]
    wanted = errors_asked(settings.accuracy)
    longer = max(1.0, float(settings.steps) / walked)
    said = "{" + ", ".join(f"{key}: {value:g}" for key, value in wanted.items()) + "}"

    def found(row: Row, key: str) -> float:
        name, grows = KEYS[key]
        value = row["errors"][name]
        return math.inf if value is None else float(value) * MARGIN * (longer if grows else 1.0)

    for key, error in wanted.items():
        least = min((found(row, key) for row in mine), default=math.inf)
        if least > error:
            can = (f"allowed: >= {least:.1g}, by what the study's own robot has" if math.isfinite(least) else
                   "its error was not measured")
            raise NotMeasured(f"= {said}: stage {stage} cannot have {key} <= {error:g}; {can}")
    good = [row for row in mine if all(found(row, key) <= error for key, error in wanted.items())]
    if not good:
        raise NotMeasured(f"= {said}: stage {stage} has no measured setting with all these errors at once")
    if stage == "analytic":
        good = [row for row in good if _settings(row, keys)["tolerance"] <= LOOSEST_ANALYTIC]
    best = min(good, key=lambda row: (row["evaluations"], row["errors"]["hip_position"]))
    expected = float(best["errors"]["hip_position"]) * longer
    return Choice(stage, dict(wanted), _settings(best, keys), expected)


def level(asked: str | Mapping[str, float]) -> str:
    """The level of the study that is requested, or the least accurate one that is for such errors, else the last."""
    if isinstance(asked, str):
        return asked
    return next((name for name in LEVELS if all(LEVEL_ERRORS[name][key] <= error for key, error in asked.items())),
                REFERENCE)  # fmt: skip


def decided(stage: str, values: Mapping[str, Any]) -> tuple[str, ...]:
    """Which settings of a stage the accuracy among them decides, none where nothing is requested; `values` are all."""
    return () if values["accuracy"] == CUSTOM else _way(stage, values)[2]


@cache
def _rows() -> tuple[tuple[Row, ...], int]:
    table = json.loads(TABLE.read_text(encoding="utf-8"))
    return tuple(row for row in table["rows"] if row["outcome"] == "completed"), int(table["walked_steps"])


def _settings(row: Row, keys: tuple[str, ...]) -> dict[str, float]:
    """The row's settings under the names of the stage's parameters."""
    pairs = dict(part.rsplit(" ", 1) for part in row["setting"].split(", "))
    return {key: float(pairs[key]) for key in keys}


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
