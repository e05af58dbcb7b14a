"""The synthetic measurements as an SQLite database in the schema of `stages.imu.sources.schema`."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from stages.campaign.radio import Transmitted
from stages.imu.sources.database import DatabaseWriter, Row
from stages.imu.sources.schema import Device, Experiment


def database_bytes(devices: Sequence[Device], runs: Iterable[tuple[Experiment, Sequence[Transmitted]]]) -> bytes:
    """The content of the database file: same rows, same bytes (for one version of SQLite).

    `runs` gives each experiment with what its devices sent, in the order of `devices`.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "measurements.sqlite"
        with DatabaseWriter(path) as writer:
            identities = [writer.device(device) for device in devices]
            for experiment, sent in runs:
                writer.experiment(experiment, _interleaved(identities, sent))
        return path.read_bytes()


def _interleaved(identities: Sequence[int], sent: Sequence[Transmitted]) -> list[Row]:
    """Rows of all devices as they reach the server: by server stamp, within a device in order."""
    arrived: list[tuple[float, Row]] = []
    for identity, of_device in zip(identities, sent, strict=True):
        for i in range(len(of_device.packet)):
            stamps = (of_device.device_stamp[i], of_device.phone_stamp[i], of_device.server_stamp[i])
            counts = (*of_device.acceleration[i].tolist(), *of_device.angular_rate[i].tolist())
            values = (int(of_device.packet[i]), int(of_device.position[i]), *map(float, stamps), *counts)
            arrived.append((stamps[-1], (identity, values)))
    arrived.sort(key=lambda row: row[0])  # stable: keeps the order of a device
    return [row for _, row in arrived]
