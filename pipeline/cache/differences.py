"""The numerical errors of a result: parameters that compute it more closely, and how far its numbers then are off."""

import dataclasses
from collections.abc import Iterator
from typing import Any

import h5py
import numpy as np

from pipeline.cache import hdf5
from pipeline.parameters.value import declared

#: Metadata of a field that a closer run changes: a factor on its value, the most that it may be (a whole number), or
#: the word in its place.
CLOSER = "closer"
#: Tolerances below this change nothing but round-off.
FINEST = 1e-12
#: Coordinates are the same where they are to so many decimals, or in the same place by this share of the way between
#: rows: samples around an event lie where a solver finds it. Where no two are, those are that are in the same place
#: nearer than half of that way.
_DECIMALS, _NEAR = 12, 1e-3
#: What some hundreds of operations round, in spacings of floating-point numbers: two that agree better do by chance.
ROUND_OFF = 64
Rows = tuple[np.ndarray, np.ndarray]


def closer(parameters: Any) -> Any:
    """A stage's parameters with all settings of solvers as much closer as their fields say, or as much looser where
    round-off or a bound forbids that.
    """
    return dataclasses.replace(parameters, **{name: _section(each) for name, each in vars(parameters).items()})


def _section(section: Any) -> Any:
    kind: type = type(section)
    values = {key: (getattr(section, key), field) for key, (field, _) in declared(kind).items()
              if field.metadata.get(CLOSER) is not None and getattr(section, key) is not None}  # fmt: skip
    return dataclasses.replace(section, **{key: _closer(*each) for key, each in values.items()}) if values else section


def _closer(value: Any, field: dataclasses.Field[Any]) -> Any:
    by = field.metadata[CLOSER]
    if isinstance(by, str):
        return by
    if isinstance(by, int):
        return min(value, by)
    near = float(f"{value * by:.12g}")
    return near if near >= FINEST and field.metadata["bound"].holds(near) else float(f"{value / by:.12g}")


def differences(one: Any, other: Any, above: str = "") -> Iterator[tuple[str, tuple[float, float]]]:
    """Path of a number, an array or a table's column of the group `one`, its largest difference from `other`, in its
    unit, and what round-off may make of it.

    Arrays and columns are compared over the rows that both have. Those of a table are the same where their words are,
    those of an array that lies along a coordinate where the coordinate is, all others where the sizes are equal. What
    has no row in both is left out, and what says why it has no error.
    """
    names = [name for name in hdf5.members_of(one) if name in other]
    table = hdf5.ROWS in one.attrs
    same = _same_rows(one, other, names) if table else None
    for name in names:
        here, there, path = one[name], other[name], above + name
        if isinstance(here, h5py.Group) and isinstance(there, h5py.Group):
            if same is None or (same[0] == same[1]).all():
                yield from differences(here, there, f"{path}/")
        elif is_of_floats(here) and is_of_floats(there) and hdf5.WITHOUT_ERROR not in here.attrs:
            found = _largest(here, there, same if table else _same_places(here, there))
            if found is not None:
                yield path, found


def _largest(here: Any, there: Any, same: Rows | None) -> tuple[float, float] | None:
    """The largest difference of finite numbers in rows that are the same, or of two single numbers; and round-off."""
    one, other = np.asarray(hdf5.read(here), dtype=float), np.asarray(hdf5.read(there), dtype=float)
    if one.shape[1:] != other.shape[1:] or one.ndim != other.ndim or (one.ndim and same is None):
        return None
    if one.ndim and same is not None:
        one, other = one[same[0]], other[same[1]]
    with np.errstate(invalid="ignore"):
        apart = np.abs(one - other)
    known = np.isfinite(apart)
    if not known.any():
        return None
    size = float(np.abs(one[known]).max())
    return float(apart[known].max()), ROUND_OFF * float(np.spacing(size)) if size else 0.0


def _same_rows(one: Any, other: Any, names: list[str]) -> Rows | None:
    """Rows of two tables that have the same words in the same places, or, of tables that are not equally long, of which
    each has one alone.
    """
    words = [_words(group, names) for group in (one, other)]
    if len(words[0]) == len(words[1]):
        pairs = [(place, place) for place, row in enumerate(words[0]) if row == words[1][place]]
    else:
        pairs = [(words[0].index(row), words[1].index(row)) for row in words[0]
                 if words[0].count(row) == 1 == words[1].count(row)]  # fmt: skip
    first, second = np.array(pairs, dtype=int).reshape(-1, 2).T
    return (first, second) if pairs else None


def _words(group: Any, names: list[str]) -> list[tuple[str, ...]]:
    """The words in each row of a table."""
    columns = [group[name].asstr()[()].tolist() for name in names
               if isinstance(group[name], h5py.Dataset) and h5py.check_string_dtype(group[name].dtype) is not None]
    return list(zip(*columns)) if columns else [()] * int(group.attrs[hdf5.ROWS])


def _same_places(here: Any, there: Any) -> Rows | None:
    """Rows of two arrays along the same values of a coordinate, or in the same places, or nearest where these mean
    nothing.
    """
    if not here.shape or not there.shape:
        return None
    if hdf5.UNORDERED in here.attrs and here.shape == there.shape:
        from scipy.optimize import linear_sum_assignment

        apart = np.linalg.norm(here[()][:, None] - there[()], axis=-1)
        return linear_sum_assignment(np.nan_to_num(apart))  # type: ignore[no-any-return]
    along = [each for each in map(_coordinate, (here, there)) if each is not None]
    if len(along) < 2:
        places = np.arange(here.shape[0])
        return (places, places) if here.shape == there.shape else None
    first, second = (np.round(each, _DECIMALS) for each in along)
    _, one, other = np.intersect1d(first, second, return_indices=True)
    if len(along[0]) == len(along[1]):
        steps = np.abs(np.diff(along[0]))
        room = np.maximum(np.append(steps, 0.0), np.append(0.0, steps))
        moved = np.abs(along[0] - along[1])
        places = np.flatnonzero(moved <= _NEAR * room)
        if max(len(places), len(one)) < 2 and (moved < 0.5 * room).all():  # found itself: all moved a little
            places = np.arange(len(moved))
        if len(places) > len(one):
            return places, places
    return (one, other) if len(one) > 1 else None


def _coordinate(item: Any) -> np.ndarray | None:
    """The values along the first axis of an array, where it has some that are no numbers of rows."""
    scale = item.dims[0][0] if item.dims and len(item.dims[0]) else None
    if scale is None or scale == item or hdf5.has_length_alone(scale):
        return None
    return np.asarray(scale[()], dtype=float) if scale.dtype.kind == "f" else None


def is_of_floats(item: Any) -> bool:
    """Whether something in a file holds floating-point numbers."""
    return isinstance(item, h5py.Dataset) and item.shape is not None and item.dtype.kind == "f"
