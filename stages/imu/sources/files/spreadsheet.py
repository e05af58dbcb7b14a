"""Columns of the first sheet of a spreadsheet."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from stages.imu.errors import SourceRefused, printable
from stages.imu.sources.columns import number, number_or_moment
from stages.imu.sources.files import plain_file
from stages.imu.sources.files.optional import library, no_columns
from stages.imu.sources.files.text_table import Layout

ENDINGS = (".xlsx", ".xlsm")


def rows_of(path: Path) -> Iterator[tuple[Any, ...]]:
    """The cells of the first sheet, row by row, one in memory at a time. Raises SourceRefused."""
    plain_file.check(path)
    openpyxl = library("openpyxl", "files", path)
    try:
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        try:
            yield from book.worksheets[0].iter_rows(values_only=True)
        finally:
            book.close()
    except Exception as error:  # readers of a format raise whatever a broken file makes them raise
        raise SourceRefused(f"{printable(path.name)} is no spreadsheet that can be read") from error


def read(path: Path, layout: Layout, wanted: Sequence[str], stamps: Sequence[str]) -> Mapping[str, np.ndarray]:
    """The columns `wanted` (n,) each, by the names in the row after `header_rows`, or by number from 1.

    A row of units below the names is passed over. Raises SourceRefused.
    """
    rows = islice(rows_of(path), layout.header_rows, None)
    first = next(rows, ())
    names = [str(cell).strip() for cell in first] if layout.header else [str(i + 1) for i in range(len(first))]
    for one in wanted:
        if names.count(one) != 1:
            raise no_columns(path, one, names)
    places = [names.index(one) for one in wanted]
    values = [places[i] for i, one in enumerate(wanted) if one not in stamps]
    found: list[list[float]] = [] if layout.header else [_cells(first, places)]
    for index, row in enumerate(rows):
        if index == 0 and layout.header and not any(number(row[i]) == number(row[i]) for i in values if i < len(row)):
            continue
        if any(cell is not None for cell in row):
            found.append(_cells(row, places))
    table = np.array(found).reshape(-1, len(places))
    for one, column in zip(wanted, table.T):
        if not np.isfinite(column).any():
            raise SourceRefused(f"{printable(path.name)}: the column {printable(one)} holds no numbers")
    return dict(zip(wanted, table.T))


def _cells(row: Sequence[Any], places: Sequence[int]) -> list[float]:
    return [number_or_moment(row[place]) if place < len(row) else float("nan") for place in places]
