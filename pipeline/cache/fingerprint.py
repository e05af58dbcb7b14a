"""The cache key of a stage: a hash over everything its result follows from, and the words for what changed."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline.cache import durable
from pipeline.cache.closure import Sources
from pipeline.cache.distributions import versions
from pipeline.graph import Stage

Ingredients = dict[str, Any]
_HERE = Path(__file__).parent
WRITER = (_HERE / "artefact.py", *sorted((_HERE / "hdf5").glob("*.py")))


def ingredients(
    stage: Stage, sources: Sources, parameters: Mapping[str, Mapping[str, Any]], inputs: Mapping[str, str]
) -> Ingredients:
    """All that the stage's result follows from.

    `parameters` is file -> key -> value; `inputs` is path -> content hash. The code is the stage's import closure; the
    writer of artefacts counts as code too.
    """
    closure = sources.closure(entry_modules(stage, sources.package))
    return {
        "stage": stage.name,
        "code": closure.files,
        "writer": durable.digest("".join(sources.memo.meaning(path.read_bytes()).tree for path in WRITER).encode()),
        "parameters": {file: dict(values) for file, values in parameters.items()},
        "inputs": dict(inputs),
        "versions": versions((*closure.foreign, "h5py")),
        "outs": list(stage.outs),
    }


def entry_modules(stage: Stage, package: str) -> tuple[str, ...]:
    """Modules the worker imports for this stage. The result classes that it reads are imported by its `run`."""
    return tuple(f"{package}.{stage.name}.{module}" for module in ("run", "parameters", "result"))


def key(parts: Ingredients) -> str:
    """The cache key: a hash of the ingredients, independent of machine, folder and time.

    On one machine the same key means the same bytes; on another processor, the same numbers within rounding errors.
    """
    return durable.digest(json.dumps(parts, sort_keys=True, separators=(",", ":")).encode())[:32]


def changes(old: Ingredients, new: Ingredients) -> Iterator[str]:
    """What differs, one phrase each: `ground.yaml: contact_stiffness 1e5 -> 2e5`, `input analytic changed`."""
    for file, values in new["parameters"].items():
        before = old["parameters"].get(file, {})
        for name in {**before, **values}:
            if before.get(name) != values.get(name):
                yield f"{file}.yaml: {name}{_step(before, values, name)}"
    for path, verb in _different(old["code"], new["code"]):
        yield f"{path} {verb}"
    for path, _ in _different(old["inputs"], new["inputs"]):
        yield f"input {Path(path).stem} changed"
    for name, _ in _different(old["versions"], new["versions"]):
        yield f"{name}{_step(old['versions'], new['versions'], name)}"
    if old["outs"] != new["outs"]:
        yield "dvc.yaml: its outs changed"
    if old["writer"] != new["writer"]:
        yield "the form of artefacts changed"


def compact(value: Any) -> str:
    """A value in few letters: 1e5 rather than 100000.0; a table or a long list only by its length."""
    if isinstance(value, bool) or value is None:
        return "none" if value is None else str(value).lower()
    if isinstance(value, (int, float)):
        return _shortest(value) if math.isfinite(value) else str(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {compact(item)}" for key, item in value.items() if item is not None) + "}"
    if isinstance(value, list):
        if len(value) > 4 or any(isinstance(item, dict) for item in value):
            return f"({len(value)} entries)"
        return "[" + ", ".join(compact(item) for item in value) + "]"
    return str(value)


def _shortest(value: float) -> str:
    """A finite number as plain or scientific digits, whichever is shorter."""
    plain = f"{value:.15g}" if isinstance(value, float) else str(value)
    mantissa, _, exponent = f"{value:.14e}".partition("e")
    scientific = f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"
    shorter = scientific if len(scientific) < len(plain) else plain
    return shorter if float(shorter) == value else repr(value)


def _different(old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    for name in sorted({**old, **new}):
        if old.get(name) != new.get(name):
            yield name, "is new" if name not in old else "is gone" if name not in new else "changed"


def _step(before: Mapping[str, Any], after: Mapping[str, Any], name: str) -> str:
    if name not in before:
        return " is new"
    if name not in after:
        return " is gone"
    old, new = compact(before[name]), compact(after[name])
    return " changed" if old == new else f" {old} -> {new}"
