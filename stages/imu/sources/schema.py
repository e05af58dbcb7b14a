"""The one schema of raw measurements: what a source must provide, whatever it is stored in, and its SQLite file.

Three tables. `device` says what a sensor is, where it sits and what its numbers mean; `experiment` is one run;
`sample` is one reading. A sample knows its packet, its position in the packet and up to three stamps:

- device stamp: the sensor's own clock [s]; drifts, restarts with the sensor,
- phone stamp: when the packet reached the phone [s]; late by the radio, never early,
- server stamp: when the phone's upload reached the server [s]; later still.

Any of packet, position and the stamps may be missing (NULL); what cannot be known then is reported, not guessed.
"""

from __future__ import annotations

import dataclasses
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

ACCELERATION_UNITS = {"counts": None, "m/s^2": 1.0, "g": 9.80665, "mg": 9.80665e-3}
ANGULAR_RATE_UNITS = {"counts": None, "rad/s": 1.0, "deg/s": np.pi / 180.0, "mdps": np.pi / 180e3}

TABLES: dict[str, tuple[tuple[str, str, str], ...]] = {
    "device": (
        ("device_id", "INTEGER PRIMARY KEY", "identity"),
        ("name", "TEXT", "what the lab calls it"),
        ("place", "TEXT", "where it rides: hip or foot"),
        ("rate_hz", "DOUBLE PRECISION", "nominal sampling rate [Hz]"),
        ("bandwidth_hz", "DOUBLE PRECISION", "cut-off of its second-order low pass [Hz], NULL where unknown"),
        ("accelerometer_range_g", "DOUBLE PRECISION", "full scale [g]"),
        ("gyroscope_range_deg_s", "DOUBLE PRECISION", "full scale [deg/s]"),
        ("accelerometer_unit", "TEXT", "counts, g, mg or m/s^2"),
        ("gyroscope_unit", "TEXT", "counts, deg/s, mdps (thousandths of deg/s) or rad/s"),
        ("bits", "INTEGER", "resolution of counts [bit]"),
        ("batch_size", "INTEGER", "samples in a packet"),
        ("counter_modulus", "INTEGER", "packet number after which the counter starts at 0 again"),
        ("forward_axis", "TEXT", "sensor axis nearest to the body's forward axis, such as +x"),
        ("up_axis", "TEXT", "sensor axis nearest to the body's upward axis"),
    ),
    "experiment": (
        ("experiment_id", "INTEGER PRIMARY KEY", "identity"),
        ("name", "TEXT", "what the lab calls it"),
        ("origin", "TEXT", "measured or synthetic"),
        ("slope_deg", "DOUBLE PRECISION", "inclination of the ramp as read off [deg]"),
    ),
    "sample": (
        ("sample_id", "INTEGER PRIMARY KEY", "order of arrival in the database"),
        ("experiment_id", "INTEGER", "run it belongs to"),
        ("device_id", "INTEGER", "sensor it comes from"),
        ("packet", "INTEGER", "packet number"),
        ("position", "INTEGER", "position in the packet, from 0"),
        ("device_stamp", "DOUBLE PRECISION", "sensor's clock [s]"),
        ("phone_stamp", "DOUBLE PRECISION", "arrival at the phone [s]"),
        ("server_stamp", "DOUBLE PRECISION", "arrival at the server [s]"),
        ("ax", "DOUBLE PRECISION", "specific force on sensor axis x"),
        ("ay", "DOUBLE PRECISION", "specific force on sensor axis y"),
        ("az", "DOUBLE PRECISION", "specific force on sensor axis z"),
        ("gx", "DOUBLE PRECISION", "angular rate about sensor axis x"),
        ("gy", "DOUBLE PRECISION", "angular rate about sensor axis y"),
        ("gz", "DOUBLE PRECISION", "angular rate about sensor axis z"),
    ),
}
SAMPLE_VALUES = tuple(name for name, _, _ in TABLES["sample"][3:])
#: What a file's device_stamp of whole seconds has in a column beside it, as ROS writes it.
NANOSECONDS = "nanoseconds"
Row = tuple[int, tuple[float | int | None, ...]]
_COLUMNS = tuple(name for name, _, _ in TABLES["sample"][1:])
_SAMPLE = f"INSERT INTO sample ({', '.join(_COLUMNS)}) VALUES ({', '.join('?' * len(_COLUMNS))})"


@dataclass(frozen=True)
class Device:
    """What a sensor is; fields as in table `device`, None where the source does not say."""

    place: str
    rate_hz: float
    accelerometer_unit: str
    gyroscope_unit: str
    name: str = ""
    bandwidth_hz: float | None = None
    accelerometer_range_g: float | None = None
    gyroscope_range_deg_s: float | None = None
    bits: int | None = None
    batch_size: int | None = None
    counter_modulus: int | None = None
    forward_axis: str | None = None
    up_axis: str | None = None


@dataclass(frozen=True)
class Experiment:
    """One run; fields as in table `experiment`."""

    name: str
    origin: str = "measured"
    slope_deg: float | None = None


@dataclass(frozen=True)
class Rows:
    """Readings as they are stored, (n,) each, stamps in seconds; `acceleration` and `angular_rate` (n, 3)."""

    packet: np.ndarray
    position: np.ndarray
    device_stamp: np.ndarray
    phone_stamp: np.ndarray
    server_stamp: np.ndarray
    acceleration: np.ndarray
    angular_rate: np.ndarray

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.packet)

    def table(self) -> np.ndarray:
        """All of them (n, 11), in the order of `SAMPLE_VALUES`."""
        return np.column_stack([getattr(self, field.name) for field in dataclasses.fields(Rows)])


@dataclass(frozen=True)
class Recording(Rows):
    """Raw rows of one sensor in one run, in the order they were stored; NaN where the source has no number.

    Readings are in the device's declared units on the sensor's own axes.
    """

    experiment: Experiment
    device: Device

    def take(self, keep: np.ndarray | slice) -> Recording:
        """The same recording with the rows `keep` (indices, mask or slice) only."""
        return replace(self, **{field.name: getattr(self, field.name)[keep] for field in dataclasses.fields(Rows)})


def create_statements(keys: bool = True) -> tuple[str, ...]:
    """SQL that creates the tables and the index the ingest reads by; `keys`: no identity may be missing or twice."""
    without = "" if keys else " PRIMARY KEY"
    tables = [
        f"CREATE TABLE {table} ({', '.join(f'{name} {kind.removesuffix(without)}' for name, kind, _ in columns)})"
        for table, columns in TABLES.items()
    ]
    return (*tables, "CREATE INDEX sample_of_run ON sample (experiment_id, device_id)")


class DatabaseWriter(AbstractContextManager["DatabaseWriter"]):
    """A new database file; use as a context manager. The same calls give the same bytes, for one version of SQLite."""

    def __init__(self, path: Path, keys: bool = True) -> None:
        self._connection = sqlite3.connect(path)
        self._connection.execute("PRAGMA journal_mode = OFF")
        for statement in create_statements(keys):
            self._connection.execute(statement)
        self._connection.execute("BEGIN")  # Python does, if it knows INSERT, whose I is another letter in Turkish
        self._identity: dict[Device, int] = {}
        self._experiments = 0

    def __exit__(self, *error: object) -> None:
        if error[0] is None:
            self._connection.commit()
        self._connection.close()

    def copy(self, table: str, rows: Iterable[tuple[Any, ...]]) -> None:
        """Store rows of a table as they are, in their order."""
        marks = ", ".join("?" for _ in TABLES[table])
        self._connection.executemany(f"INSERT INTO {table} VALUES ({marks})", rows)

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
        for row in recording.table().tolist():
            yield device, tuple(None if value != value else value for value in row)

    def _insert(self, table: str, identity: int, value: Device | Experiment) -> None:
        fields = dataclasses.asdict(value)
        self.copy(table, [(identity, *(fields[name] for name, _, _ in TABLES[table][1:]))])
