"""Measurements from an SQLite database, opened so that nothing in it or beside it can change."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from stages.imu.columns import device_from_row, experiment_from_row, number, numbers
from stages.imu.refusal import SourceRefused, printable
from stages.imu.schema import SAMPLE_VALUES, TABLES, Device, Experiment, Recording, recording_from_columns

MAGIC = b"SQLite format 3\x00"
WRITE_AHEAD = 2  # in byte 18 or 19 of a database in write-ahead mode


class SqliteSource:
    """A database in the schema of `stages.imu.schema`; use as a context manager.

    Raises SourceRefused, in one sentence, for a file that is missing, no database, broken, locked, or of another shape.
    """

    def __init__(self, path: Path, timeout_s: float = 2.0) -> None:
        self.name = path.name
        self._connection = _open(path, timeout_s)
        try:
            self._check_tables()
            self.devices = self._devices()
        except BaseException:
            self._connection.close()
            raise

    def __enter__(self) -> SqliteSource:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._connection.close()

    def runs(self) -> Iterator[tuple[Experiment, tuple[Recording, ...]]]:
        """Each experiment with its recordings; one experiment is in memory at a time."""
        experiments = {row["experiment_id"]: experiment_from_row(row) for row in self._rows("experiment")}
        for experiment_id, first, last in self._extents():
            experiment = experiments.get(experiment_id) or Experiment(name=f"run {experiment_id}", origin="unknown")
            rows = self._query(
                f"SELECT device_id, {', '.join(SAMPLE_VALUES)} FROM sample "
                "WHERE rowid BETWEEN ? AND ? AND experiment_id IS ? ORDER BY rowid",
                (first, last, experiment_id),
            )
            table = numbers(rows, len(SAMPLE_VALUES) + 1)
            yield experiment, tuple(self._recordings(experiment, table))

    def _recordings(self, experiment: Experiment, table: np.ndarray) -> Iterator[Recording]:
        for device_id in np.unique(table[:, 0]):
            device = self.devices.get(device_id)
            if device is None:
                raise SourceRefused(f"{self.name}: table sample names device {device_id:g}, which table device lacks")
            yield recording_from_columns(experiment, device, table[table[:, 0] == device_id, 1:])

    def _extents(self) -> list[tuple[Any, int, int]]:
        """First and last row of each experiment, found in one walk through the table in constant memory."""
        extent: dict[Any, list[int]] = {}
        for row in self._query_lazily("SELECT rowid, experiment_id FROM sample ORDER BY rowid"):
            if row[1] in extent:
                extent[row[1]][1] = row[0]
            else:
                extent[row[1]] = [row[0], row[0]]
        if not extent:
            raise SourceRefused(f"{self.name}: table sample is empty")
        return [(experiment_id, first, last) for experiment_id, (first, last) in extent.items()]

    def _devices(self) -> dict[float, Device]:
        devices = {}
        for row in self._rows("device"):
            identity = number(row["device_id"])
            if identity != identity:
                raise SourceRefused(f"{self.name}: table device has a row without a device_id")
            devices[identity] = device_from_row(row, f"{self.name}, device {identity:g}")
        return devices

    def _check_tables(self) -> None:
        present = dict(self._query("SELECT name, type FROM sqlite_master WHERE type IN ('table', 'view')"))
        for table, columns in TABLES.items():
            if present.get(table) != "table":
                found = ", ".join(printable(name) for name in list(present)[:5]) or "no tables"
                raise SourceRefused(f"{self.name}: needs a table named {table}; found {found}")
            have = {row[1] for row in self._query(f"PRAGMA table_xinfo({table})")}
            missing = [name for name, _, _ in columns if name not in have]
            if missing:
                raise SourceRefused(f"{self.name}: table {table} lacks {', '.join(missing)}")

    def _rows(self, table: str) -> list[dict[str, Any]]:
        names = [name for name, _, _ in TABLES[table]]
        return [dict(zip(names, row)) for row in self._query(f"SELECT {', '.join(names)} FROM {table}")]

    def _query(self, sql: str, values: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
        return list(self._query_lazily(sql, values))

    def _query_lazily(self, sql: str, values: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
        try:
            yield from self._connection.execute(sql, values)
        except UnicodeDecodeError as error:
            raise SourceRefused(f"{self.name}: is a broken SQLite database") from error
        except (sqlite3.Error, OverflowError) as error:
            raise SourceRefused(f"{self.name}: {_plain(error)}") from error


def _open(path: Path, timeout_s: float) -> sqlite3.Connection:
    try:
        with path.open("rb") as file:
            head = file.read(20)
    except OSError as error:
        raise SourceRefused(f"{path.name}: cannot be read ({error.strerror})") from error
    if not head.startswith(MAGIC):
        raise SourceRefused(f"{path.name}: is not an SQLite database")
    # A reader of a write-ahead database creates a -shm file beside it, unless told that nobody writes.
    log = path.with_name(path.name + "-wal")
    at_rest = WRITE_AHEAD in head[18:20] and not (log.exists() and log.stat().st_size)
    mode = "mode=ro&immutable=1" if at_rest else "mode=ro"
    try:
        connection = sqlite3.connect(f"{path.absolute().as_uri()}?{mode}", uri=True, timeout=timeout_s)
        connection.text_factory = lambda text: text.decode("utf-8", "replace")
    except sqlite3.Error as error:
        raise SourceRefused(f"{path.name}: {_plain(error)}") from error
    return connection


def _plain(error: Exception) -> str:
    text = str(error)
    if "locked" in text or "busy" in text:
        return "is locked by a program that writes to it; try again when it is done"
    if "not a database" in text or "malformed" in text:
        return "is a broken SQLite database"
    if "unable to open" in text:
        return "cannot be opened read-only (a writer may have left its log behind)"
    return f"cannot be read ({printable(text, 120)})"
