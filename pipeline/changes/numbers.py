"""What differs between two artefacts of one stage: parameters, and every number, array and word."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.cache import artefact
from pipeline.cache.hdf5 import values


@dataclass(frozen=True)
class Change:
    """A field of a stage: before, after (None where it is not there), its unit, and the relative change.

    The change of a number is a share of what it was. Of an array it is the largest, as a share of its largest value;
    before and after are then words. What is no number has no relative change.
    """

    stage: str
    path: str
    unit: str
    before: Any
    after: Any
    relative: float | None


def parameters(before: Mapping[str, str], after: Mapping[str, str]) -> Iterator[tuple[str, str | None, str | None]]:
    """File.key, value before and after, of those that differ, from what two artefacts say of their making."""
    one, other = (dict(line.split(" = ", 1) for line in about.get("parameters", "").splitlines() if " = " in line)
                  for about in (before, after))  # fmt: skip
    for key in dict.fromkeys((*one, *other)):
        if one.get(key) != other.get(key):
            yield key, one.get(key), other.get(key)


def changes(stage: str, before: bytes, after: bytes, names: tuple[str, str]) -> Iterator[Change]:
    """Every field that differs between two artefacts' bytes. Raises `ArtefactError`; `names` are those of the files."""
    import h5py

    one, other = ({field.path: field for field in artefact.tree(content, name) if field.shape is not None}
                  for content, name in zip((before, after), names))  # fmt: skip
    with h5py.File(io.BytesIO(before), "r") as old, h5py.File(io.BytesIO(after), "r") as new:
        for path in dict.fromkeys((*one, *other)):
            unit = (other.get(path) or one[path]).unit
            values_of = [_value(file[path]) if path in known else None
                         for file, known in ((old, one), (new, other))]  # fmt: skip
            change = _change(*values_of)
            if change is not None:
                yield Change(stage, path, "" if unit in ("1", "-") else unit, *change)


def _value(item: Any) -> Any:
    """An array, or a scalar's value; None where there is none."""
    if item.shape is None or (not item.shape and values.NONE in item.attrs):
        return None
    return np.asarray(values.read(item))


def _change(before: Any, after: Any) -> tuple[Any, Any, float | None] | None:
    """Before and after as they are shown, and the relative change; None if nothing changed."""
    if before is None or after is None:
        return None if before is after else (_shown(before), _shown(after), None)
    numbers = before.dtype.kind in "biuf" and after.dtype.kind in "biuf"
    if before.shape != after.shape or not numbers:
        same = before.shape == after.shape and bool((before == after).all())
        return None if same else (_shown(before), _shown(after), None)
    return _apart(before, after)


def _apart(before: np.ndarray, after: np.ndarray) -> tuple[Any, Any, float | None] | None:
    """The same for numbers or arrays of one shape."""
    one, other = before.astype(float), after.astype(float)
    if np.array_equal(one, other, equal_nan=True):
        return None
    if not one.shape:
        finite = one != 0.0 and np.isfinite(one) and np.isfinite(other)
        return before.item(), after.item(), float((other - one) / abs(one)) if finite else np.inf
    size = np.abs(np.concatenate([each[np.isfinite(each)].ravel() for each in (one, other)])).max(initial=0.0)
    changed = (one != other) & ~(np.isnan(one) & np.isnan(other))
    apart = np.abs(other[changed] - one[changed])
    largest = float(apart.max()) if np.isfinite(apart).all() else np.inf
    return _shown(before), f"differs by {largest:.3g} at most", largest / float(size) if size else np.inf


def _shown(value: Any) -> Any:
    if value is None:
        return None
    if value.shape:
        return f"array {' x '.join(map(str, value.shape))}"
    return value.item() if hasattr(value.item(), "__float__") else str(value.item())
