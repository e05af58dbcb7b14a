"""A result reduced to the numbers and words of one line, and what each of them means."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Iterator, Mapping
from typing import Any

_MOST_ENTRIES = 16


def columns(result: Any, prefix: str = "") -> dict[str, Any]:
    """Numbers and words of a result by name: mass.shell; of small arrays each entry: matrix.0.1."""
    import numpy as np

    found: dict[str, Any] = {}
    for item in dataclasses.fields(result):
        value, name = getattr(result, item.name), prefix + item.name
        if dataclasses.is_dataclass(value):
            found.update(columns(value, name + "."))
        elif isinstance(value, Mapping):
            found.update({f"{name}.{key}": part for key, part in value.items() if isinstance(part, (int, float))})
        elif isinstance(value, (bool, np.bool_)):
            found[name] = bool(value)
        elif isinstance(value, (int, float, str, np.number)):
            found[name] = value.item() if isinstance(value, np.number) else value
        elif isinstance(value, np.ndarray) and value.dtype.kind in "biuf" and value.size <= _MOST_ENTRIES:
            found.update({name + "".join(f".{at}" for at in place): value[place].item()
                          for place in np.ndindex(value.shape)})  # fmt: skip
    return found


def about(cls: type, column: str) -> Mapping[str, str]:
    """Unit, symbol and description of a column of a result class; empty where it has none."""
    return next(_meanings(cls, column.split(".")), {})


def _meanings(cls: type, path: list[str]) -> Iterator[Mapping[str, str]]:
    hints = typing.get_type_hints(cls)
    for item in dataclasses.fields(cls):
        if item.name == path[0]:
            kinds = [hints[item.name], *typing.get_args(hints[item.name])]
            inner = next((kind for kind in kinds if dataclasses.is_dataclass(kind)), None)
            if inner is not None and len(path) > 1 and isinstance(inner, type):
                yield from _meanings(inner, path[1:])
            else:
                yield {key: str(item.metadata[key]) for key in ("unit", "symbol", "description") if item.metadata[key]}
