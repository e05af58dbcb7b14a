"""Names of the dimensions of arrays, and dimension scales in HDF5 as netCDF-4 has them."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

_TIME = "time"
#: What netCDF-4 calls a dimension that has a length and no values; readers hide it from the variables.
_LENGTH_ALONE = b"This is a netCDF dimension but not a netCDF variable."


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
            asked = said[axis] if axis < len(said) else _TIME if axis == 0 and _TIME in shapes else ""
            wanted = first if first and axis == 0 else asked
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
            if name not in scales:
                own = name in members
                scales[name] = _coordinate(members[name]) if own else length(group, name, item.shape[axis])
            if item is not scales[name]:
                item.dims[axis].attach_scale(scales[name])


def rows(group: Any, name: str, count: int, **storage: Any) -> Any:
    """The dimension scale of a table: the numbers of its rows, from 0."""
    scale = group.create_dataset(name, data=np.arange(count, dtype="<i8"), track_times=False, **storage)
    scale.attrs["long_name"] = "number of the row"
    scale.make_scale(name)
    return scale


def length(group: Any, name: str, size: int) -> Any:
    """A dimension scale that has a length alone."""
    scale = group.create_dataset(name, (size,), "<f4", track_times=False)
    scale.make_scale(_LENGTH_ALONE + b"%10d" % size)
    return scale


def free(name: str, members: Mapping[str, Any]) -> str:
    """`name`, or a longer one that no member has."""
    while name in members:
        name += "_"
    return name


def fields(group: Any) -> list[str]:
    """What is in an HDF5 group beside dimensions that have a length alone."""
    return [name for name in group if not has_length_alone(group[name])]


def has_length_alone(item: Any) -> bool:
    """Whether it is a dimension without values."""
    return bytes(item.attrs.get("NAME", b"")).startswith(_LENGTH_ALONE)


def _coordinate(dataset: Any) -> Any:
    dataset.make_scale(dataset.name.rpartition("/")[2])
    return dataset
