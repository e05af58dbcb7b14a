"""How far the numbers of a claim are off by numerical error, and whether its verdict could change by that much.

The errors are twice the differences from the level `reference` that benchmarks/levels.py measured. They are those of
the parameters that it had at each level alone: with others, and at `reference`, none is known.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from stages.comparison.claims.measured import Measured
from stages.comparison.parameters import Parameters, Settings
from stages.comparison.result import Number

TABLE = Path(__file__).with_name("numerical_errors.json")
#: Error given for a measured difference, as it may be larger than that.
TIMES = 2.0

M = TypeVar("M", bound=Measured)


def digest(parameters: Parameters) -> str:
    """What tells the parameters of a study from all others."""
    return hashlib.sha256(repr(parameters).encode()).hexdigest()[:16]


def measured_errors(parameters: Parameters, claim: str) -> Mapping[str, float]:
    """The errors of a claim's numbers with these parameters, by name; none where nobody measured."""
    kept, level = json.loads(TABLE.read_text(encoding="utf-8")), parameters.level.level
    known = kept["errors"][level][claim] if kept["parameters"].get(level) == digest(parameters) else {}
    return {name: TIMES * error for name, error in known.items()}


def numbers(measured: Measured, parameters: Parameters) -> tuple[Number, ...]:
    """The numbers of a claim with their errors."""
    errors = measured_errors(parameters, measured.ID)
    return tuple(Number(name, measured.unit(name), value, errors.get(name, math.nan))
                 for name, value in named(vars(measured)))  # fmt: skip


def named(parts: Any, where: str = "") -> Iterator[tuple[str, float]]:
    """Name and value of each float in fields and in tuples, to any depth."""
    pairs = parts.items() if isinstance(parts, Mapping) else enumerate(parts)
    for key, value in pairs:
        name = f"{where}.{key}" if where else str(key)
        if isinstance(value, float):
            yield name, float(value)
        elif isinstance(value, tuple):
            yield from named(value, name)


def other_verdicts(measured: Measured, settings: Settings, known: tuple[Number, ...]) -> Iterator[tuple[Number, str]]:
    """Numbers that change the verdict if they are more or less by their error, and what it then is."""
    verdict = measured.judge(settings).verdict
    for number in known:
        if number.error > 0 and math.isfinite(number.value):
            for value in (number.value - number.error, number.value + number.error):
                other = with_number(measured, number.name, value).judge(settings).verdict
                if other != verdict:
                    yield number, other
                    break


def with_number(measured: M, name: str, value: float) -> M:
    """The same claim with one number changed."""
    field, _, inner = name.partition(".")
    return dataclasses.replace(measured, **{field: _changed(getattr(measured, field), inner, value)})


def _changed(part: Any, name: str, value: float) -> Any:
    if not name:
        return value
    place, _, inner = name.partition(".")
    return tuple(_changed(item, inner, value) if at == int(place) else item for at, item in enumerate(part))
