"""Tables of results of one class side by side: a row for each field, in the units that a reader expects."""

import json
import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

Table = tuple[str, tuple[str, ...], list[tuple[str, ...]]]

#: Millimetres and milliseconds below this are none to a reader.
LEAST = 1e-3
#: Units that tables show instead of SI ones: factor and name.
SHOWN = {"m": (1e3, "mm"), "s": (1e3, "ms")}


def side_by_side(title: str, columns: Mapping[str, Any]) -> Table:
    """A table of instances of one dataclass of numbers: (title, columns, rows of text); what is not known is empty, and
    what is known of none is left out."""
    rows = []
    for field in fields(next(iter(columns.values()))):
        factor, unit = SHOWN.get(field.metadata["unit"], (1.0, field.metadata["unit"]))
        values = [factor * float(getattr(one, field.name)) for one in columns.values()]
        name = field.metadata["description"] + ("" if unit == "1" else f" [{unit}]")
        if not all(map(math.isnan, values)):
            rows.append((name, *(in_digits(value, LEAST if factor != 1.0 else 0.0) for value in values)))
    return title, ("", *columns), rows


def in_digits(value: float, least: float) -> str:
    """A number in the digits that people read; what is smaller than `least` only as that, what is not known empty."""
    if value == math.inf:
        return "no bound"
    if 0.0 < abs(value) < least:
        return f"< {least:g}"
    return "" if not math.isfinite(value) else f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"


def as_yaml(what: str, parts: Mapping[str, Any]) -> bytes:
    """What a stage generated as YAML, entries of lists in lines of their own. JSON is YAML."""
    lines = [f"# Generated: {what}."]
    for name, value in parts.items():
        entries = [f"- {json.dumps(each, ensure_ascii=False)}" for each in value] if isinstance(value, list) else []
        lines += [f"{name}:", *entries] if entries else [f"{name}: {json.dumps(value, ensure_ascii=False)}"]
    return ("\n".join(lines) + "\n").encode()
