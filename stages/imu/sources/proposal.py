"""A first map of a file that nothing is known about: what its head shows, and what only a person can know.

Names tell the columns, brackets or a row of units the units, and where they do not, the size of gravity does. Each
guess is said beside the map, and what no file holds (place, mounting, slope) is left to be filled in.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from stages.imu.errors import SourceRefused, printable
from stages.imu.sources.columns import number
from stages.imu.sources.files import plain_file
from stages.imu.sources.files.text_table import encoding_of
from stages.imu.sources.stamps import UNITS, moments

HEAD_LINES = 2000
DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "space": " "}
USUAL_RATES = (10.0, 5000.0)  # Hz
GRAVITY = {"m/s^2": 9.81, "g": 1.0, "mg": 1000.0}
STANDING = 0.4  # a moving sensor's median reading is gravity to that share
FASTEST_RAD_S = 35.0  # 2000 deg/s: a gyroscope that reads more does not read rad/s

_FORCE = re.compile(r"acc(?!urac)|specific.?force", re.I)
_RATE = re.compile(r"gyr|angular.?(vel|rate)|omega|rot.*rate", re.I)
_OTHER = re.compile(r"mag|quat|euler|free|lin|user|grav|temp|roll|pitch|yaw", re.I)
_AXIS = re.compile(r"(?:^|[^a-z])([xyz])(?:[^a-z]|$)|(?:acc|gyro?|a|g|w)([xyz])(?:[^a-z]|$)", re.I)
_PACKET = re.compile(r"packet|counter|sample.?(number|index|no)|frame|^seq", re.I)
_STAMP = re.compile(r"time|stamp|epoc|elapsed|clock|date|^t$", re.I)
_ARRIVED = re.compile(r"phone|host|receiv|arriv", re.I)
_HZ = re.compile(r"(\d+(?:\.\d+)?)\s*Hz", re.I)
_UNITS = (
    ("mg", r"\bmg\b"), ("m/s^2", r"m\s*/\s*s\s*(\^2|2|²)|m\.s-2|ms-2"), ("g", r"[\[(_ ]g[\])_]?$|^g$"),
    ("deg/s", r"deg|dps|°|º"), ("rad/s", r"rad"),
    ("ns", r"\bns\b"), ("us", r"\bus\b|µs|micro"), ("ms", r"\bms\b|milli"), ("s", r"[\[(]s(ec)?[\])]|^s$"),
)  # fmt: skip


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

    def said_unit(self, column: int, among: Sequence[str]) -> str:
        """The unit that the name or the row of units says; empty where neither does."""
        said = (self.units[column] if column < len(self.units) else "", self.name(column))
        return next((unit for text in said for unit, pattern in _UNITS
                     if unit in among and text and re.search(pattern, text, re.I)), "")  # fmt: skip


def head_of(path: Path) -> Head:
    """What the first lines of a text table show. Raises SourceRefused where they are no table of numbers."""
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
    decimal = delimiter != "comma" and any(re.fullmatch(r"-?\d+,\d+", cell) for row in rows[-5:] for cell in row)
    first = next((i for i, row in enumerate(rows) if len(row) >= 4 and _numeric(row, decimal)), None)
    if first is None:
        raise SourceRefused(f"{printable(path.name)} has no row of numbers among its first {HEAD_LINES} lines")
    above = [i for i in range(first) if len(rows[i]) >= len(rows[first]) - 1 and any(rows[i])]
    names, units, header_rows = None, [], first
    if above:
        has_units = len(above) > 1 and above[-1] == above[-2] + 1
        header_rows = above[-2] if has_units else above[-1]
        names, units = rows[header_rows], rows[above[-1]] if has_units else []
    return Head(delimiter, header_rows, names, units, rows[first:], decimal, "\n".join(lines[:header_rows]))


def _numeric(row: Sequence[str], decimal_comma: bool) -> bool:
    cells = [cell.replace(",", ".") if decimal_comma else cell for cell in row if cell]
    return bool(cells) and sum(number(cell) == number(cell) for cell in cells) >= 0.6 * len(cells)


def proposal(path: Path) -> tuple[str, list[str]]:
    """The text of a map of a file, and a line for each thing that was read, guessed or is to be filled in.

    Raises SourceRefused for what is no text table.
    """
    head = head_of(path)
    columns = columns_of(head)
    layout = [f"{head.delimiter}-separated, {head.header_rows} rows before the names"]
    layout += ["decimal comma"] if head.decimal_comma else []
    layout += [] if head.names else ["no names: columns are called by number"]
    told = [", ".join(layout)]
    stamp = next((name for name in columns if name.endswith("_stamp")), None)
    rate, said = _rate(head, columns.get(stamp) if stamp else None)
    told.append(said)
    force, rates = (_unit(head, columns, kind) for kind in ("a", "g"))
    told += [force[1], rates[1]] if rates[0] else [force[1]]
    missing = [name for name in ("ax", "ay", "az", "gx", "gy", "gz") if name not in columns]
    if missing:
        told.append(f"not found by name, fill in: {', '.join(missing)}")
    beside = _gyroscope_beside(path) if set(missing) == {"gx", "gy", "gz"} else None
    lines = [
        "# Proposed from the file's head; lines that end in ? are to be filled in or confirmed",
        "runs:",
        f"  - experiment: {{name: {_quoted(path.stem)}, origin: measured, slope_deg: null}}  # the ramp's slope ?",
        "    files:",
        f"      - file: {_quoted(path.name)}",
        *_layout(head, 8),
        "        device:",
        "          place: hip  # or foot ?",
        f"          rate_hz: {rate:g}  # nominal rate by the data sheet ?",
        f"          accelerometer_unit: {force[0]}",
        f"          gyroscope_unit: {rates[0] or 'deg/s'}",
        "          forward_axis: null  # sensor axis nearest to forward, such as +x ?",
        "          up_axis: null  # sensor axis nearest to up ?",
        f"        columns: {_columns(head, columns)}",
    ]
    if beside is not None:
        other = head_of(beside)
        found = columns_of(other, "g")
        told.append(f"the gyroscope's file beside it: {beside.name}")
        lines += ["        gyroscope:", f"          file: {_quoted(beside.name)}", *_layout(other, 10),
                  f"          columns: {_columns(other, found)}"]  # fmt: skip
    told.append("to be filled in: slope_deg, place, forward_axis and up_axis")
    return "\n".join(lines) + "\n", told


def columns_of(head: Head, alone: str = "a") -> dict[str, int]:
    """Column by value of table `sample`, as the names tell; axes without a kind are those of `alone` ("a" or "g")."""
    found: dict[str, int] = {}
    for column, name in enumerate(head.names or ()):
        axis = _AXIS.search(name)
        kind = "a" if _FORCE.search(name) else "g" if _RATE.search(name) else ""
        if axis and not _OTHER.search(name):
            letter = (axis[1] or axis[2]).lower()
            named = kind or ("g" if re.match(r"[gw][xyz]", name, re.I) else alone)
            found.setdefault(f"{named}{letter}", column)
        elif _PACKET.search(name):
            found.setdefault("packet", column)
        elif _STAMP.search(name) and np.isfinite(_stamps(head, column)).mean() > 0.5:
            found.setdefault("phone_stamp" if _ARRIVED.search(name) else "device_stamp", column)
    return found


def _stamps(head: Head, column: int) -> np.ndarray:
    values = head.values(column)
    return values if np.isfinite(values).any() else moments(head.texts(column))


def _rate(head: Head, stamp: int | None) -> tuple[float, str]:
    """The sampling rate [Hz], and where it comes from."""
    written = _HZ.search(head.before)
    if written:
        return float(written[1]), f"rate {written[1]} Hz: written above the names"
    if stamp is None:
        return 100.0, "no stamps: the rate of 100 Hz is a guess"
    values = _stamps(head, stamp)
    values = values[np.isfinite(values)]
    step = float((values[-1] - values[0]) / max(len(values) - 1, 1)) if len(values) else 0.0
    said = head.said_unit(stamp, tuple(UNITS))
    for unit in (said,) if said else UNITS:
        rate = 1 / (step * UNITS[unit]) if step > 0 else 0.0
        if USUAL_RATES[0] <= rate <= USUAL_RATES[1]:
            return float(f"{rate:.3g}"), f"rate {rate:.4g} Hz: column {head.name(stamp)!r} advances so, in {unit}"
    return 100.0, f"column {head.name(stamp)!r} advances at no usual rate: 100 Hz is a guess"


def _unit(head: Head, columns: dict[str, int], kind: str) -> tuple[str, str]:
    """Unit of acceleration ("a") or angular rate ("g"), and where it comes from; empty where there is no column."""
    mine = [columns[f"{kind}{axis}"] for axis in "xyz" if f"{kind}{axis}" in columns]
    if not mine:
        return ("m/s^2", "no accelerometer found") if kind == "a" else ("", "")
    what = "acceleration" if kind == "a" else "angular rate"
    said = head.said_unit(mine[0], tuple(GRAVITY) if kind == "a" else ("deg/s", "rad/s"))
    if said:
        return said, f"{what} in {said}: written in the file"
    size = np.linalg.norm(np.column_stack([head.values(column) for column in mine]), axis=1)
    size = size[np.isfinite(size)]
    if kind == "g":
        unit = "deg/s" if len(size) and size.max() > FASTEST_RAD_S else "rad/s"
        return unit, f"{what} in {unit}: a guess by its size"
    usual = float(np.median(size)) if len(size) else 0.0
    for unit, gravity in GRAVITY.items():
        if abs(usual / gravity - 1) < STANDING:
            return unit, f"{what} in {unit}: gravity reads {usual:.4g}"
    return "counts", f"{what} in counts: gravity reads {usual:.4g}; add accelerometer_range_g and bits"


def _gyroscope_beside(path: Path) -> Path | None:
    """The gyroscope's file of the same recording, by its name."""
    for here, there in (("acc", "gyr"), ("Acc", "Gyr"), ("ACC", "GYR")):
        pattern = re.sub(re.escape(here) + r"\w*", there + "*", path.name, count=1)
        match = next((one for one in sorted(path.parent.glob(pattern)) if one != path), None)
        if pattern != path.name and match is not None:
            return match
    return None


def _layout(head: Head, indent: int) -> list[str]:
    lines = [f"delimiter: {head.delimiter}", f"header_rows: {head.header_rows}"]
    lines += [] if head.names else ["header: false"]
    lines += ["decimal: comma"] if head.decimal_comma else []
    return [" " * indent + line for line in lines]


def _columns(head: Head, columns: dict[str, int]) -> str:
    return "{" + ", ".join(f"{value}: {_quoted(head.name(column))}" for value, column in columns.items()) + "}"


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
