"""Columns of one file of any kind: text tables, spreadsheets, parquet, MATLAB, HDF5, and bags of robots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from stages.imu.errors import SourceRefused, printable
from stages.imu.sources.files import array_file, bag, parquet, spreadsheet, text_table
from stages.imu.sources.files.text_table import Layout

#: Formats of tables that are not read, and what writes them as one that is.
UNREAD = {".feather": "feather", ".arrow": "Arrow", ".xls": "a spreadsheet of before 2007", ".ods": "OpenDocument"}


def refuse_unread(path: Path) -> None:
    """Raises SourceRefused for a table of a format that is known and not read."""
    kind = UNREAD.get(path.suffix.lower())
    if kind:
        raise SourceRefused(f"{printable(path.name)} is {kind}, which is not read: save it as CSV, .xlsx or parquet")


def read(path: Path, layout: Layout, wanted: Sequence[str], stamps: Sequence[str]) -> Mapping[str, np.ndarray]:
    """The columns `wanted` (n,) each; those among `stamps` may be written dates or times of day.

    The file's ending tells its kind; what has none of the known ones is a text table. Raises SourceRefused.
    """
    ending = path.suffix.lower()
    refuse_unread(path)
    if ending in array_file.ENDINGS:
        return array_file.read(path, wanted)
    if ending in spreadsheet.ENDINGS:
        return spreadsheet.read(path, layout, wanted, stamps)
    if ending in parquet.ENDINGS:
        return parquet.read(path, wanted)
    if bag.is_bag(path):
        return bag.read(path, wanted)
    return text_table.read(path, layout, wanted, stamps)
