"""Tables of results of one class side by side: a row for each field, in the units that a reader expects."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

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
