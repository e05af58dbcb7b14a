"""Tables of results of one class side by side: a row for each field, in the units that a reader expects.

With what each accuracy of the study costs and changes, as it was measured on the study's own robot and ground.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from stages.biped.accuracy.tolerances import LEVELS
from stages.tradeoff.accuracy.choice import LEVEL_ERRORS

Table = tuple[str, tuple[str, ...], list[tuple[str, ...]]]

#: Units that tables show instead of SI ones: factor and name.
SHOWN = {"m": (1e3, "mm"), "s": (1e3, "ms")}


def side_by_side(title: str, columns: Mapping[str, Any]) -> Table:
    """A table of instances of one dataclass of numbers: (title, columns, rows of text); what is not known is empty."""
    rows = []
    for field in fields(next(iter(columns.values()))):
        factor, unit = SHOWN.get(field.metadata["unit"], (1.0, field.metadata["unit"]))
        values = (factor * float(getattr(one, field.name)) for one in columns.values())
        name = field.metadata["description"] + ("" if unit == "1" else f" [{unit}]")
        rows.append((name, *(f"{value:.4g}" if math.isfinite(value) else "" for value in values)))
    return title, ("", *columns), rows


TITLE = "What each accuracy of the study costs and changes"
#: Errors of the walks shown, by the keys of an accuracy: name, factor and unit.
ERRORS = {"hip_position_m": ("error of the hip's position", 1e6, "um"), "period_s": ("error of the period", 1e6, "us"),
          "multiplier": ("error of the largest multiplier", 1.0, "1"),
          "peak_force_n": ("error of the peak force", 1.0, "N")}  # fmt: skip


def prices(level: str) -> Table:
    """The table of benchmarks/levels.py in short; `level` is the one at hand. Times are of the machine measured on."""
    kept = json.loads(LEVEL_ERRORS.read_text(encoding="utf-8"))
    costs, verdicts, errors = (kept[name] for name in ("costs", "verdicts", "errors"))
    rows = [
        ("two cores, from nothing, by the clock [s]", *(f"{costs[each]['clock']:.0f}" for each in LEVELS)),
        ("processor time [s]", *(f"{costs[each]['processor']:.0f}" for each in LEVELS)),
        *((f"{stage}, by itself [s]", *(f"{costs[each]['stages'][stage]:.1f}" for each in LEVELS))
          for stage in costs[level]["stages"]),
        *((f"{name} [{unit}]" if unit != "1" else name, *(f"{factor * errors[each][key]:.2g}" for each in LEVELS))
          for key, (name, factor, unit) in ERRORS.items()),
        ("verdicts not decided at this accuracy", *(str(verdicts[each]["not_decided"]) for each in LEVELS)),
        ("other verdicts than at reference", *(str(verdicts[each]["other"]) for each in LEVELS)),
    ]  # fmt: skip
    return TITLE, ("", *(f"{each} (this one)" if each == level else each for each in LEVELS)), rows
