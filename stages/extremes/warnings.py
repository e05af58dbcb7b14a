"""Warns of parameters outside those at which every model was found right, by the kept map of extremes.

The table is written by benchmarks/extremes_table.py from the full map; docs/extremes.md says how the map was made.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from stages.biped.accuracy.asked import CUSTOM
from stages.extremes.engines import engine_of
from stages.extremes.envelope.place import Place, Tried, place_of, warning

TABLE = Path(__file__).with_name("envelope") / "table.json"
#: Columns of a row of the table; what follows them are the numbers, in the order that the table names.
COLUMNS = ("what", "status", "error", "reason")


def warnings(values: Mapping[str, Any]) -> Iterator[str]:
    """One sentence for each stage whose parameters are outside; `values` is stage -> parameters."""
    for stage, own in values.items():
        engine = engine_of(stage, own)
        if engine is None:
            continue
        here = place_of(engine, own.biped, own.slope, ground_of(own), own.settings)
        sentence = warning(engine, here, tried(engine), own.settings.accuracy != CUSTOM)
        if sentence is not None:
            yield f"stage {stage}: {sentence}"


def ground_of(parameters: Any) -> Any:
    """The contact law of a stage's parameters, or the friction where there is no more."""
    return parameters.contact if hasattr(parameters, "contact") else parameters.friction


@cache
def table() -> dict[str, Any]:
    """The kept table: engine -> groups of points with the same choices."""
    read: dict[str, Any] = json.loads(TABLE.read_text(encoding="utf-8"))
    return read


def tried(engine: str) -> list[Tried]:
    """The points of an engine."""
    found = []
    for group in table()["engines"].get(engine, ()):
        for *said, numbers in group["points"]:
            place = Place(group["choices"], dict(zip(group["numbers"], numbers, strict=True)))
            found.append(Tried(place, **dict(zip(COLUMNS, said, strict=True))))
    return found
