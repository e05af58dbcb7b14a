"""Measurements from CSV or TSV files, with a column map that says which column is what.

A description of one experiment, as it stands in a YAML file:

    experiment: {name: 8-5, slope_deg: 0}
    files:
      - file: walk_left_foot.txt
        delimiter: tab                # comma, semicolon, tab, space
        header_rows: 1                # rows before the one with the column names
        device: {place: foot, rate_hz: 100, accelerometer_unit: m/s^2, gyroscope_unit: rad/s}
        columns: {packet: PacketCounter, ax: Acc_X, ay: Acc_Y, az: Acc_Z, gx: Gyr_X, gy: Gyr_Y, gz: Gyr_Z}

`device` takes the columns of table `device` in `stages.imu.sources.schema`, `columns` those of table `sample`. Several
experiments stand as a list under the one key `runs`.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from stages.imu.errors import SourceRefused, printable
from stages.imu.sources import plain_file
from stages.imu.sources.columns import device_from_row, experiment_from_row, numbers
from stages.imu.sources.schema import SAMPLE_VALUES, TABLES, Device, Experiment, Recording, recording_from_columns

DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "space": " "}
NEEDED = ("ax", "ay", "az", "gx", "gy", "gz")
RUN_KEYS = {"experiment", "files"}
FILE_KEYS = {"file", "delimiter", "header_rows", "device", "columns"}
DEVICE_KEYS = {name for name, _, _ in TABLES["device"]}


@dataclass(frozen=True)
class ColumnMap:
    """How to read one file: its delimiter, rows before the column names, the sensor, and column name per value."""

    file: str
    delimiter: str
    header_rows: int
    device: Device
    columns: Mapping[str, str]


class CsvSource:
    """The files of one experiment, or of several; reads only.

    Raises SourceRefused, in one sentence, for what cannot be read.
    """

    def __init__(self, description: Mapping[str, Any], folder: Path) -> None:
        self.folder = folder
        described = description.get("runs", [description])
        if not isinstance(described, Sequence) or isinstance(described, str) or not described:
            raise SourceRefused("runs: must be a list of experiments with their files")
        self.maps = []
        for one in described:
            run = _mapping(one, "a run")
            _only(run, RUN_KEYS, "a run")
            experiment = experiment_from_row(_mapping(run.get("experiment", {}), "experiment"))
            self.maps.append((experiment, column_maps(run)))

    def __enter__(self) -> CsvSource:
        return self

    def __exit__(self, *error: object) -> None:
        """Nothing is kept open."""

    def runs(self) -> Iterator[tuple[Experiment, tuple[Recording, ...]]]:
        """Each experiment with the recordings of all its files; one is in memory at a time."""
        for experiment, maps in self.maps:
            yield experiment, tuple(self._read(experiment, one) for one in maps)

    def _read(self, experiment: Experiment, one: ColumnMap) -> Recording:
        path = self.folder / one.file
        plain_file.check(path)
        try:
            with path.open(encoding="utf-8", errors="replace", newline="") as file:
                lines = islice(plain_file.lines(file, one.file), one.header_rows, None)
                rows = csv.reader(lines, delimiter=one.delimiter)
                names = [name.strip().lstrip("\ufeff") for name in next(rows, [])]
                filled = [row for row in rows if any(cell.strip() for cell in row)]
                return self._recording(experiment, one, names, filled)
        except (OSError, ValueError) as error:
            if isinstance(error, SourceRefused):
                raise
            raise SourceRefused(f"{printable(one.file)} cannot be read") from error
        except csv.Error as error:
            raise SourceRefused(f"{printable(one.file)} is no table ({error})") from error

    def _recording(
        self, experiment: Experiment, one: ColumnMap, names: Sequence[str], rows: Sequence[Sequence[str]]
    ) -> Recording:
        repeated = [name for name in one.columns.values() if names.count(name) != 1]
        if repeated:
            has = "more than once" if repeated[0] in names else "not at all"
            raise SourceRefused(f"{printable(one.file)} has the column {printable(repeated[0])} {has}")
        place = [names.index(one.columns[value]) if value in one.columns else None for value in SAMPLE_VALUES]
        cells = [[None if at is None or at >= len(row) else row[at] for at in place] for row in rows]
        return recording_from_columns(experiment, one.device, numbers(cells, len(SAMPLE_VALUES)))


def column_maps(description: Mapping[str, Any]) -> tuple[ColumnMap, ...]:
    """The column maps of a description. Raises SourceRefused for what is missing, unknown or meaningless in it."""
    files = description.get("files")
    if not isinstance(files, Sequence) or isinstance(files, str) or not files:
        raise SourceRefused("a description of CSV files needs a list of files")
    entries = [_mapping(entry, f"files, entry {number}") for number, entry in enumerate(files, 1)]
    return tuple(_column_map(entry, number) for number, entry in enumerate(entries, 1))


def _column_map(entry: Mapping[str, Any], number: int) -> ColumnMap:
    where = f"files, entry {number}"
    _only(entry, FILE_KEYS, where)
    if not isinstance(entry.get("file"), str):
        raise SourceRefused(f"{where}: needs the name of a file")
    delimiter = entry.get("delimiter", "comma")
    if delimiter not in DELIMITERS:
        raise SourceRefused(f"{where}: delimiter is {printable(delimiter)}, must be one of {', '.join(DELIMITERS)}")
    header_rows = entry.get("header_rows", 0)
    if not isinstance(header_rows, int) or not 0 <= header_rows <= 1000:
        raise SourceRefused(f"{where}: header_rows is {printable(header_rows)}, must be a whole number from 0 to 1000")
    columns = {str(key): str(name) for key, name in _mapping(entry.get("columns", {}), f"{where}, columns").items()}
    _only(columns, set(SAMPLE_VALUES), f"{where}, columns")
    missing = [value for value in NEEDED if value not in columns]
    if missing:
        raise SourceRefused(f"{where}: columns lack {', '.join(missing)}")
    device = _mapping(entry.get("device", {}), f"{where}, device")
    _only(device, DEVICE_KEYS, f"{where}, device")
    made = device_from_row(device, f"{where}, device")
    return ColumnMap(entry["file"], DELIMITERS[delimiter], header_rows, made, columns)


def _mapping(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise SourceRefused(f"{where}: must be a mapping of keys to values")
    return value


def _only(entry: Mapping[str, Any], known: set[str], where: str) -> None:
    unknown = [key for key in entry if key not in known]
    if unknown:
        raise SourceRefused(f"{where}: unknown key {printable(unknown[0])}; known are {', '.join(sorted(known))}")
