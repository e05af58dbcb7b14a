"""The same parameters with looser solvers: what a result then differs by is the numerical error of its numbers."""

from __future__ import annotations

import dataclasses
from typing import Any

from pipeline.parameters.value import declared

#: Metadata of a field that a looser run changes: a factor on its value, the most that it may be (a whole number), or
#: the word in its place.
LOOSER = "looser"


def looser(parameters: Any) -> Any:
    """A stage's parameters with all settings of solvers as much looser as their fields say, whatever their bounds."""
    return dataclasses.replace(parameters, **{name: _section(each) for name, each in vars(parameters).items()})


def _section(section: Any) -> Any:
    kind: type = type(section)
    values = {key: (getattr(section, key), field) for key, (field, _) in declared(kind).items()
              if field.metadata.get(LOOSER) is not None and getattr(section, key) is not None}  # fmt: skip
    return dataclasses.replace(section, **{key: _looser(*each) for key, each in values.items()}) if values else section


def _looser(value: Any, field: dataclasses.Field[Any]) -> Any:
    by = field.metadata[LOOSER]
    if isinstance(by, str):
        return by
    return min(value, by) if isinstance(by, int) else float(f"{value * by:.12g}")
