"""The head of a table of any kind, before anything is known about it: its layout, names, units, rows, and its maker.

Exports of common makers are recognised by their names, and with them what no name in them says.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np

from stages.imu.sources.cells import number, text_of
from stages.imu.sources.formats import BOOK, PARQUET, format_of, parquet_file, rows_of, seconds_or_numbers, sheets_of
from stages.imu.sources.opening import SourceRefused, blocks, check, printable, refuse
from stages.imu.sources.text_table import DELIMITERS, HEAD_ROWS, Layout, encoding_of, has_decimal_commas

HEAD_LINES = 2000
#: What a remark above the names begins with, which may have as many commas.
REMARKS = ("#", "%", "//")
_UNITS = (
    ("mg", r"\bmg\b"), ("m/s^2", r"(?<![a-zµ])(m\s*/\s*\(?s\s*(\^2|2|²)|m\.s-2|ms-2)"), ("g", r"[\[(_ ]g[\])_]?$|^g$"),
    ("mdps", r"mdps|mdeg|m°|millidegree"),
    ("deg/s", r"(?<!m)(deg|dps|°|º)|\bd/s|\bgrad"), ("rad/s", r"(?<![a-zµ])rad"),
    ("ns", r"\bns\b"), ("us", r"\bus\b|µs|micro"), ("ms", r"\bms\b|milli"), ("s", r"[\[(]s(ec)?[\])]|^s$"),
)  # fmt: skip
#: Units that loggers write and nothing here reads.
OTHER_UNITS = re.compile(r"[cm]m\s*/\s*\(?s|[mµu]rad|\brpm\b|\brev|ft\s*/\s*s|\bgal\b", re.I)


@dataclass(frozen=True)
class Head:
    """The head of a text table: its layout, names and units by column, and cells (n, k) as text."""

    delimiter: str
    header_rows: int
    names: Sequence[str]
    units: Sequence[str]
    rows: Sequence[Sequence[str]]
    decimal_comma: bool
    before: str
    sheet: str = ""

    def values(self, column: int) -> np.ndarray:
        """A column as numbers (n,); NaN for what is none."""
        cells = self.texts(column)
        return np.array([number(cell.replace(",", ".") if self.decimal_comma else cell) for cell in cells])

    def texts(self, column: int) -> list[str]:
        """A column as it stands there."""
        return [row[column] if column < len(row) else "" for row in self.rows]

    def name(self, column: int) -> str:
        """What a map calls the column."""
        return self.names[column] if self.names else str(column + 1)

    def stated(self, column: int) -> tuple[str, str]:
        """What may say the unit of a column: the row of units, if there is one, and the name."""
        return self.units[column] if column < len(self.units) else "", self.name(column)

    def stated_unit(self, column: int, among: Sequence[str]) -> str:
        """The unit that the name or the row of units says; empty where neither does."""
        said = self.stated(column)
        return next((unit for text in said for unit, pattern in _UNITS
                     if unit in among and text and re.search(pattern, text, re.I)), "")  # fmt: skip


@dataclass(frozen=True)
class Maker:
    """An export: `signs` are patterns that each must match a name or a line above, `without` one that must match none;
    units where the file has none; `columns` patterns of names by value, where they are not known by the usual words;
    `note` what to bear in mind."""

    name: str
    signs: tuple[str, ...]
    acceleration: str
    rate: str
    columns: Mapping[str, str] = field(default_factory=dict)
    note: str = ""
    without: str = ""


MAKERS = (
    # Both write the same names; the one in deg/s, the other in rad/s. What is above the names distinguishes them.
    Maker("Xsens DOT (Movella)", ("^SampleTimeFine$", "^DeviceTag|^SyncStatus|^OutputRate|(Xsens|Movella) DOT"),
          "m/s^2", "deg/s",
          {"packet": "^PacketCounter$", "device_stamp": "^SampleTimeFine$"},
          "SampleTimeFine counts us and starts anew after 2^32; FreeAcc columns have no gravity and are left out"),
    Maker("Xsens MTw (MT Manager)", ("^PacketCounter$", "^Acc_X$", "^// "), "m/s^2", "rad/s",
          {"packet": "^PacketCounter$"}, "SampleTimeFine counts ticks of 100 us and is left out"),
    Maker("Xsens MTw (MT Manager)", ("^PacketCounter$", "^Acc_X$"), "m/s^2", "rad/s", {"packet": "^PacketCounter$"},
          without="^SampleTimeFine$|^DeviceTag"),
    Maker("Delsys (EMGworks, Trigno Discover)", (r"^X ?\[s\]$|Time Series \(s\)$", r"\bACC"), "g", "deg/s", {},
          "each channel has a column of times; of several sensors the first is taken"),
    Maker("Shimmer (Consensys)", (r"Accel_(LN|WR)_X",), "m/s^2", "deg/s", {},
          "of two accelerometers the low-noise one (LN) is taken; its range is 2 g"),
    Maker("phyphox", (r"^(Linear )?Acceleration x \(m|^Gyroscope x \(rad",), "m/s^2", "rad/s", {},
          "export the accelerometer with g, not the linear acceleration"),
    Maker("Sensor Logger", ("^seconds_elapsed$",), "m/s^2", "rad/s", {"device_stamp": "^seconds_elapsed$"},
          "Accelerometer has no gravity: take TotalAcceleration, or AccelerometerUncalibrated"),
    Maker("MetaWear (MbientLab)", (r"^epoch? ?\(ms\)", r"^elapsed \(s\)"), "g", "deg/s",
          {"device_stamp": r"^elapsed \(s\)"}, "all its stamps are made of the sensor's ticks"),
    Maker("Axivity AX6 (OmGui)", (r"^Accel-X \(g\)", r"^Gyro-X"), "g", "deg/s", {}),
    Maker("Physics Toolbox", ("^gFx$", "^wx$"), "g", "rad/s",
          {f"a{axis}": f"^gF{axis}$" for axis in "xyz"} | {f"g{axis}": f"^w{axis}$" for axis in "xyz"}),
    Maker("ROS (rostopic, bagpy)", (r"angular_velocity\Wx$", r"linear_acceleration\Wx$"), "m/s^2", "rad/s",
          {"packet": r"header\Wseq$", "device_stamp": r"header\Wstamp$"}
          | {f"a{axis}": rf"linear_acceleration\W{axis}$" for axis in "xyz"}
          | {f"g{axis}": rf"angular_velocity\W{axis}$" for axis in "xyz"},
          "its linear_acceleration has gravity"),
    Maker("Noraxon (myoRESEARCH)", ("Noraxon|MyoMotion|Ultium",), "mg", "deg/s", {},
          "of several segments the first is taken: name the others' columns in entries of their own"),
)  # fmt: skip

#: HDF5 files of APDM: groups with these arrays, a sensor each.
APDM = "APDM Opal"


def maker_of(names: Sequence[str], above: str) -> Maker | None:
    """The maker whose signs are all there; the first of several."""
    lines = above.splitlines()

    def there(pattern: str) -> bool:
        return any(re.search(pattern, text, re.I) for text in (*names, *lines))

    return next((one for one in MAKERS if all(there(sign) for sign in one.signs)
                 and not (one.without and there(one.without))), None)  # fmt: skip


def head_of(path: Path) -> Head:
    """What the first rows of a table show. Raises SourceRefused where they are no table of numbers."""
    kind = format_of(path)
    if kind is BOOK:
        return _of_book(path)
    if kind is PARQUET:
        file = parquet_file(path)
        batch = next(file.iter_batches(batch_size=HEAD_LINES), None)
        columns = [] if batch is None else [_texts(column) for column in batch.columns]
        return Head("", 0, list(file.schema_arrow.names), [], list(zip(*columns)), False, "")
    return _of_text(path)


def _of_book(path: Path) -> Head:
    """The head of the first sheet with a table of numbers."""
    for sheet in sheets_of(path):
        cells = [[text_of(cell) for cell in row] for row in islice(rows_of(path, sheet), HEAD_LINES)]
        if any(len(row) >= 4 and _numeric(row, False) for row in cells):
            return replace(_head(path, "", cells, False, ""), sheet=sheet)
    raise SourceRefused(f"{printable(path.name)} has no sheet with a row of numbers among its first {HEAD_LINES} rows")


def _texts(column: Any) -> list[str]:
    """Cells of a parquet file's column; moments, which Python knows to a microsecond, in seconds since 1970."""
    values = column.to_numpy(zero_copy_only=False)
    return [text_of(cell) for cell in (seconds_or_numbers(values) if values.dtype.kind in "mM" else values).tolist()]


def _of_text(path: Path) -> Head:
    check(path)
    with path.open(encoding=encoding_of(path), errors="replace") as file:
        lines = list(islice(chain.from_iterable(blocks(file, path.name)), HEAD_LINES))
    tail = lines[len(lines) // 2 :]
    widths = {name: [len(row) for line in tail for row in Layout(sign).parted([line])]
              for name, sign in DELIMITERS.items()}  # fmt: skip
    usual = {name: int(np.median(width)) if width else 0 for name, width in widths.items()}
    # A decimal comma parts numbers as well: the sign that stands between the columns is then another one.
    order = [name for name in ("tab", "semicolon", "comma", "space") if usual[name] >= 4]
    refuse((not order, f"{printable(path.name)} is no table of at least four columns"))
    delimiter = order[0]
    rows = [[cell.strip() for cell in row] for row in Layout(DELIMITERS[delimiter]).parted(lines)]
    decimal = has_decimal_commas(rows[-HEAD_ROWS:])
    return _head(path, delimiter, rows, decimal, "\n".join(lines))


def _head(path: Path, delimiter: str, rows: list[list[str]], decimal: bool, text: str) -> Head:
    """The head of rows of cells; `text` is what stands there as it is."""
    first = next((i for i, row in enumerate(rows) if len(row) >= 4 and _numeric(row, decimal)), None)
    if first is None:
        raise SourceRefused(f"{printable(path.name)} has no row of numbers among its first {HEAD_LINES} lines")
    above = [i for i in range(first) if len(rows[i]) >= len(rows[first]) - 1 and any(rows[i])]
    remarks = [rows[i][0].startswith(REMARKS) for i in above[-2:]]
    has_units = len(above) > 1 and above[-1] == above[-2] + 1 and remarks != [True, False]
    header_rows = above[-2] if has_units else above[-1] if above else first
    names, units = rows[header_rows] if above else [], rows[above[-1]] if has_units else []
    return Head(delimiter, header_rows, names, units, rows[first:], decimal, "\n".join(text.split("\n")[:header_rows]))


def _numeric(row: Sequence[str], decimal_comma: bool) -> bool:
    cells = [cell.replace(",", ".") if decimal_comma else cell for cell in row if cell]
    return bool(cells) and sum(number(cell) == number(cell) for cell in cells) >= 0.6 * len(cells)
