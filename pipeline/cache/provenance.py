"""What an artefact says of its own making: the same on every machine and at every time."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from pipeline import accuracy
from pipeline.cache import fingerprint
from pipeline.cache.fingerprint import Ingredients, compact


def attributes(parts: Ingredients) -> dict[str, str]:
    """Attributes of the artefact's group `provenance`: stage, key, parameters, versions, inputs, code."""
    return {
        "stage": parts["stage"],
        "key": fingerprint.key(parts),
        "parameters": parameter_text(parts["parameters"]),
        **_accuracy(parts),
        "versions": _lines(parts["versions"]),
        "inputs": _lines(parts["inputs"]),
        "code": json.dumps(parts["code"], indent=1, sort_keys=True),
    }


def _accuracy(parts: Ingredients) -> dict[str, str]:
    """What was asked of the stage's own walk, and the solver settings used for it; nothing where none was asked."""
    own = parts["parameters"].get(parts["stage"], {})
    asked = own.get("accuracy", accuracy.CUSTOM)
    if parts["stage"] not in accuracy.FILES or asked == accuracy.CUSTOM:
        return {}
    used = ", ".join(f"{key} {compact(own[key])}" for key in accuracy.decided(parts["stage"], own))
    return {"accuracy": f"asked: {compact(asked)}; used: {used}"}


def parameter_text(files: Mapping[str, Mapping[str, Any]]) -> str:
    """Parameters as lines `biped.hip_mass = 0.316`; a table has a line for each row."""
    lines = []
    for file, values in files.items():
        for key, value in values.items():
            if isinstance(value, list) and any(isinstance(item, dict) for item in value):
                lines += [f"{file}.{key}.{index} = {_row(item)}" for index, item in enumerate(value)]
            elif isinstance(value, list):
                lines.append(f"{file}.{key} = [{', '.join(compact(item) for item in value)}]")
            else:
                lines.append(f"{file}.{key} = {compact(value)}")
    return "\n".join(lines)


def _row(row: Mapping[str, Any]) -> str:
    return "{" + ", ".join(f"{name}: {compact(value)}" for name, value in row.items()) + "}"


def _lines(values: Mapping[str, str]) -> str:
    return "\n".join(f"{name} {value}" for name, value in values.items())
