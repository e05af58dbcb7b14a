"""What an artefact says of its own making: nothing of time, or folder, but what of the processor decides last bits."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from pipeline.cache import durable, fingerprint, processor
from pipeline.cache.distributions import versions
from pipeline.cache.fingerprint import Ingredients, compact


def attributes(parts: Ingredients, requests: Iterable[Any] = (), above: Iterable[Ingredients] = ()) -> dict[str, str]:
    """Attributes of the artefact's group `provenance`; `settings` is a digest of its parameters and those `above`."""
    settings = {each["stage"]: each["parameters"] for each in (*above, parts)}
    return {
        "stage": parts["stage"],
        "key": fingerprint.key(parts),
        "parameters": parameter_text(parts["parameters"]),
        "settings": durable.digest(json.dumps(settings, sort_keys=True).encode())[:16],
        **{request.NAME: said for request in requests if (said := _asked(parts, request))},
        "versions": _lines(parts["versions"]),
        "processor": processor.words(),
        "inputs": _lines(parts["inputs"]),
        "code": json.dumps(parts["code"], indent=1, sort_keys=True),
    }


def made_as_here(about: Mapping[str, str]) -> bool:
    """Whether an artefact, by what it says of its making, would be made here with the same last bits."""
    named = [line.partition(" ")[0] for line in about.get("versions", "").splitlines()]
    same = about.get("versions") == _lines(versions(name for name in named if name != "python"))
    return same and about.get("processor") == processor.words()


def _asked(parts: Ingredients, request: Any) -> str:
    """What a request asked of the stage, and the settings used for it; nothing where nothing was asked."""
    own = parts["parameters"].get(parts["stage"], {})
    keys = request.decided(parts["stage"], own) if parts["stage"] in request.FILES and request.NAME in own else ()
    used = ", ".join(f"{key} {compact(own[key])}" for key in keys)
    return f"asked: {compact(own[request.NAME])}; used: {used}" if keys else ""


def parameter_text(files: Mapping[str, Mapping[str, Any]]) -> str:
    """Parameters as lines `ground.gravity = 9.81`; a table has a line for each row."""
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
