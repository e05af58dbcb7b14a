"""What a result follows from: the cache key of a stage, words for what changed, and what an artefact says of itself.

The versions of packages are found without importing any of them. Nothing of time or folder is said, but what of the
processor decides last bits.
"""

import json
import math
import sys
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from pipeline.cache import disk, processor
from pipeline.cache.sources import Sources
from pipeline.graph import Stage

_ABSENT = "not installed"
_NAME_OF_MODULE = {"PIL": "pillow", "yaml": "pyyaml", "mpl_toolkits": "matplotlib"}
_BENEATH = {
    "numba": ("llvmlite", "numpy"),
    "scipy": ("numpy",),
    "sympy": ("mpmath",),
    "matplotlib": ("contourpy", "numpy", "pillow"),
    "exudyn": ("numpy",),
    "h5py": ("numpy",),
}


def versions(modules: Iterable[str]) -> dict[str, str]:
    """Distribution -> version for the third-party `modules`, the compiled ones beneath them, and Python itself."""
    found = {"python": f"{sys.version_info.major}.{sys.version_info.minor}"}
    waiting = [_NAME_OF_MODULE.get(module, module) for module in modules if module not in sys.stdlib_module_names]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found[name] = _version(name)
            waiting.extend(_BENEATH.get(name, ()))
    return dict(sorted(found.items()))


def installed(names: Iterable[str]) -> list[str]:
    """The versions of those of the distributions that are installed."""
    return [found for found in map(_version, names) if found != _ABSENT]


@cache
def _version(name: str) -> str:
    import importlib.metadata as metadata  # takes its time

    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return _ABSENT


Ingredients = dict[str, Any]
#: The attribute of an artefact that has all of them, as JSON.
INGREDIENTS = "ingredients"
_HERE = Path(__file__).parent
WRITER = (_HERE / "artefact.py", _HERE / "hdf5.py", _HERE / "differences.py")


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
        "writer": disk.digest("".join(sources.memo.meaning(path.read_bytes()).tree for path in WRITER).encode()),
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
    return disk.digest(json.dumps(parts, sort_keys=True, separators=(",", ":")).encode())[:32]


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


def set_for_a_run(stated: Any) -> str:
    """Where a value comes from that is another than its file's; null may be what others make of it."""
    follows = "follows from others, or was " if stated is None else ""
    return f"{follows}set for this run; the file says {compact(stated)}"


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


def attributes(parts: Ingredients, requests: Iterable[Any], above: Iterable[Ingredients]) -> dict[str, str]:
    """Attributes of the artefact's group `provenance`; `settings` is a digest of its parameters and those `above`."""
    settings = {each["stage"]: each["parameters"] for each in (*above, parts)}
    return {
        "stage": parts["stage"],
        "key": key(parts),
        "parameters": parameter_text(parts["parameters"]),
        "settings": disk.digest(json.dumps(settings, sort_keys=True).encode())[:16],
        **{request.NAME: said for request in requests if (said := _requested(parts, request))},
        "versions": _lines(parts["versions"]),
        "processor": processor.words(),
        "inputs": _lines(parts["inputs"]),
        INGREDIENTS: json.dumps(parts, indent=1, sort_keys=True),
    }


def made_as_here(about: Mapping[str, str]) -> bool:
    """Whether an artefact, by what it says of its making, would be made here with the same last bits."""
    named = [line.partition(" ")[0] for line in about.get("versions", "").splitlines()]
    same = about.get("versions") == _lines(versions(name for name in named if name != "python"))
    return same and about.get("processor") == processor.words()


def _requested(parts: Ingredients, request: Any) -> str:
    """What a request asked of the stage; nothing where nothing was asked."""
    own = parts["parameters"].get(parts["stage"], {}) if parts["stage"] in request.FILES else {}
    requested = own.get(request.NAME, request.FREE)
    return "" if requested == request.FREE else f"asked: {compact(requested)}"


def parameter_text(files: Mapping[str, Mapping[str, Any]]) -> str:
    """Parameters as lines `ground.gravity = 9.81`; a table has a line for each row."""
    lines = []
    for file, values in files.items():
        for name, value in values.items():
            if isinstance(value, list) and any(isinstance(item, dict) for item in value):
                lines += [f"{file}.{name}.{index} = {_row(item)}" for index, item in enumerate(value)]
            elif isinstance(value, list):
                lines.append(f"{file}.{name} = [{', '.join(compact(item) for item in value)}]")
            else:
                lines.append(f"{file}.{name} = {compact(value)}")
    return "\n".join(lines)


def _row(row: Mapping[str, Any]) -> str:
    return "{" + ", ".join(f"{name}: {compact(value)}" for name, value in row.items()) + "}"


def _lines(values: Mapping[str, str]) -> str:
    return "\n".join(f"{name} {value}" for name, value in values.items())
