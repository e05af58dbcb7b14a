"""Columns of one file of any kind: text tables, spreadsheets, parquet, MATLAB, HDF5, and bags of robots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from stages.imu.sources.files import array_file, bag, parquet, spreadsheet, text_table
from stages.imu.sources.files.text_table import Layout


def read(path: Path, layout: Layout, wanted: Sequence[str], stamps: Sequence[str]) -> Mapping[str, np.ndarray]:
    """The columns `wanted` (n,) each; those among `stamps` may be written dates or times of day.

    The file's ending tells its kind; what has none of the known ones is a text table. Raises SourceRefused.
    """
    ending = path.suffix.lower()
    if ending in array_file.ENDINGS:
        return array_file.read(path, wanted)
    if ending in spreadsheet.ENDINGS:
        return spreadsheet.read(path, layout, wanted, stamps)
    if ending in parquet.ENDINGS:
        return parquet.read(path, wanted)
    if bag.is_bag(path):
        return bag.read(path, wanted)
    return text_table.read(path, layout, wanted, stamps)
