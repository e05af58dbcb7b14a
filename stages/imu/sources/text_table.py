"""Columns of a text table, of any encoding a logger writes, in bounded memory.

The rows are read in blocks. A block in which every cell wanted is a number is read by NumPy's C reader; any other is
read cell by cell, and what is no number becomes NaN.
"""

from __future__ import annotations

import csv
import re
from codecs import getincrementaldecoder
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from stages.imu.sources.cells import moments, number
from stages.imu.sources.opening import SourceRefused, blocks, check, place_of, printable, refuse

DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "space": " "}
LEAST_READ = 0.5  # of the cells that hold anything: below it the column is something else than numbers
HEAD_BYTES, HEAD_ROWS = 4096, 200
#: A number with a decimal comma, and not perhaps one whose thousands are parted by it.
_DECIMAL_COMMA = re.compile(r"[-+]?(0?,\d+|\d+,(?!\d{3}$)\d+)([eE][-+]?\d+)?$")


@dataclass(frozen=True)
class Layout:
    """How a table is laid out: `header_rows` stand before the one with the names; without `header` columns are called
    by their number, from 1. Where nothing is said, its numbers show whether a text has decimal commas, and its names
    which `sheet` of a book is meant. Of columns that spaces part, rows have so many `cells`, 0 for any: they stand one
    below the other with as many spaces as that takes, and a row of fewer does not say which is missing."""

    delimiter: str = ","
    header_rows: int = 0
    header: bool = True
    decimal_comma: bool | None = None
    sheet: str = ""
    cells: int = 0

    def parted(self, lines: Iterable[str]) -> list[list[str]]:
        """The cells of each line."""
        spaced = self.delimiter == " "
        lines = (line.strip() for line in lines) if spaced else lines
        return list(csv.reader(lines, delimiter=self.delimiter, skipinitialspace=spaced))


def encoding_of(path: Path) -> str:
    """UTF-16 where its mark or its zeros are there, else UTF-8, whose mark is left out, or where its head is none what
    spreadsheets of Western Europe write."""
    with path.open("rb") as file:
        head = file.read(HEAD_BYTES)
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    odd, even = head[1::2].count(0), head[::2].count(0)
    if max(odd, even) > len(head) // 4:
        return "utf-16-le" if odd > even else "utf-16-be"
    try:
        getincrementaldecoder("utf-8")().decode(head)  # a character may be cut at the end of the head
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8-sig"


def read(path: Path, layout: Layout, wanted: Sequence[str], stamps: Sequence[str]) -> Mapping[str, np.ndarray]:
    """The columns `wanted` (n,) each; those among `stamps` may be written dates or times of day.

    Raises SourceRefused for a column that is not there once, and for one that cannot be read.
    """
    check(path)
    name, first = path.name, list[str]()
    try:
        with path.open(encoding=encoding_of(path), errors="replace") as file:
            parts = blocks(file, name)
            while len(first) <= layout.header_rows and (block := next(parts, None)) is not None:
                first += block
            first = first[layout.header_rows :]
            head = [row for line in first[: HEAD_ROWS + 1] for row in layout.parted([line])]
            columns, layout, begin = _begun(name, head, layout, wanted, stamps)
            for block in chain((first[begin:],), parts):
                if block and not _added_at_once(block, layout, columns):
                    _add_cells(layout.parted(block), layout, columns)
    except csv.Error as error:
        raise SourceRefused(f"{printable(name)} is no table ({error})") from error
    except (OSError, UnicodeError) as error:
        raise SourceRefused(f"{printable(name)} cannot be read") from error
    return {one.name: one.checked(name) for one in columns}


def columns_of(
    file: str, rows: Sequence[Sequence[str]], layout: Layout, wanted: Sequence[str], stamps: Sequence[str]
) -> Mapping[str, np.ndarray]:
    """The columns `wanted` (n,) each of rows of cells, which begin with the one after the header rows; as `read`."""
    columns, layout, begin = _begun(file, rows, layout, wanted, stamps)
    _add_cells(rows[begin:], layout, columns)
    return {one.name: one.checked(file) for one in columns}


def _begun(
    file: str, rows: Sequence[Sequence[str]], layout: Layout, wanted: Sequence[str], stamps: Sequence[str]
) -> tuple[list[_Column], Layout, int]:
    """The columns before anything is read, the layout with its decimal sign, and the row at which values begin: below
    the names, and below a row of units, which is one without a number in any column of values."""
    names = names_of(rows[0] if rows else [], layout)
    columns = [_Column(one, place_of(file, one, names), one in stamps) for one in wanted]
    values = rows[layout.header : layout.header + HEAD_ROWS]
    if layout.decimal_comma is None:
        layout = replace(layout, decimal_comma=has_decimal_commas(values))
    places = [one.place for one in columns if not one.may_be_written] if layout.header else []
    said = [row[place].strip() for row in values[:1] for place in places if place < len(row) and row[place].strip()]
    begin = layout.header + (bool(said) and not np.isfinite(_numbers(said, layout)).any())
    cells = len(rows[begin]) if layout.delimiter == " " and begin < len(rows) else 0
    return columns, replace(layout, cells=cells), begin


class _Column:
    """One column as it is read: its parts so far, how many cells held something, and the first that could not be read.

    `written` says whether it has turned out to hold written times.
    """

    def __init__(self, name: str, place: int, may_be_written: bool) -> None:
        self.name, self.place, self.may_be_written = name, place, may_be_written
        self.written = False
        self.parts: list[np.ndarray] = []
        self.filled, self.odd = 0, ""

    def add(self, cells: Sequence[str], layout: Layout) -> None:
        """Cells, stripped, as text."""
        found = _numbers(cells, layout)
        filled = sum(map(bool, cells))
        if self.may_be_written and np.isfinite(found).sum() < LEAST_READ * filled:
            self.written = True
            found = moments(cells)
        self.odd = self.odd or next((cell for cell, value in zip(cells, found) if cell and value != value), "")
        self.filled += filled
        self.parts.append(found)

    def checked(self, file: str) -> np.ndarray:
        """The whole column (n,). Raises SourceRefused if it holds something that was not read, or nothing."""
        whole = np.concatenate(self.parts) if self.parts else np.empty(0)
        self.parts.clear()
        column = f"{printable(file)}: the column {printable(self.name)}"
        refuse((len(whole) > 0 and not self.filled, f"{column} is empty"),
               (bool(np.isfinite(whole).sum() < LEAST_READ * self.filled), f"{column} cannot be read "
                f"({printable(self.odd, 30)} is no {'time' if self.may_be_written else 'number'})"))  # fmt: skip
        return whole


def _added_at_once(block: Sequence[str], layout: Layout, columns: Sequence[_Column]) -> bool:
    """Whether NumPy has read the block but for written times; not where spaces part its columns."""
    plain, text = ([one for one in columns if one.written == written] for written in (False, True))
    quoted = bool(text) and any('"' in line for line in block)
    table = None if quoted or layout.cells else _fast(block, layout, [one.place for one in plain])
    rows = [line.split(layout.delimiter) for line in block if line.strip()] if text else []
    if table is None or (text and len(rows) != len(table)):
        return False
    for one, values in zip(plain, table.T):
        one.parts.append(values)
        one.filled += len(values)
    _add_cells(rows, layout, text)
    return True


def _add_cells(rows: Sequence[Sequence[str]], layout: Layout, columns: Sequence[_Column]) -> None:
    there = [row if len(row) == (layout.cells or len(row)) else [] for row in rows if any(cell.strip() for cell in row)]
    for one in columns:
        one.add([row[one.place].strip() if one.place < len(row) else "" for row in there], layout)


def has_decimal_commas(rows: Iterable[Sequence[str]]) -> bool:
    """Whether any cell is a number with a decimal comma; where commas part the cells too, such a one is quoted."""
    return any(_DECIMAL_COMMA.match(cell.strip()) for row in rows for cell in row)


def names_of(cells: Sequence[Any], layout: Layout) -> list[str]:
    """Names of the columns, from the first row after the header rows; numbers from 1 where there is no header."""
    if layout.header:
        return [str(cell).strip().lstrip("\ufeff") for cell in cells]
    return [str(i + 1) for i in range(len(cells))]


def _fast(block: Sequence[str], layout: Layout, places: Sequence[int]) -> np.ndarray | None:
    """The block's columns (n, k) where all are plain numbers; None where any is not, or commas part cells and decimals.
    """
    lines = [line.replace(",", ".") for line in block] if layout.decimal_comma else block
    try:
        return np.loadtxt(lines, delimiter=layout.delimiter, usecols=places, comments=None, quotechar='"', ndmin=2)
    except (ValueError, IndexError):
        return None


def _numbers(cells: Sequence[str], layout: Layout) -> np.ndarray:
    plain = [cell.replace(",", ".") for cell in cells] if layout.decimal_comma else cells
    return np.array([number(cell) if cell else np.nan for cell in plain], dtype=float)
