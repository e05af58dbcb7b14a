"""A table in HDF5 that a question fills block by block, so that it may be larger than memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pipeline.cache import artefact
from pipeline.cache.hdf5 import dimensions
from pipeline.cache.hdf5.tables import describe

#: Rows that are compressed together.
CHUNK = 8192


class BlockTable:
    """A column for each declared one (name, unit, description, words), `size` rows. A column with words holds their
    places among the words, and HDF5 knows the words. The same blocks give the same rows in any order.
    """

    def __init__(self, path: Path, columns: Sequence[Any], size: int, about: Mapping[str, str]) -> None:
        self._file = h5py.File(path, "w", libver=("v110", "v110"), track_order=True)
        self._file.attrs["format"] = artefact.FORMAT
        self._table = self._file.create_group("table", track_order=True)
        for name, text in about.items():
            self._table.attrs[name] = text
        storage = {"chunks": (min(CHUNK, size),), "compression": "gzip", "shuffle": True}
        row = dimensions.rows(self._table, "row", size, **storage)
        for column in columns:
            words = {word: place for place, word in enumerate(column.words)}
            stored = self._table.create_dataset(
                column.name, size, h5py.enum_dtype(words, np.int8) if words else np.dtype(float), track_times=False,
                **storage)  # fmt: skip
            describe(stored, {"unit": column.unit, "description": column.description})
            if words:  # as the CF conventions have it
                stored.attrs["flag_values"] = np.array([*words.values()], dtype=np.int8)
                stored.attrs["flag_meanings"] = " ".join(word.replace(" ", "_") for word in words)
            stored.dims[0].attach_scale(row)

    def write(self, first: int, values: Mapping[str, np.ndarray]) -> None:
        """Values of columns, in the rows from `first` on."""
        for name, part in values.items():
            column = self._table[name]
            column[first : first + len(part)] = np.asarray(part).astype(column.dtype)

    def read(self, name: str, every: int = 1) -> np.ndarray:
        """A column, or each so manyth row of it."""
        return np.asarray(self._table[name][::every])

    def close(self) -> None:
        """Write what is left, and close the file."""
        self._file.close()
