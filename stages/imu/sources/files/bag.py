"""Messages of a robot's recording: bags of ROS 1 and ROS 2, and MCAP, with `sensor_msgs/Imu`.

A column is named by topic and field, such as "/imu/hip:linear_acceleration.x". Besides the message's own fields there
are `stamp`, its header's, by the sensor's clock, and `received`, when it was recorded.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from stages.imu.errors import SourceRefused, printable
from stages.imu.sources.files import plain_file
from stages.imu.sources.files.optional import library, no_columns

ENDINGS = (".bag", ".mcap", ".db3")
IMU = "sensor_msgs/msg/Imu"
FIELDS = {
    "stamp": "", "received": "",
    **{f"{kind}.{axis}": f"{kind}.{axis}" for kind in ("linear_acceleration", "angular_velocity") for axis in "xyz"},
}  # fmt: skip
#: What a map calls each value.
COLUMNS = {
    "device_stamp": "stamp", "phone_stamp": "received",
    **{f"a{axis}": f"linear_acceleration.{axis}" for axis in "xyz"},
    **{f"g{axis}": f"angular_velocity.{axis}" for axis in "xyz"},
}  # fmt: skip


def is_bag(path: Path) -> bool:
    """Whether the path is one by its ending, or a folder that a ROS 2 recorder has left."""
    return path.suffix.lower() in ENDINGS or (path / "metadata.yaml").is_file()


def topics(path: Path) -> list[tuple[str, int]]:
    """Topics of inertial sensors with the number of their messages. Raises SourceRefused."""
    with _opened(path) as reader:
        return [(one.topic, one.msgcount) for one in reader.connections if one.msgtype == IMU]


def read(path: Path, wanted: Sequence[str]) -> Mapping[str, np.ndarray]:
    """The columns `wanted` (n,) each, all of one topic; stamps in seconds. Raises SourceRefused."""
    parted = [one.rpartition(":") for one in wanted]
    topic = parted[0][0]
    for name, (of, _, field) in zip(wanted, parted):
        if of != topic or field not in FIELDS:
            raise no_columns(path, name, [f"{topic or '/TOPIC'}:{one}" for one in FIELDS])
    fields = [field for _, _, field in parted]
    getters = [attrgetter(FIELDS[field]) if FIELDS[field] else None for field in fields]
    rows: list[list[float]] = []
    with _opened(path) as reader:
        used = [one for one in reader.connections if one.topic == topic and one.msgtype == IMU]
        if not used:
            raise no_columns(path, topic, [one.topic for one in reader.connections if one.msgtype == IMU])
        for connection, received, raw in reader.messages(connections=used):
            message = reader.deserialize(raw, connection.msgtype)
            stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
            rows.append([getter(message) if getter else (stamp if field == "stamp" else 1e-9 * received)
                         for getter, field in zip(getters, fields)])  # fmt: skip
    table = np.array(rows, dtype=float).reshape(-1, len(wanted))
    return dict(zip(wanted, table.T))


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """The recording, read only. Raises SourceRefused, also for what its reader stumbles over."""
    if not path.is_dir():
        plain_file.check(path)
    reader = library("rosbags.highlevel", "files", path)
    types = library("rosbags.typesys", "files", path)
    try:
        # The types of one release, for recordings that bring no definitions; Imu is the same in all.
        with reader.AnyReader([path], default_typestore=types.get_typestore(types.Stores.ROS2_HUMBLE)) as opened:
            yield opened
    except SourceRefused:
        raise
    except Exception as error:  # readers of a format raise whatever a broken file makes them raise
        raise SourceRefused(f"{printable(path.name)} is no recording of ROS or MCAP that can be read") from error
