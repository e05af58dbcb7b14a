"""A map as an HDF5 file, written in blocks: a column for each varied parameter and each number, with its unit."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

import h5py
import numpy as np

from stages.analytic.maps.answers import COLUMNS, Outcome, Way
from stages.analytic.maps.box import Box

#: Rows that HDF5 compresses together.
CHUNK = 8192
CODES = {"outcome": Outcome, "answered_by": Way}


class MapWriter:
    """Writes a map to a new HDF5 file, in blocks of any order; use as a context manager."""

    def __init__(self, path: Path, box: Box, given: Mapping[str, object]) -> None:
        self._file = h5py.File(path, "w")
        self._box = box
        table = self._file.create_group("map")
        for name, value in given.items():
            table.attrs[name] = value
        table.attrs["axes"] = [axis.name for axis in box.axes]
        table.attrs["shape"] = box.shape if box.seed is None else (box.size,)
        units = {axis.name: axis.unit for axis in box.axes} | COLUMNS
        for name, unit in units.items():
            codes = CODES.get(name)
            words = {each.name.lower().replace("_", " "): int(each) for each in codes} if codes else None
            kind = h5py.enum_dtype(words, np.int8) if words else np.dtype(float)
            column = table.create_dataset(
                name, box.size, kind, chunks=(min(CHUNK, box.size),), compression="gzip", shuffle=True)
            column.attrs["unit"] = unit

    def __enter__(self) -> MapWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._file.close()

    def write(self, first: int, rows: np.ndarray) -> None:
        """Rows (n, columns of `COLUMNS`) of the designs from number `first` on."""
        table, end = self._file["map"], first + len(rows)
        for axis, values in zip(self._box.axes, self._box.values(first, end).T, strict=True):
            table[axis.name][first:end] = values
        for name, values in zip(COLUMNS, rows.T, strict=True):
            table[name][first:end] = values.astype(np.int8) if name in CODES else values


def read_columns(path: Path, names: list[str], most: int) -> dict[str, np.ndarray]:
    """Columns of a map, of at most `most` designs: evenly thinned, if there are more."""
    with h5py.File(path) as file:
        table = file["map"]
        every = -(-len(table["outcome"]) // most)
        return {name: table[name][::every] for name in names}
