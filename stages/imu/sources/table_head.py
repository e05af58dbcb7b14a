"""The head of a table of any kind: its layout, names, units and first rows, before anything is known about it."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from stages.imu.errors import SourceRefused, printable
from stages.imu.sources.columns import number
from stages.imu.sources.files import parquet, plain_file, spreadsheet
from stages.imu.sources.files.text_table import HEAD_ROWS, encoding_of, has_decimal_commas

HEAD_LINES = 2000
DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "space": " "}
_UNITS = (
    ("mg", r"\bmg\b"), ("m/s^2", r"(?<![a-zµ])(m\s*/\s*\(?s\s*(\^2|2|²)|m\.s-2|ms-2)"), ("g", r"[\[(_ ]g[\])_]?$|^g$"),
    ("mdps", r"mdps|mdeg|m°|millidegree"),
    ("deg/s", r"(?<!m)(deg|dps|°|º)|\bd/s"), ("rad/s", r"(?<![mµu])rad"),
    ("ns", r"\bns\b"), ("us", r"\bus\b|µs|micro"), ("ms", r"\bms\b|milli"), ("s", r"[\[(]s(ec)?[\])]|^s$"),
)  # fmt: skip
#: Units that loggers write and nothing here reads.
_OTHER_UNITS = re.compile(r"[cm]m\s*/\s*\(?s|[mµu]rad|\brpm\b|\brev|ft\s*/\s*s|\bgal\b", re.I)


@dataclass(frozen=True)
class Head:
    """The head of a text table: its layout, names and units by column, and cells (n, k) as text."""

    delimiter: str
    header_rows: int
    names: Sequence[str] | None
    units: Sequence[str]
    rows: Sequence[Sequence[str]]
    decimal_comma: bool
    before: str
    sheet: str = ""

    def values(self, column: int) -> np.ndarray:
        """A column as numbers (n,); NaN for what is none."""
        cells = [row[column] if column < len(row) else "" for row in self.rows]
        return np.array([number(cell.replace(",", ".") if self.decimal_comma else cell) for cell in cells])

    def texts(self, column: int) -> list[str]:
        """A column as it stands there."""
        return [row[column] if column < len(row) else "" for row in self.rows]

    def name(self, column: int) -> str:
        """What a map calls the column."""
        return self.names[column] if self.names else str(column + 1)

    def other_unit(self, column: int) -> bool:
        """Whether the name or the row of units says a unit that is not read."""
        said = (self.units[column] if column < len(self.units) else "", self.name(column))
        return any(_OTHER_UNITS.search(text) for text in said)

    def said_unit(self, column: int, among: Sequence[str]) -> str:
        """The unit that the name or the row of units says; empty where neither does."""
        said = (self.units[column] if column < len(self.units) else "", self.name(column))
        return next((unit for text in said for unit, pattern in _UNITS
                     if unit in among and text and re.search(pattern, text, re.I)), "")  # fmt: skip


def head_of(path: Path) -> Head:
    """What the first rows of a table show. Raises SourceRefused where they are no table of numbers."""
    ending = path.suffix.lower()
    if ending in spreadsheet.ENDINGS:
        return _of_book(path)
    if ending in parquet.ENDINGS:
        file = parquet.opened(path)
        batch = next(file.iter_batches(batch_size=HEAD_LINES), None)
        columns = [] if batch is None else [_texts(column) for column in batch.columns]
        return Head("", 0, list(file.schema_arrow.names), [], list(zip(*columns)), False, "")
    return _of_text(path)


def _of_book(path: Path) -> Head:
    """The head of the first sheet with a table of numbers."""
    for sheet in spreadsheet.sheets_of(path):
        cells = [[_text(cell) for cell in row] for row in islice(spreadsheet.rows_of(path, sheet), HEAD_LINES)]
        if any(len(row) >= 4 and _numeric(row, False) for row in cells):
            return replace(_head(path, "", cells, False, ""), sheet=sheet)
    raise SourceRefused(f"{printable(path.name)} has no sheet with a row of numbers among its first {HEAD_LINES} rows")


def _texts(column: Any) -> list[str]:
    """Cells of a parquet file's column; moments, which Python knows to a microsecond, in seconds since 1970."""
    values = column.to_numpy(zero_copy_only=False)
    return [_text(cell) for cell in (parquet.numbers(values) if values.dtype.kind in "mM" else values).tolist()]


def _text(cell: Any) -> str:
    if isinstance(cell, datetime):
        return cell.isoformat()
    return "" if cell is None else str(cell).strip()


def _of_text(path: Path) -> Head:
    plain_file.check(path)
    with path.open(encoding=encoding_of(path), errors="replace") as file:
        lines = list(islice(plain_file.lines(file, path.name), HEAD_LINES))
    tail = lines[len(lines) // 2 :]
    widths = {name: [len(next(csv.reader([line], delimiter=sign), [])) for line in tail] for name, sign in
              DELIMITERS.items()}  # fmt: skip
    usual = {name: int(np.median(width)) if width else 0 for name, width in widths.items()}
    # A decimal comma parts numbers as well: the sign that stands between the columns is then another one.
    order = [name for name in ("tab", "semicolon", "comma", "space") if usual[name] >= 4]
    if not order:
        raise SourceRefused(f"{printable(path.name)} is no table of at least four columns")
    delimiter = order[0]
    rows = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=DELIMITERS[delimiter])]
    decimal = has_decimal_commas(rows[-HEAD_ROWS:], DELIMITERS[delimiter])
    return _head(path, delimiter, rows, decimal, "\n".join(lines))


def _head(path: Path, delimiter: str, rows: list[list[str]], decimal: bool, text: str) -> Head:
    """The head of rows of cells; `text` is what stands there as it is."""
    first = next((i for i, row in enumerate(rows) if len(row) >= 4 and _numeric(row, decimal)), None)
    if first is None:
        raise SourceRefused(f"{printable(path.name)} has no row of numbers among its first {HEAD_LINES} lines")
    above = [i for i in range(first) if len(rows[i]) >= len(rows[first]) - 1 and any(rows[i])]
    names, units, header_rows = None, [], first
    if above:
        has_units = len(above) > 1 and above[-1] == above[-2] + 1
        header_rows = above[-2] if has_units else above[-1]
        names, units = rows[header_rows], rows[above[-1]] if has_units else []
    return Head(delimiter, header_rows, names, units, rows[first:], decimal, "\n".join(text.split("\n")[:header_rows]))


def _numeric(row: Sequence[str], decimal_comma: bool) -> bool:
    cells = [cell.replace(",", ".") if decimal_comma else cell for cell in row if cell]
    return bool(cells) and sum(number(cell) == number(cell) for cell in cells) >= 0.6 * len(cells)
