"""Results as HDF5: a dataclass becomes a group, each field a dataset with unit, symbol and description.

The same numbers give the same bytes on every run: no clock time, one library version, fields in order. Whether a stage
finds the same numbers to the last bit is another matter: on another processor it may not (`processor.py`).
A field `files` (path -> content) is not stored here; the pipeline writes it beside the artefact.
"""

from __future__ import annotations

import dataclasses
import io
import types
import typing
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np

from pipeline.errors import ArtefactError

#: The form of artefacts: a program reads those of its own number and below.
_FORM, _NEWEST = "bipedstudy artefact", 1
FORMAT = f"{_FORM} {_NEWEST}"
_PROVENANCE = "provenance"
_SHORT = 8
_ATTRIBUTES = ("unit", "symbol", "description")
T = TypeVar("T")


def encode(result: Any, provenance: Mapping[str, str]) -> bytes:
    """The HDF5 file of a result dataclass. `provenance` becomes the attributes of the group `provenance`."""
    with h5py.File(
        "artefact", "w", driver="core", backing_store=False, libver=("v110", "v110"), track_order=True
    ) as file:
        file.attrs["format"] = FORMAT
        _write_fields(file, result)
        group = file.create_group(_PROVENANCE)
        for name in sorted(provenance):
            group.attrs[name] = provenance[name]
        file.flush()
        return bytes(file.id.get_file_image())


def decode(content: bytes, cls: type[T], name: str) -> T:
    """The result of class `cls` in an artefact's bytes. Raises `ArtefactError`; `name` is how it names the file."""
    with _opened(content, name) as file:
        try:
            return typing.cast(T, _read_fields(file, cls))
        except (KeyError, TypeError, ValueError, OSError, RuntimeError) as error:
            reason = error.args[0] if error.args else error
            raise ArtefactError(f"{name}: its fields do not fit this version of the study ({reason})") from None


def load(path: Path, cls: type[T]) -> T:
    """Read the artefact at `path` as class `cls`. Raises `ArtefactError` for a truncated or foreign file."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ArtefactError(f"{path}: cannot be read: {error.strerror}") from None
    return decode(content, cls, str(path))


def provenance(content: bytes, name: str) -> dict[str, str]:
    """What the artefact says of its making: stage, key, parameters, versions, inputs."""
    with _opened(content, name) as file:
        return {key: str(value) for key, value in file[_PROVENANCE].attrs.items()}


@dataclasses.dataclass(frozen=True)
class Field:
    """One line of an artefact's tree: its path, unit, symbol, description, shape, and value where it is short."""

    path: str
    unit: str
    symbol: str
    description: str
    shape: tuple[int, ...] | None
    value: Any


def tree(content: bytes, name: str) -> list[Field]:
    """Every field of an artefact, groups included (their shape is None), in the order of declaration."""
    with _opened(content, name) as file:
        return [field for key in file if key != _PROVENANCE for field in _branch(file[key], key)]


def _branch(item: Any, path: str) -> Iterator[Field]:
    unit, symbol, description = (str(item.attrs.get(key, "")) for key in _ATTRIBUTES)
    if isinstance(item, h5py.Group):
        yield Field(path, unit, symbol, description, None, None)
        for key in item:
            yield from _branch(item[key], f"{path}/{key}")
    elif item.shape is None:
        yield Field(path, unit, symbol, description, (), None)
    else:
        value = _python_value(item) if item.size <= _SHORT else None
        yield Field(path, unit, symbol, description, item.shape, value)


def _opened(content: bytes, name: str) -> Any:
    try:
        file = h5py.File(io.BytesIO(content), "r")
    except OSError:
        what = "is empty" if not content else "is truncated or not an HDF5 file"
        raise ArtefactError(f"{name}: {what}; it cannot be read as an artefact of this study") from None
    form, _, number = str(file.attrs.get("format", "")).rpartition(" ")
    if form == _FORM and number.isdecimal() and 0 < int(number) <= _NEWEST:
        return file
    file.close()
    if form == _FORM and number.isdecimal() and int(number) > _NEWEST:
        raise ArtefactError(
            f"{name}: made by a newer version of this program (format {number}); this one reads up to {_NEWEST}"
        )
    raise ArtefactError(f'{name}: an HDF5 file, but not an artefact of this study (its format is not "{FORMAT}")')


@cache
def _declared(cls: type) -> dict[str, tuple[Mapping[str, Any], Any]]:
    hints = typing.get_type_hints(cls)
    return {field.name: (field.metadata, hints[field.name]) for field in dataclasses.fields(cls)}


def _write_fields(group: Any, result: Any) -> None:
    for name, (metadata, _) in _declared(result.__class__).items():
        if name != "files":
            _write(group, name, getattr(result, name), metadata)


def _write(group: Any, name: str, value: Any, metadata: Mapping[str, Any]) -> None:
    if dataclasses.is_dataclass(value):
        item = group.create_group(name, track_order=True)
        _write_fields(item, value)
    elif isinstance(value, Mapping):
        item = group.create_group(name, track_order=True)
        for key, part in value.items():
            _write(item, str(key), part, {"unit": metadata.get("unit", "")})
    elif isinstance(value, tuple) and value and dataclasses.is_dataclass(value[0]):
        item = group.create_group(name, track_order=True)
        for index, part in enumerate(value):
            _write(item, str(index), part, {})
    elif value is None:
        item = group.create_dataset(name, data=h5py.Empty("f8"), track_times=False)
    else:
        item = group.create_dataset(name, data=storable(value), track_times=False)
    for key in _ATTRIBUTES:
        if metadata.get(key):
            item.attrs[key] = metadata[key]


def storable(value: Any) -> Any:
    """A NumPy array of one fixed type: text as fixed-length UTF-8, numbers little-endian."""
    if isinstance(value, str) or (isinstance(value, tuple) and value and isinstance(value[0], str)):
        encoded = np.char.encode(np.array(value, dtype=np.str_), "utf-8")
        return np.asarray(encoded, dtype=h5py.string_dtype("utf-8", max(1, encoded.dtype.itemsize)))
    array = np.ascontiguousarray(value) if isinstance(value, np.ndarray) and value.ndim else np.asarray(value)
    if array.dtype.kind not in "biuf":
        raise TypeError(f"a value of type {type(value).__name__} ({array.dtype}) cannot be stored")
    return array.astype(array.dtype.newbyteorder("<"), copy=False)


def _read_fields(group: Any, cls: type) -> Any:
    values: dict[str, Any] = {}
    for name, (_, kind) in _declared(cls).items():
        values[name] = {} if name == "files" else _read(group, name, kind)
    return cls(**values)


def _read(group: Any, name: str, kind: Any) -> Any:
    if typing.get_origin(kind) in (typing.Union, types.UnionType):
        item = group[name]
        if isinstance(item, h5py.Dataset) and item.shape is None:
            return None
        kind = next(option for option in typing.get_args(kind) if option is not type(None))
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if dataclasses.is_dataclass(kind):
        return _read_fields(group[name], typing.cast(type, kind))
    if origin is dict or origin is Mapping:
        return {key: _read(group[name], key, arguments[1]) for key in group[name]}
    if origin is tuple and dataclasses.is_dataclass(arguments[0]):
        item = group[name]
        row: Any = arguments[0]
        return tuple(_read_fields(item[key], row) for key in item) if isinstance(item, h5py.Group) else ()
    if kind is np.ndarray:
        return np.asarray(group[name][()])
    value = _python_value(group[name])
    if origin is tuple:
        return tuple(arguments[0](part) for part in value)
    return kind(value) if kind in (float, int, bool, str) else value


def _python_value(item: Any) -> Any:
    """A dataset as Python numbers and words."""
    value = item[()]
    if item.dtype.kind == "S":
        words = np.char.decode(np.asarray(value, dtype=item.dtype), "utf-8")
        return words.tolist()
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
