"""Warns of parameters outside those at which every model was found right, by the kept map of extremes.

The table is written by benchmarks/extremes_table.py from the full map; docs/extremes.md says how the map was made.
"""

from __future__ import annotations

import importlib
import json
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import click

from pipeline.study import Study

TABLE = Path(__file__).with_name("extremes_table.json")
#: Columns of a row of the table; what follows them are the numbers, in the order that the table names.
COLUMNS = ("what", "status", "error", "reason")


def warn(study: Study, values: Mapping[str, Any]) -> None:
    """One sentence on standard error for each stage whose parameters are outside; `values` is stage -> parameters."""
    for sentence in warnings(study, values):
        click.echo(f"warning: {sentence}", err=True)


def warnings(study: Study, values: Mapping[str, Any]) -> Iterator[str]:
    """The sentences. A study without a map of extremes has none."""
    if study.sources.file(f"{study.package}.extremes.envelope") is None:
        return
    engines = importlib.import_module(f"{study.package}.extremes.engines")
    envelope = importlib.import_module(f"{study.package}.extremes.envelope")
    for stage, own in values.items():
        engine = engines.engine_of(stage, own)
        if engine is None:
            continue
        here = envelope.place_of(engine, own.biped, own.slope, ground_of(own), own.settings)
        sentence = envelope.warning(engine, here, tried(envelope, engine), study.choice(stage, own) is not None)
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


def tried(envelope: Any, engine: str) -> list[Any]:
    """The points of an engine, as `Tried`."""
    found = []
    for group in table()["engines"].get(engine, ()):
        for *said, numbers in group["points"]:
            place = envelope.Place(group["choices"], dict(zip(group["numbers"], numbers, strict=True)))
            found.append(envelope.Tried(place, **dict(zip(COLUMNS, said, strict=True))))
    return found
