"""Which claims apply: the paper speaks of one biped on one slope. And the parameters that a claim rests on, by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any

from stages.comparison.claims.paper import BIPED, SETTINGS
from stages.comparison.parameters import Parameters

#: What a claim on the method asks of a biped: legs that take double stance.
OF_THE_METHOD = ("biped.legs",)


def another_biped(parameters: Parameters, keys: Iterable[str] = BIPED) -> tuple[str, ...]:
    """The parameters among `keys` in which this biped or its slope is not the paper's, in words."""
    differing = []
    for key in keys:
        printed, (value, unit) = BIPED[key], found(parameters, key)
        if value != printed.value:
            differing.append(f"{key} is {quantity(value, unit)}, the paper has {quantity(printed.value, unit)} "
                             f"({printed.source})")  # fmt: skip
    return tuple(differing)


def rests_on(parameters: Parameters, keys: Iterable[str]) -> tuple[str, ...]:
    """Parameters with their values, and the paper's where it prints another; without those that follow from others.

    Parts that were made to fit the design say so.
    """
    named = []
    for key in keys:
        value, unit = found(parameters, key)
        if value is None and unit:
            continue
        text = f"{key} {quantity(value, unit)}".rstrip()
        if key in SETTINGS and value != SETTINGS[key].value:
            text += f" (paper: {quantity(SETTINGS[key].value, unit)}, {SETTINGS[key].source})"
        if key == "twin.parts" and (fitted := parameters.twin.bill_rule(parameters.biped)):
            text += f" ({fitted})"
        named.append(text)
    return tuple(named)


def found(parameters: Parameters, key: str) -> tuple[Any, str]:
    """Value and unit of a parameter file.key; no value where it is none of the comparison's (the ingest's)."""
    file, _, name = key.partition(".")
    for section in (getattr(parameters, field.name) for field in dataclasses.fields(parameters)):
        for field in dataclasses.fields(section):
            if file == section.FILE and field.name == name:
                return getattr(section, name), field.metadata["unit"]
    return None, ""


def quantity(value: Any, unit: str) -> str:
    """A value with its unit; nothing for a list or a table, which is named only."""
    if not isinstance(value, (str, int, float)):
        return ""
    text = value if isinstance(value, str) else f"{value:g}"
    return text if unit in ("1", "-", "") else f"{text} {unit}"
