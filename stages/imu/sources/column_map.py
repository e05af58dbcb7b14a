"""Measurements from CSV or TSV files, with a column map that says which column is what.

A description of one experiment, as it stands in a YAML file:

    experiment: {name: 8-5, slope_deg: 0}
    files:
      - file: walk_left_foot.txt
        delimiter: tab                # comma, semicolon, tab, space
        header_rows: 1                # rows before the one with the column names
        header: true                  # false: there are no names, and columns are called by their number, from 1
        decimal: point                # or comma; taken from its numbers where nothing is said
        sheet: walk 1                 # of a book, where several have the columns
        device: {place: foot, rate_hz: 100, accelerometer_unit: m/s^2, gyroscope_unit: rad/s}
        columns: {packet: PacketCounter, ax: Acc_X, ay: Acc_Y, az: Acc_Z, gx: Gyr_X, gy: Gyr_Y, gz: Gyr_Z}

`device` takes the columns of table `device` in `stages.imu.sources.schema`, `columns` those of table `sample`. Several
experiments stand as a list under the one key `runs`. A gyroscope that has a file of its own stands under `gyroscope`,
with the same keys but `device`; its rows are brought to those of the accelerometer by packet and position where both
files have them, else by stamp. A MATLAB or HDF5 file has names of arrays in the place of columns, a bag of ROS or an
MCAP file topics with fields. Stamps may be in any unit that the nominal rate confirms, or written dates and times;
`nanoseconds` is the column beside a `device_stamp` of whole seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from stages.imu.sources.cells import device_from_row, experiment_from_row, in_seconds, number, recording_from_columns
from stages.imu.sources.formats import read
from stages.imu.sources.opening import SourceRefused, printable, refuse
from stages.imu.sources.schema import NANOSECONDS, SAMPLE_VALUES, TABLES, Device, Experiment, Recording
from stages.imu.sources.text_table import DELIMITERS, Layout

NEEDED = ("ax", "ay", "az", "gx", "gy", "gz")
RUN_KEYS = {"experiment", "files"}
TABLE_KEYS = {"file", "delimiter", "header_rows", "header", "decimal", "sheet", "columns"}
FILE_KEYS = TABLE_KEYS | {"device", "gyroscope"}
ACCELERATION, ANGULAR_RATE = NEEDED[:3], NEEDED[3:]
STAMPS = tuple(name for name in SAMPLE_VALUES if name.endswith("_stamp"))
FARTHEST = 1.5  # sampling periods between two rows of a gyroscope's file that are bridged
DEVICE_KEYS, EXPERIMENT_KEYS = ({name for name, _, _ in TABLES[table]} for table in ("device", "experiment"))
#: Says where the entry under keys, one inside the other, stands in the map.
Where = Callable[..., str]


@dataclass(frozen=True)
class ColumnMap:
    """How to read one file: its layout, and the column's name for each value; `gyroscope`: a file of its own."""

    file: str
    layout: Layout
    device: Device
    columns: Mapping[str, str]
    gyroscope: ColumnMap | None = None


class CsvSource:
    """The files of one experiment, or of several; reads only.

    Raises SourceRefused, in one sentence, for what cannot be read.
    """

    def __init__(self, description: Mapping[str, Any], folder: Path) -> None:
        self.folder = folder
        self.maps = []
        whole: Where = getattr(description, "place", spelt)
        listed = _list(description.get("runs", [description]), whole("runs"), "experiments with their files")
        for row, one in enumerate(listed):
            where = partial(whole, "runs", row) if "runs" in description else whole
            run = mapping_of(one, where, RUN_KEYS)
            experiment = experiment_of(run.get("experiment", {}), partial(where, "experiment"))
            files = _list(run.get("files"), where("files"), "files")
            self.maps.append((experiment, tuple(
                _column_map(entry, partial(where, "files", place)) for place, entry in enumerate(files))))

    def runs(self) -> Iterator[tuple[Experiment, tuple[Recording, ...]]]:
        """Each experiment with the recordings of all its files; one is in memory at a time."""
        for experiment, maps in self.maps:
            yield experiment, tuple(self._read(experiment, one) for one in maps)

    def _read(self, experiment: Experiment, one: ColumnMap) -> Recording:
        table = self._table(one)
        if one.gyroscope is not None:
            other = self._table(one.gyroscope)
            table[:, -3:] = beside(table, other, one)[:, -3:]
        return recording_from_columns(experiment, one.device, table)

    def _table(self, one: ColumnMap) -> np.ndarray:
        """Values of a file (n, 11) in the order of `SAMPLE_VALUES`; NaN for those that are not mapped."""
        wanted = list(dict.fromkeys(one.columns.values()))
        stamps = [name for value, name in one.columns.items() if value in STAMPS]
        path = self.folder / one.file
        outside = path.is_file() and not path.resolve().is_relative_to(self.folder.resolve())
        refuse((outside, f"{printable(one.file)} lies outside of {printable(self.folder.name)}: a map names files "
                "of its folder"))  # fmt: skip
        found = dict(read(path, one.layout, wanted, stamps))
        table, more = np.full((len(next(iter(found.values()))), len(SAMPLE_VALUES)), np.nan), np.zeros(1)
        for name in wanted:
            values = found.pop(name)  # so that each is in memory once
            for column, value in enumerate(SAMPLE_VALUES):
                if one.columns.get(value) == name:
                    table[:, column] = values
            if one.columns.get(NANOSECONDS) == name:
                more = 1e-9 * values
        table[:, SAMPLE_VALUES.index("device_stamp")] += more
        # Rows of other, longer columns hold nothing of this sensor. Without stamp or number a row is a sample's place.
        known = np.isfinite(table).any(axis=1)
        return table if known.all() or not np.isfinite(table[:, :5]).any() else table[known]


def beside(table: np.ndarray, other: np.ndarray, one: ColumnMap) -> np.ndarray:
    """Rows of a gyroscope's file (m, 11) brought to those of the accelerometer's (n, 11).

    Raises SourceRefused where the two have nothing in common that orders them.
    """
    result = np.full(table.shape, np.nan)
    if np.isfinite(table[:, 0]).all() and np.isfinite(other[:, 0]).all() and len(table) and len(other):
        keys = {key: row for row, key in enumerate(map(tuple, np.nan_to_num(other[:, :2]).tolist()))}
        rows = np.array([keys.get(key, -1) for key in map(tuple, np.nan_to_num(table[:, :2]).tolist())])
        result[rows >= 0] = other[rows[rows >= 0]]
        return result
    for stamp in range(2, 5):
        at, there = (in_seconds(part[:, stamp], one.device.rate_hz) for part in (table, other))
        if np.isfinite(at).any() and np.isfinite(there).any():
            known = np.isfinite(there)
            order = np.argsort(there[known], kind="stable")
            result[:, -3:] = between(at, there[known][order], other[known][order, -3:], FARTHEST / one.device.rate_hz)
            return result
    raise SourceRefused(
        f"{printable(one.file)} and its gyroscope's file have neither packet numbers nor a stamp in common"
    )


def between(at: np.ndarray, time: np.ndarray, value: np.ndarray, farthest: float) -> np.ndarray:
    """Values (m, k) at increasing times (m,) [s] by straight lines at (n,) [s]; NaN where neighbours are far apart."""
    straight = np.column_stack([np.interp(at, time, axis, left=np.nan, right=np.nan) for axis in value.T])
    right = np.clip(np.searchsorted(time, at), 1, len(time) - 1)
    straight[time[right] - time[right - 1] > farthest] = np.nan
    return straight


def spelt(*keys: str | int) -> str:
    """Where an entry of a map stands that was not read from a file: its keys, one inside the other."""
    return ".".join(map(str, keys)) or "a run"


def _column_map(entry: Mapping[str, Any], where: Where) -> ColumnMap:
    """The map of a file, and of its gyroscope's, which is the same sensor's."""
    mapping_of(entry, where, FILE_KEYS)
    apart = entry.get("gyroscope")
    file, layout, columns = _table_map(entry, NEEDED if apart is None else ACCELERATION, where)
    device = device_of(entry.get("device", {}), partial(where, "device"))
    if apart is None:
        return ColumnMap(file, layout, device, columns)
    inside = partial(where, "gyroscope")
    own, own_layout, names = _table_map(mapping_of(apart, inside, TABLE_KEYS), ANGULAR_RATE, inside)
    return ColumnMap(file, layout, device, columns, ColumnMap(own, own_layout, device, names))


def experiment_of(said: Any, where: Where) -> Experiment:
    """The experiment that stands in a map. Raises SourceRefused with an unknown key, or a slope that is none."""
    row = mapping_of(said, where, EXPERIMENT_KEYS)
    slope = row.get("slope_deg")
    refuse((slope is not None and not abs(number(slope)) < 90,
            f"{where('slope_deg')} is {printable(slope)}, must be a number between -90 and 90; leave it out where "
            "nobody read it off"))  # fmt: skip
    return experiment_from_row(row)


def device_of(said: Any, where: Where) -> Device:
    """The sensor that stands in a map. Raises SourceRefused with an unknown key or a value without meaning."""
    return device_from_row(mapping_of(said, where, DEVICE_KEYS), where())


def _table_map(
    entry: Mapping[str, Any], needed: Sequence[str], where: Where
) -> tuple[str, Layout, Mapping[str, str]]:  # fmt: skip
    """File, layout and columns of an entry."""
    usual = {"file": None, "delimiter": "comma", "header_rows": 0, "header": True, "decimal": None, "sheet": ""}
    file, delimiter, rows, header, decimal, sheet = (entry.get(key, value) for key, value in usual.items())
    within = partial(where, "columns")
    columns = {str(key): str(name) for key, name in mapping_of(entry.get("columns", {}), within).items()}
    mapping_of(columns, within, {*SAMPLE_VALUES, NANOSECONDS})
    needed = (*needed, *(["device_stamp"] if NANOSECONDS in columns else []))
    missing = [value for value in needed if value not in columns]
    refuse(
        (not (isinstance(file, str) and file), f"{where('file')}: needs the name of a file"),
        (delimiter not in DELIMITERS,
         f"{where('delimiter')} is {printable(delimiter)}, must be one of {', '.join(DELIMITERS)}"),
        (not isinstance(rows, int) or not 0 <= rows <= 1000,
         f"{where('header_rows')} is {printable(rows)}, must be a whole number from 0 to 1000"),
        (not isinstance(header, bool), f"{where('header')} is {printable(header)}, must be true or false"),
        (decimal not in (None, "point", "comma"),
         f"{where('decimal')} is {printable(decimal)}, must be point or comma"),
        (bool(missing), f"{within()}: columns lack {', '.join(missing)}"),
        (not isinstance(sheet, str),
         f"{where('sheet')} is {printable(sheet)}, must be the name of a sheet of the book"),
    )
    comma = None if decimal is None else decimal == "comma"
    return file, Layout(DELIMITERS[delimiter], rows, header, comma, sheet), columns


def _list(value: Any, where: str, what: str) -> Sequence[Any]:
    good = isinstance(value, Sequence) and not isinstance(value, str) and bool(value)
    refuse((not good, f"{where}: must be a list of {what}"))
    return list(value)


def mapping_of(value: Any, where: Where, known: set[str] | None = None) -> Mapping[str, Any]:
    """The value, if it is a mapping with no keys but those that are known."""
    refuse((not isinstance(value, Mapping), f"{where()}: must be a mapping of keys to values"))
    unknown = [(True, f"{where(key)}: unknown key {printable(key)}; known are {', '.join(sorted(known or ()))}")
               for key in value if known is not None and key not in known]  # fmt: skip
    refuse(*unknown)
    return dict(value)
