"""The synthetic measurements as an SQLite database in the schema of `stages.imu.schema`."""

from __future__ import annotations

import dataclasses
import sqlite3
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from stages.campaign.radio import Transmitted
from stages.imu.schema import TABLES, Device, Experiment, create_statements


def database_bytes(devices: Sequence[Device], runs: Iterable[tuple[Experiment, Sequence[Transmitted]]]) -> bytes:
    """The content of the database file: same rows, same bytes (for one version of SQLite).

    `runs` gives each experiment with what its devices sent, in the order of `devices`.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "measurements.sqlite"
        connection = sqlite3.connect(path)
        try:
            connection.execute("PRAGMA journal_mode = OFF")
            for statement in create_statements():
                connection.execute(statement)
            for device_id, device in enumerate(devices, start=1):
                _insert(connection, "device", [_row("device", device_id, device)])
            for experiment_id, (experiment, sent) in enumerate(runs, start=1):
                _insert(connection, "experiment", [_row("experiment", experiment_id, experiment)])
                for row in _interleaved(experiment_id, sent):
                    connection.execute(_SAMPLE, row)
            connection.commit()
        finally:
            connection.close()
        return path.read_bytes()


def _row(table: str, identity: int, value: object) -> tuple[object, ...]:
    fields = dataclasses.asdict(value)  # type: ignore[call-overload]
    return (identity, *(fields[name] for name, _, _ in TABLES[table][1:]))


def _insert(connection: sqlite3.Connection, table: str, rows: list[tuple[object, ...]]) -> None:
    marks = ", ".join("?" for _ in TABLES[table])
    connection.executemany(f"INSERT INTO {table} VALUES ({marks})", rows)


_COLUMNS = tuple(name for name, _, _ in TABLES["sample"][1:])
_SAMPLE = f"INSERT INTO sample ({', '.join(_COLUMNS)}) VALUES ({', '.join('?' * len(_COLUMNS))})"


def _interleaved(experiment_id: int, sent: Sequence[Transmitted]) -> list[tuple[object, ...]]:
    """Rows of all devices as they reach the server: by server stamp, within a device in order."""
    rows = []
    for device_id, of_device in enumerate(sent, start=1):
        for i in range(len(of_device.packet)):
            stamps = (of_device.device_stamp[i], of_device.phone_stamp[i], of_device.server_stamp[i])
            counts = (*of_device.acceleration[i].tolist(), *of_device.angular_rate[i].tolist())
            key = (experiment_id, device_id, int(of_device.packet[i]), int(of_device.position[i]))
            rows.append((*key, *map(float, stamps), *counts))
    rows.sort(key=lambda row: row[6])  # stable: keeps the order of a device
    return rows
