"""Dataclasses as groups, and tuples of dataclasses as tables: a dataset for each column along a dimension `row`.

A field whose values have different shapes has no column: those of a row lie together in a group with the row's number.
"""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from pipeline.cache.hdf5 import dimensions, values

#: Attribute of a group that is a table: the number of its rows.
ROWS = "rows"
#: Attributes in the file, and the word that a field's declaration has for each.
ATTRIBUTES = {"units": "unit", "long_name": "description", "symbol": "symbol"}
Columns = dict[str, tuple[Mapping[str, Any], Any]]


@cache
def declared(cls: type) -> dict[str, tuple[Mapping[str, Any], Any]]:
    """Metadata and type of a dataclass's fields; those of `files` are not stored."""
    hints = typing.get_type_hints(cls)
    return {field.name: (field.metadata, hints[field.name]) for field in dataclasses.fields(cls)
            if field.name != "files"}  # fmt: skip


def describe(item: Any, metadata: Mapping[str, Any]) -> None:
    """Units, description and symbol as attributes. A word has no units."""
    for name, key in ATTRIBUTES.items():
        if metadata.get(key) and (name, metadata[key]) != ("units", "-"):
            item.attrs[name] = metadata[key]


def write_fields(group: Any, result: Any, only: Sequence[str] | None = None) -> None:
    """The fields of a dataclass into a group, with their dimensions."""
    own = {name: said for name, said in declared(result.__class__).items() if only is None or name in only}
    members = {name: _write(group, name, getattr(result, name), *said) for name, said in own.items()}
    dimensions.attach(group, members, _dimensions(own))


def _dimensions(own: Mapping[str, tuple[Mapping[str, Any], Any]]) -> dict[str, Sequence[str]]:
    return {name: metadata.get("dimensions", ()) for name, (metadata, _) in own.items()}


def _write(group: Any, name: str, value: Any, metadata: Mapping[str, Any], kind: Any) -> Any:
    if dataclasses.is_dataclass(value):
        item = group.create_group(name, track_order=True)
        write_fields(item, value)
    elif isinstance(value, Mapping):
        item = group.create_group(name, track_order=True)
        about = {"unit": metadata.get("unit", "")}
        members = {str(key): _write(item, str(key), part, about, values.part_kind(kind)) for key, part in value.items()}
        dimensions.attach(item, members, {})
    elif isinstance(value, tuple) and (values.row_class(kind) or (value and dataclasses.is_dataclass(value[0]))):
        item = group.create_group(name, track_order=True)
        _write_rows(item, value)
    elif value is None:
        item = values.write(group, name, values.storable(float("nan")), (0,))
    else:
        item = values.write(group, name, values.storable(value))
    describe(item, metadata)
    return item


def _write_rows(group: Any, rows: Sequence[Any]) -> None:
    group.attrs[ROWS] = len(rows)
    if len({type(row) for row in rows}) > 1:
        raise TypeError("rows of several classes cannot be stored as one table")
    columns: Columns = _columns(rows) if rows else {}
    apart = [name for name, (_, column) in columns.items() if column is None]
    numbers = [str(index) for index in range(len(rows) if apart else 0)]
    scale = dimensions.rows(group, dimensions.free("row", {**columns, **dict.fromkeys(numbers)}), len(rows))
    _write_columns(group, columns, scale)
    for number, row in zip(numbers, rows):
        write_fields(group.create_group(number, track_order=True), row, apart)


def _columns(rows: Sequence[Any]) -> Columns:
    return {name: (metadata, _column([getattr(row, name) for row in rows]))
            for name, (metadata, _) in declared(rows[0].__class__).items()}  # fmt: skip


def _column(cells: Sequence[Any]) -> Any:
    """The cells as one array with the rows that have none, as columns by name, or as None if they do not fit."""
    first = next((cell for cell in cells if cell is not None), None)
    if dataclasses.is_dataclass(first) or isinstance(first, Mapping):
        found = _columns_inside(first, cells)
        return None if found is None or any(column is None for _, column in found.values()) else found
    if isinstance(first, tuple) and any(dataclasses.is_dataclass(part) for cell in cells for part in cell or ()):
        return None
    array = values.column(cells)
    return None if array is None else (array, [index for index, cell in enumerate(cells) if cell is None])


def _columns_inside(first: Any, cells: Sequence[Any]) -> Columns | None:
    """The columns of cells that are mappings or dataclasses like the first one; None if they do not have the same."""
    if isinstance(first, Mapping):
        alike = all(isinstance(cell, Mapping) and list(cell) == list(first) for cell in cells)
        return {str(key): ({}, _column([cell[key] for cell in cells])) for key in first} if alike else None
    return _columns(cells) if len({type(cell) for cell in cells}) == 1 else None


def _write_columns(group: Any, columns: Columns, scale: Any) -> None:
    members = dict.fromkeys(columns)  # no dimension is called like a field of the rows that has no column
    for name, (metadata, column) in columns.items():
        if isinstance(column, dict):
            members[name] = group.create_group(name, track_order=True)
            unit = {"unit": metadata.get("unit", "")}
            _write_columns(members[name], {key: (said or unit, part) for key, (said, part) in column.items()}, scale)
        elif column is not None:
            members[name] = values.write(group, name, *column)
        if column is not None:
            describe(members[name], metadata)
    said = {name: ("", *columns[name][0].get("dimensions", ())) for name in members}
    dimensions.attach(group, members, said, scale)


def read_fields(group: Any, cls: type) -> Any:
    """The dataclass whose fields are in a group. Raises `KeyError`, `TypeError` or `ValueError` if they do not fit."""
    found = {name: _read(group, name, kind) for name, (_, kind) in declared(cls).items()}
    return cls(**found, **_files(cls))


def _files(cls: type) -> dict[str, Any]:
    return {"files": {}} if "files" in cls.__dataclass_fields__ else {}  # type: ignore[attr-defined]


def _read(group: Any, name: str, kind: Any) -> Any:
    item, kind = group[name], values.present(kind)
    if hasattr(item, "shape") and values.NONE in item.attrs:
        return None
    if dataclasses.is_dataclass(kind):
        return read_fields(item, typing.cast(type, kind))
    if values.is_mapping(kind):
        return {key: _read(item, key, values.part_kind(kind)) for key in dimensions.fields(item)}
    if row := values.row_class(kind):
        return tuple(_read_rows(item, row))
    return values.of_kind(values.read(item), kind)


def _read_rows(group: Any, cls: Any) -> list[Any]:
    count = int(group.attrs[ROWS])
    if not count:
        return []
    columns = {name: _cells(group[name], kind, count) if name in group else
               [_read(group[str(index)], name, kind) for index in range(count)]
               for name, (_, kind) in declared(cls).items()}  # fmt: skip
    return _made(cls, columns, count)


def _made(cls: Any, columns: Mapping[str, Sequence[Any]], count: int) -> list[Any]:
    files = _files(cls)
    return [cls(**{name: column[index] for name, column in columns.items()}, **files) for index in range(count)]


def _cells(item: Any, kind: Any, count: int) -> Sequence[Any]:
    """The cells of a column, one a row."""
    kind = values.present(kind)
    if dataclasses.is_dataclass(kind) and not hasattr(item, "shape"):
        own = declared(typing.cast(type, kind))
        return _made(kind, {name: _cells(item[name], part, count) for name, (_, part) in own.items()}, count)
    if values.is_mapping(kind):
        parts = {key: _cells(item[key], values.part_kind(kind), count) for key in dimensions.fields(item)}
        return [{key: part[index] for key, part in parts.items()} for index in range(count)]
    cells, none = values.read(item), set(item.attrs.get(values.NONE, ()))
    if len(cells) != count:
        raise ValueError(f"{item.name} has {len(cells)} rows, not {count}")
    return [None if index in none else values.of_kind(cell, kind) for index, cell in enumerate(cells)]
