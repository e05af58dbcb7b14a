"""Writes measurements as an SQLite database in the schema of `schema.py`: the form a study keeps them in."""

from __future__ import annotations

import dataclasses
import sqlite3
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import TracebackType

import numpy as np

from stages.imu.sources.schema import TABLES, Device, Experiment, Recording, create_statements

Row = tuple[int, tuple[float | int | None, ...]]
_COLUMNS = tuple(name for name, _, _ in TABLES["sample"][1:])
_SAMPLE = f"INSERT INTO sample ({', '.join(_COLUMNS)}) VALUES ({', '.join('?' * len(_COLUMNS))})"


class DatabaseWriter:
    """A new database file; use as a context manager. The same calls give the same bytes, for one version of SQLite."""

    def __init__(self, path: Path) -> None:
        self._connection = sqlite3.connect(path)
        self._connection.execute("PRAGMA journal_mode = OFF")
        for statement in create_statements():
            self._connection.execute(statement)
        self._identity: dict[Device, int] = {}
        self._experiments = 0

    def __enter__(self) -> DatabaseWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self._connection.commit()
        self._connection.close()

    def device(self, device: Device) -> int:
        """The identity of a device, which is stored when it is first named."""
        if device not in self._identity:
            self._identity[device] = len(self._identity) + 1
            self._insert("device", self._identity[device], device)
        return self._identity[device]

    def experiment(self, experiment: Experiment, rows: Iterable[Row]) -> None:
        """Store a run: rows are a device's identity and its values in the order of `SAMPLE_VALUES`."""
        self._experiments += 1
        self._insert("experiment", self._experiments, experiment)
        self._connection.executemany(_SAMPLE, ((self._experiments, device, *values) for device, values in rows))

    def recordings(self, experiment: Experiment, recordings: Iterable[Recording]) -> None:
        """Store a run as any source gives it; what is no number becomes NULL."""
        self.experiment(experiment, (row for one in recordings for row in self._rows(one)))

    def _rows(self, recording: Recording) -> Iterator[Row]:
        device = self.device(recording.device)
        stamps = (recording.device_stamp, recording.phone_stamp, recording.server_stamp)
        values = np.column_stack(
            (recording.packet, recording.position, *stamps, recording.acceleration, recording.angular_rate)
        )
        for row in values.tolist():
            yield device, tuple(None if value != value else value for value in row)

    def _insert(self, table: str, identity: int, value: Device | Experiment) -> None:
        fields = dataclasses.asdict(value)
        marks = ", ".join("?" for _ in TABLES[table])
        row = (identity, *(fields[name] for name, _, _ in TABLES[table][1:]))
        self._connection.execute(f"INSERT INTO {table} VALUES ({marks})", row)
