"""Columns of a sheet of a book."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
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


def sheets_of(path: Path) -> list[str]:
    """Names of the sheets. Raises SourceRefused."""
    with _opened(path) as book:
        return [sheet.title for sheet in book.worksheets]


def rows_of(path: Path, sheet: str) -> Iterator[tuple[Any, ...]]:
    """The cells of a sheet, row by row, one in memory at a time. Raises SourceRefused."""
    with _opened(path) as book:
        yield from book[sheet].iter_rows(values_only=True)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    plain_file.check(path)
    openpyxl = library("openpyxl", "files", path)
    try:
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        try:
            yield book
        finally:
            book.close()
    except SourceRefused:
        raise
    except Exception as error:  # readers of a format raise whatever a broken file makes them raise
        raise SourceRefused(f"{printable(path.name)} is no spreadsheet that can be read") from error


def _meant(path: Path, layout: Layout, wanted: Sequence[str]) -> str:
    """The sheet that the layout names, or the only one that has the columns wanted. Raises SourceRefused."""
    sheets = sheets_of(path)
    if layout.sheet:
        if layout.sheet not in sheets:
            raise SourceRefused(f"{printable(path.name)} has no sheet {printable(layout.sheet)}; it has "
                                f"{printable(', '.join(sheets), 200)}")  # fmt: skip
        return layout.sheet
    heads = {sheet: next(islice(rows_of(path, sheet), layout.header_rows, None), ()) for sheet in sheets}
    having = [sheet for sheet, head in heads.items() if set(wanted) <= set(_names(head, layout))]
    if len(having) > 1:
        raise SourceRefused(f"{printable(path.name)} has these columns in the sheets "
                            f"{printable(', '.join(having), 200)}: say which by the key sheet")  # fmt: skip
    return having[0] if having else sheets[0]


def _names(head: Sequence[Any], layout: Layout) -> list[str]:
    return [str(cell).strip() for cell in head] if layout.header else [str(i + 1) for i in range(len(head))]


def read(path: Path, layout: Layout, wanted: Sequence[str], stamps: Sequence[str]) -> Mapping[str, np.ndarray]:
    """The columns `wanted` (n,) each, by the names in the row after `header_rows`, or by number from 1.

    A row of units below the names is passed over. Raises SourceRefused.
    """
    rows = islice(rows_of(path, _meant(path, layout, wanted)), layout.header_rows, None)
    first = next(rows, ())
    names = _names(first, layout)
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
