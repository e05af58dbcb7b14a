"""Single values and whole columns of them as arrays of one type, and back."""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping, Sequence
from typing import Any

import h5py
import numpy as np

#: Attribute of a dataset: the rows that have no value, [0] where it is no table. What lies there means nothing.
NONE = "none"
#: Attribute of bytes that are truths, as xarray has it: netCDF knows no truths.
TRUTHS = "dtype"
_WORDS = h5py.string_dtype("utf-8")


def storable(value: Any) -> np.ndarray:
    """A NumPy array of one type: text as UTF-8 of any length, numbers little-endian. Raises `TypeError` for others."""
    if isinstance(value, str) or (isinstance(value, tuple) and value and isinstance(value[0], str)):
        return np.asarray(value, dtype=_WORDS)
    array = np.ascontiguousarray(value) if isinstance(value, np.ndarray) and value.ndim else np.asarray(value)
    if array.dtype.kind not in "biuf":
        raise TypeError(f"a value of type {type(value).__name__} ({array.dtype}) cannot be stored")
    return array.astype(array.dtype.newbyteorder("<"), copy=False)


def column(values: Sequence[Any]) -> np.ndarray | None:
    """The values of all rows (None where there is none) along a first axis; None if their shapes or types differ."""
    parts = [storable(value) for value in values if value is not None]
    if not parts:
        return np.full(len(values), np.nan)
    if len({part.dtype for part in parts}) > 1:
        parts = _as_floats(values) or parts
    first = parts[0]
    if any(part.shape != first.shape or part.dtype != first.dtype for part in parts):
        return None
    filler = np.full_like(first, {"f": np.nan, "O": ""}.get(first.dtype.kind, 0))
    left = iter(parts)
    stacked = np.stack([filler if value is None else next(left) for value in values])
    return np.asarray(stacked, dtype=_WORDS) if stacked.dtype.kind == "O" else stacked


def _as_floats(values: Sequence[Any]) -> list[np.ndarray]:
    """Those that are given, as floats; none where one is no number, or is another number as a float."""
    given = [value for value in values if value is not None]
    numbers = [value for value in given if isinstance(value, (int, float)) and not isinstance(value, bool)]
    whole = len(numbers) == len(given) and all(float(value) == value or value != value for value in numbers)
    return [storable(float(value)) for value in numbers] if whole else []


def write(group: Any, name: str, array: np.ndarray, none: Sequence[int] = ()) -> Any:
    """A dataset of what `storable` or `column` gave; `none` are the rows without a value."""
    truths = array.dtype.kind == "b"
    item = group.create_dataset(name, data=array.astype(np.int8) if truths else array, track_times=False)
    if truths:
        item.attrs[TRUTHS] = "bool"
    if len(none):
        item.attrs[NONE] = np.asarray(none, dtype="<i8")
    return item


def read(item: Any) -> Any:
    """A dataset as a NumPy array or number; text as Python words. Raises `ValueError` for what is no text."""
    value = item[()]
    if (isinstance(value, bytes) or value.dtype.kind in "OS") and h5py.check_string_dtype(item.dtype) is not None:
        return item.asstr()[()]
    return value.astype(bool) if value.dtype == np.int8 and item.attrs.get(TRUTHS) == "bool" else value


def python(value: Any) -> Any:
    """Python's own numbers and words."""
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value


def of_kind(value: Any, kind: Any) -> Any:
    """What was read as the type that its field declares."""
    if kind is np.ndarray:
        return np.array(value)
    plain = python(value)
    if typing.get_origin(kind) is tuple:
        return tuple(typing.get_args(kind)[0](part) for part in plain)
    return kind(plain) if kind in (float, int, bool, str) else plain


def present(kind: Any) -> Any:
    """The type of a field where it has a value: `float` of `float | None`."""
    if typing.get_origin(kind) in (typing.Union, types.UnionType):
        return next(option for option in typing.get_args(kind) if option is not type(None))
    return kind


def row_class(kind: Any) -> Any:
    """The class of the rows, if the type is that of a table, a tuple of dataclasses; else None."""
    arguments = typing.get_args(present(kind))
    table = typing.get_origin(present(kind)) is tuple and arguments and hasattr(arguments[0], "__dataclass_fields__")
    return arguments[0] if table else None


def part_kind(kind: Any) -> Any:
    """The type of a mapping's values; `object` where it is not said."""
    arguments = typing.get_args(present(kind))
    return arguments[1] if len(arguments) == 2 else object


def is_mapping(kind: Any) -> bool:
    """Whether a type is that of a mapping."""
    return typing.get_origin(kind) in (dict, Mapping)
