"""What a stage's run reached of the accuracy that was asked for, as it stands in its result."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from stages.tradeoff.accuracy.choice import TABLE, Choice


def verified(choice: Choice, result: Any) -> dict[str, Any]:
    """The estimates in a stage's result as plain values, beside what the table proposed."""
    return {
        "asked": dict(choice.asked),
        "proposed": dict(choice.settings),
        "table": {kind: entry["made"] for kind, entry in json.loads(TABLE.read_text())["about"].items()},
        "estimated": {row.name: _rounded(row.estimated) for row in result.errors},
        "settings": result.errors[0].settings,
    }


def line(found: Mapping[str, Any]) -> str:
    """A verification in one line."""
    estimated = ", ".join(f"{key} {value:.1e}" for key, value in found["estimated"].items())
    asked = ", ".join(f"{key} {value:g}" for key, value in found["asked"].items())
    return f"{found['stage']}: asked {asked}; used {found['settings']}; estimated {estimated} (from a coarser walk)"


def _rounded(value: float) -> float:
    """Two digits: an estimate has no more."""
    return float(f"{value:.1e}")
