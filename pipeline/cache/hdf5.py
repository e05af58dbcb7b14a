"""Dataclasses as groups of HDF5, tuples of dataclasses as tables: a dataset for each column along a dimension `row`.

Names of dimensions and their scales are netCDF-4's. A field whose values have different shapes has no column: those of
a row lie together in a group with the row's number.
"""

import dataclasses
import itertools
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, get_args, get_origin, get_type_hints

import h5py
import numpy as np

from pipeline.parameters.value import present

#: Attribute of a group that is a table: the number of its rows.
ROWS = "rows"
#: Why a number has no numerical error.
WITHOUT_ERROR = "without_error"
#: What the rows of an array are, if their order means nothing, as that of eigenvalues.
UNORDERED = "unordered"
#: Attributes in the file, and the word that a field's declaration has for each.
ATTRIBUTES = {"units": "unit", "long_name": "description", "symbol": "symbol", WITHOUT_ERROR: WITHOUT_ERROR,
              UNORDERED: UNORDERED}  # fmt: skip
#: Attribute of a dataset: the rows that have no value, [0] where it is no table. What lies there means nothing.
NONE = "none"
#: Attribute of bytes that are truths, as xarray has it: netCDF knows no truths.
TRUTHS = "dtype"
_WORDS = h5py.string_dtype("utf-8")
_TIME = "time"
#: What netCDF-4 calls a dimension that has a length and no values; readers hide it from the variables.
_LENGTH_ALONE = b"This is a netCDF dimension but not a netCDF variable."
#: What is stored of a value, or of the cells of a column: an array and the rows that have none; the same of each part
#: by name, with what is said of it; the rows of a table; or None, where cells do not fit into a column.
_Parts = dict[str, tuple[Mapping[str, Any], Any]]


@cache
def declared(cls: type) -> dict[str, tuple[Mapping[str, Any], Any]]:
    """Metadata and type of a dataclass's fields; those of `files` are not stored."""
    hints = get_type_hints(cls)
    return {field.name: (field.metadata, hints[field.name]) for field in dataclasses.fields(cls)
            if field.name != "files"}  # fmt: skip


def describe(item: Any, metadata: Mapping[str, Any]) -> None:
    """Units, description and symbol as attributes. A word has no units."""
    for name, key in ATTRIBUTES.items():
        if metadata.get(key) and (name, metadata[key]) != ("units", "-"):
            item.attrs[name] = metadata[key]


def write_fields(group: Any, result: Any) -> None:
    """The fields of a dataclass into a group, with their dimensions. Raises `TypeError` for what cannot be stored."""
    _fill(group, _fields(result))


def _fields(result: Any) -> _Parts:
    return {name: (metadata, _part(getattr(result, name), kind))
            for name, (metadata, kind) in declared(result.__class__).items()}  # fmt: skip


def _part(value: Any, kind: Any) -> Any:
    if dataclasses.is_dataclass(value):
        return _fields(value)
    if isinstance(value, Mapping):
        return {str(key): ({}, _part(part, part_kind(kind))) for key, part in value.items()}
    if isinstance(value, tuple) and (row_class(kind) or (value and dataclasses.is_dataclass(value[0]))):
        return [*value]
    return (storable(float("nan")), (0,)) if value is None else (storable(value), ())


def _fill(group: Any, parts: _Parts, scale: Any = None) -> None:
    """Put parts into a group; those of a table share its `scale`."""
    members = dict.fromkeys(parts)  # no dimension is called like a field of the rows that has no column
    for name, (said, part) in parts.items():
        if part is not None:
            members[name] = _put(group, name, part, said, scale)
    first = () if scale is None else ("",)
    attach(group, members, {name: (*first, *said.get("dimensions", ())) for name, (said, _) in parts.items()}, scale)


def _put(group: Any, name: str, part: Any, said: Mapping[str, Any], scale: Any) -> Any:
    if isinstance(part, tuple):
        item = _dataset(group, name, *part)
    else:
        item = group.create_group(name, track_order=True)
        if isinstance(part, list):
            _put_rows(item, part)
        else:
            unit = {"unit": said.get("unit", "")}
            _fill(item, {key: (own or unit, inner) for key, (own, inner) in part.items()}, scale)
    describe(item, said)
    return item


def _put_rows(group: Any, rows: Sequence[Any]) -> None:
    group.attrs[ROWS] = len(rows)
    if len({type(row) for row in rows}) > 1:
        raise TypeError("rows of several classes cannot be stored as one table")
    columns = _columns(rows) if rows else {}
    apart = [name for name, (_, column) in columns.items() if column is None]
    numbers = [str(index) for index in range(len(rows) if apart else 0)]
    scale = row_scale(group, free_row_name({**columns, **dict.fromkeys(numbers)}), len(rows))
    _fill(group, columns, scale)
    for number, row in zip(numbers, rows):
        fields = _fields(row)
        _fill(group.create_group(number, track_order=True), {name: fields[name] for name in apart})


def _columns(rows: Sequence[Any]) -> _Parts:
    return {name: (metadata, _column([getattr(row, name) for row in rows]))
            for name, (metadata, _) in declared(rows[0].__class__).items()}  # fmt: skip


def _column(cells: Sequence[Any]) -> Any:
    first = next((cell for cell in cells if cell is not None), None)
    if dataclasses.is_dataclass(first) or isinstance(first, Mapping):
        found = _columns_inside(first, cells)
        return None if found is None or any(column is None for _, column in found.values()) else found
    if isinstance(first, tuple) and any(dataclasses.is_dataclass(part) for cell in cells for part in cell or ()):
        return None
    array = stacked(cells)
    return None if array is None else (array, [index for index, cell in enumerate(cells) if cell is None])


def _columns_inside(first: Any, cells: Sequence[Any]) -> _Parts | None:
    """The columns of cells that are mappings or dataclasses like the first one; None if they do not have the same."""
    if isinstance(first, Mapping):
        alike = all(isinstance(cell, Mapping) and list(cell) == list(first) for cell in cells)
        return {str(key): ({}, _column([cell[key] for cell in cells])) for key in first} if alike else None
    return _columns(cells) if len({type(cell) for cell in cells}) == 1 else None


def storable(value: Any) -> np.ndarray:
    """A NumPy array of one type: text as UTF-8 of any length, numbers little-endian. Raises `TypeError` for others."""
    if isinstance(value, str) or (isinstance(value, tuple) and value and isinstance(value[0], str)):
        return np.asarray(value, dtype=_WORDS)
    array = np.ascontiguousarray(value) if isinstance(value, np.ndarray) and value.ndim else np.asarray(value)
    if array.dtype.kind not in "biuf":
        raise TypeError(f"a value of type {type(value).__name__} ({array.dtype}) cannot be stored")
    return array.astype(array.dtype.newbyteorder("<"), copy=False)


def stacked(values: Sequence[Any]) -> np.ndarray | None:
    """The values of all rows (None where there is none) along a first axis; None if their shapes or types differ."""
    given = [value for value in values if value is not None]
    parts = [storable(value) for value in given]
    if not parts:
        return np.full(len(values), np.nan)
    if len({part.dtype for part in parts}) > 1 and all(map(_is_float, given)):
        parts = [storable(float(value)) for value in given]
    first = parts[0]
    if any(part.shape != first.shape or part.dtype != first.dtype for part in parts):
        return None
    filler = np.full_like(first, {"f": np.nan, "O": ""}.get(first.dtype.kind, 0))
    left = iter(parts)
    whole = np.stack([filler if value is None else next(left) for value in values])
    return np.asarray(whole, dtype=_WORDS) if whole.dtype.kind == "O" else whole


def _is_float(value: Any) -> bool:
    """Whether it is a number, and the same one as a float."""
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return number and (float(value) == value or value != value)


def _dataset(group: Any, name: str, array: np.ndarray, none: Sequence[int] = ()) -> Any:
    """A dataset of what `storable` or `stacked` gave; `none` are the rows without a value."""
    truths = array.dtype.kind == "b"
    item = group.create_dataset(name, data=array.astype(np.int8) if truths else array, track_times=False)
    if truths:
        item.attrs[TRUTHS] = "bool"
    if len(none):
        item.attrs[NONE] = np.asarray(none, dtype="<i8")
    return item


def names(
    shapes: Mapping[str, tuple[int, ...] | None], declared: Mapping[str, Sequence[str]], first: str = ""
) -> dict[str, tuple[str, ...]]:
    """The dimensions of each of the fields that lie beside each other, by name.

    `shapes` has None for what is no array. A field's axes are called as its declaration says, where that name has one
    length among them all; else its first axis is the time, where a field `time` has its length; else FIELD_AXIS. A
    dimension that is called like a field has the field's values. `first` is the first axis of all, if they share one.
    """
    lengths: dict[str, int] = {}

    def fits(name: str, size: int) -> bool:
        return lengths.get(name, size) == size and shapes.get(name, (size,)) == (size,)

    found = {}
    for field, shape in shapes.items():
        said, own = tuple(declared.get(field, ())), list[str]()
        for axis, size in enumerate(shape or ()):
            requested = said[axis] if axis < len(said) else _TIME if axis == 0 and _TIME in shapes else ""
            wanted = first if first and axis == 0 else requested
            free = (f"{field}_{axis}" + "_" * more for more in itertools.count())
            name = next(name for name in itertools.chain([wanted] * bool(wanted), free)
                        if name not in own and fits(name, size))  # fmt: skip
            lengths[name] = size
            own.append(name)
        found[field] = tuple(own)
    return found


def attach(group: Any, members: Mapping[str, Any], declared: Mapping[str, Sequence[str]], row: Any = None) -> None:
    """Give the datasets among `members` of an HDF5 group their dimension scales; `row` is the first one of all."""
    shapes: dict[str, tuple[int, ...] | None] = {name: getattr(item, "shape", None) for name, item in members.items()}
    first = row.name.rpartition("/")[2] if row is not None else ""
    scales = {first: row} if first else {}
    for field, dimensions in names(shapes, declared, first).items():
        for axis, name in enumerate(dimensions):
            item = members[field]
            if name not in scales and name in members:
                scales[name] = members[name]
                members[name].make_scale(name)
            elif name not in scales:
                scales[name] = group.create_dataset(name, (item.shape[axis],), "<f4", track_times=False)
                scales[name].make_scale(_LENGTH_ALONE + b"%10d" % item.shape[axis])
            if item is not scales[name]:
                item.dims[axis].attach_scale(scales[name])


def row_scale(group: Any, name: str, count: int, **storage: Any) -> Any:
    """The dimension scale of a table: the numbers of its rows, from 0."""
    scale = group.create_dataset(name, data=np.arange(count, dtype="<i8"), track_times=False, **storage)
    scale.attrs["long_name"] = "number of the row"
    scale.make_scale(name)
    return scale


def free_row_name(members: Mapping[str, Any]) -> str:
    """`row`, or a longer name that no member has."""
    name = "row"
    while name in members:
        name += "_"
    return name


def members_of(group: Any) -> list[str]:
    """What is in an HDF5 group beside dimensions that have a length alone."""
    return [name for name in group if not has_length_alone(group[name])]


def has_length_alone(item: Any) -> bool:
    """Whether it is a dimension without values."""
    return bytes(item.attrs.get("NAME", b"")).startswith(_LENGTH_ALONE)


def read_fields(group: Any, cls: Any, count: int | None = None) -> Any:
    """The dataclass whose fields are in a group, or that of each of the `count` rows that the group has parts of.

    Raises `KeyError`, `TypeError` or `ValueError` if they do not fit.
    """
    own = declared(cls)
    found = {name: _read(group, name, kind, count) for name, (_, kind) in own.items()}
    if "files" in cls.__dataclass_fields__:
        found["files"] = {} if count is None else [{}] * count
    return cls(**found) if count is None else [cls(**row) for row in _rows(found, count)]


def _rows(columns: Mapping[str, Sequence[Any]], count: int) -> list[dict[str, Any]]:
    return [{name: column[index] for name, column in columns.items()} for index in range(count)]


def _read(group: Any, name: str, kind: Any, count: int | None) -> Any:
    """What a field has, or its cells in each of `count` rows."""
    if count is not None and name not in group:
        return [_read(group[str(index)], name, kind, None) for index in range(count)]
    if name not in group:
        raise KeyError(f"{name} is missing in {group.name}")
    item, kind = group[name], present(kind)
    if not hasattr(item, "shape"):
        return _read_group(item, kind, count)
    none = {*item.attrs.get(NONE, ())}
    if count is None:
        if not none and (dataclasses.is_dataclass(kind) or row_class(kind) or is_mapping(kind)):
            raise TypeError(f"{item.name} is no group")
        return None if none else of_kind(read(item), kind)
    value = read(item)
    if len(value) != count:
        raise ValueError(f"{item.name} has {len(value)} rows, not {count}")
    return [None if index in none else of_kind(cell, kind) for index, cell in enumerate(value)]


def _read_group(group: Any, kind: Any, count: int | None) -> Any:
    """The same of a field that is a dataclass, a table or a mapping."""
    if dataclasses.is_dataclass(kind):
        return read_fields(group, kind, count)
    if row := row_class(kind):
        size = int(group.attrs[ROWS])
        return tuple(read_fields(group, row, size) if size else ())
    if not is_mapping(kind):
        raise TypeError(f"{group.name} is a group")
    parts = {key: _read(group, key, part_kind(kind), count) for key in members_of(group)}
    return parts if count is None else _rows(parts, count)


def read(item: Any) -> Any:
    """A dataset as a NumPy array or number; text, and numbers of words, as Python words.

    Raises `ValueError` for what is no text.
    """
    value = item[()]
    if words := h5py.check_enum_dtype(item.dtype):
        word_of = {number: word for word, number in words.items()}
        return np.array([word_of.get(each, each) for each in value.ravel().tolist()], dtype=object).reshape(value.shape)
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
    if get_origin(kind) is tuple:
        return tuple(get_args(kind)[0](part) for part in plain)
    return kind(plain) if kind in (float, int, bool, str) else plain


def row_class(kind: Any) -> Any:
    """The class of the rows, if the type is that of a table, a tuple of dataclasses; else None."""
    arguments = get_args(present(kind))
    table = get_origin(present(kind)) is tuple and arguments and hasattr(arguments[0], "__dataclass_fields__")
    return arguments[0] if table else None


def is_mapping(kind: Any) -> bool:
    """Whether a type is that of a mapping."""
    return get_origin(kind) in (dict, Mapping)


def part_kind(kind: Any) -> Any:
    """The type of a mapping's values; `object` where it is not said."""
    arguments = get_args(present(kind))
    return arguments[1] if len(arguments) == 2 else object
