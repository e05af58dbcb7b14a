"""Columns of a MATLAB file or an HDF5 file: named arrays of one length, or columns of one array."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stages.imu.errors import SourceRefused, printable
from stages.imu.sources.files import plain_file

ENDINGS = (".mat", ".h5", ".hdf5")
_COLUMN = re.compile(r"(.*)\[(\d+)\]$")


def read(path: Path, wanted: Sequence[str]) -> Mapping[str, np.ndarray]:
    """The columns `wanted` (n,) each: "acc_x" is an array, "imu/acc[2]" the second column of an array in a group.

    A .mat of version 7.3 is an HDF5 file, whose arrays MATLAB stores transposed. Raises SourceRefused for a file that
    is neither, for an array that is not there or holds no numbers, and for columns of different length.
    """
    plain_file.check(path)
    with path.open("rb") as file:
        is_hdf5 = b"\x89HDF\r\n\x1a\n" in file.read(520)
    try:
        found = _of_hdf5(path, wanted) if is_hdf5 else _of_matlab(path, wanted)
    except SourceRefused:
        raise
    except Exception as error:  # readers of a format raise whatever a broken file makes them raise
        raise SourceRefused(f"{printable(path.name)} is no MATLAB or HDF5 file that can be read") from error
    lengths = {len(column) for column in found.values()}
    if len(lengths) > 1:
        raise SourceRefused(f"{printable(path.name)}: its columns are {min(lengths)} to {max(lengths)} long")
    return found


def groups_of(path: Path) -> dict[str, list[str]]:
    """Names of the arrays in each group of an HDF5 file, or struct of a MATLAB file. Raises SourceRefused."""
    plain_file.check(path)
    found: dict[str, list[str]] = {}
    try:
        with path.open("rb") as file:
            is_hdf5 = b"\x89HDF\r\n\x1a\n" in file.read(520)
        if not is_hdf5:
            from scipy.io import loadmat

            return _groups_in(loadmat(path, simplify_cells=True), "")
        import h5py

        def seen(name: str, item: Any) -> None:
            if isinstance(item, h5py.Dataset):
                group, _, last = name.rpartition("/")
                found.setdefault(group, []).append(last)

        with h5py.File(path, "r") as opened:
            opened.visititems(seen)
    except Exception as error:  # readers of a format raise whatever a broken file makes them raise
        raise SourceRefused(f"{printable(path.name)} is no MATLAB or HDF5 file that can be read") from error
    return found


def _groups_in(struct: Mapping[str, Any], group: str) -> dict[str, list[str]]:
    """Names of the arrays in a struct, and in those inside of it."""
    found = {group: [name for name, value in struct.items() if isinstance(value, np.ndarray) and value.dtype != object]}
    for name, value in struct.items():
        if isinstance(value, Mapping):
            found |= _groups_in(value, f"{group}/{name}" if group else name)
    return found


def _of_matlab(path: Path, wanted: Sequence[str]) -> dict[str, np.ndarray]:
    from scipy.io import loadmat

    whole = loadmat(path, simplify_cells=True)

    def array(name: str) -> Any:
        value: Any = whole
        for part in name.split("/"):
            value = value[part] if isinstance(value, Mapping) and part in value else None
        return value

    return {one: _column(path.name, one, array, transposed=False) for one in wanted}


def _of_hdf5(path: Path, wanted: Sequence[str]) -> dict[str, np.ndarray]:
    import h5py

    with h5py.File(path, "r") as file:

        def array(name: str) -> Any:
            value = file.get(name)
            return value[()] if isinstance(value, h5py.Dataset) else None

        return {one: _column(path.name, one, array, transposed=path.suffix == ".mat") for one in wanted}


def _column(file: str, wanted: str, array: Any, transposed: bool) -> np.ndarray:
    """One column (n,) of an array that `array` gives by name, or None."""
    values, number = array(wanted), 1
    column = _COLUMN.match(wanted)
    if values is None and column:
        values, number = array(column[1]), int(column[2])
    if values is None:
        raise SourceRefused(f"{printable(file)} has no array {printable(wanted)}")
    table = np.asarray(values)
    if table.dtype.kind not in "fiu" or table.ndim > 2:
        raise SourceRefused(f"{printable(file)}: {printable(wanted)} is no table of numbers")
    table = table.T if transposed and table.ndim == 2 else table
    table = table.reshape(-1, 1) if table.ndim < 2 or 1 in table.shape else table
    if not 1 <= number <= table.shape[1] or (table.shape[1] > 1 and not column):
        raise SourceRefused(
            f"{printable(file)}: {printable(wanted)} must name one of {table.shape[1]} columns, such as "
            f"{printable(wanted.partition('[')[0])}[1]"
        )
    return np.asarray(table[:, number - 1], dtype=float)
