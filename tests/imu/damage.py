"""Ways in which a log goes wrong, each a function of a random generator and of the database's content."""

from __future__ import annotations

import sqlite3
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

Damage = Callable[[bytes, np.random.Generator], bytes]
VALUES = ("packet", "position", "device_stamp", "phone_stamp", "server_stamp", "ax", "ay", "az", "gx", "gy", "gz")
HOSTILE = ("x'; DROP TABLE sample; --", 'a"b', "\x1b[31m", "💥", "select", "a\nb", "%s{0}" * 50)


def truncated(content: bytes, rng: np.random.Generator) -> bytes:
    return content[: int(rng.integers(0, len(content)))]


def flipped(content: bytes, rng: np.random.Generator) -> bytes:
    raw = bytearray(content)
    for at in rng.integers(0, len(raw), int(rng.integers(1, 200))):
        raw[at] = int(rng.integers(0, 256))
    return bytes(raw)


def overwritten_head(content: bytes, rng: np.random.Generator) -> bytes:
    return content[:16] + rng.bytes(int(rng.integers(1, 4000))) + content[4016:]


def binary(content: bytes, rng: np.random.Generator) -> bytes:
    return rng.bytes(int(rng.integers(0, 5000)))


def edited(
    content: bytes, *statements: tuple[str, tuple[object, ...]], rng: np.random.Generator | None = None
) -> bytes:
    """The database after SQL statements, in which random() draws from `rng`."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "edited.sqlite"
        path.write_bytes(content)
        connection = sqlite3.connect(path)
        if rng is not None:
            connection.create_function("random", 0, lambda: int(rng.integers(2**32)))
        for sql, values in statements:
            connection.execute(sql, values)
        connection.commit()
        connection.close()
        return path.read_bytes()


def strange_cells(content: bytes, rng: np.random.Generator) -> bytes:
    strange = (None, "NaN", "abc", b"\x00\xff", 1e308, -1e308, 9e999, 2**62, -(2**62), "", 0)
    column = VALUES[rng.integers(len(VALUES))]
    share = int(rng.choice([1, 10, 100, 1000]))
    value = strange[rng.integers(len(strange))]
    return edited(content, (f"UPDATE sample SET {column} = ? WHERE random() % 1000 < ?", (value, share)), rng=rng)


def strange_device(content: bytes, rng: np.random.Generator) -> bytes:
    column = ("rate_hz", "bandwidth_hz", "bits", "batch_size", "counter_modulus", "accelerometer_range_g", "up_axis")[
        rng.integers(7)
    ]
    value = (None, -1, 0, "abc", 1e-9, 1e300, 9e999, b"\x00", 7, "+q")[rng.integers(10)]
    return edited(content, (f"UPDATE device SET {column} = ?", (value,)))


def shuffled(content: bytes, rng: np.random.Generator) -> bytes:
    return edited(
        content,
        ("CREATE TABLE other AS SELECT * FROM sample ORDER BY random()", ()),
        ("UPDATE other SET sample_id = NULL", ()),
        ("DELETE FROM sample", ()),
        ("INSERT INTO sample SELECT * FROM other", ()),
        rng=rng,
    )


def thinned(content: bytes, rng: np.random.Generator) -> bytes:
    return edited(content, ("DELETE FROM sample WHERE random() % 100 < ?", (int(rng.integers(1, 101)),)), rng=rng)


def repeated(content: bytes, rng: np.random.Generator) -> bytes:
    columns = ", ".join(("experiment_id", "device_id", *VALUES))
    return edited(
        content,
        (f"INSERT INTO sample ({columns}) SELECT {columns} FROM sample WHERE random() % 100 < ?", (10,)),
        rng=rng,
    )


def swapped_sensors(content: bytes, rng: np.random.Generator) -> bytes:
    return edited(content, ("UPDATE sample SET device_id = 3 - device_id", ()))


def restarted(content: bytes, rng: np.random.Generator) -> bytes:
    after = int(rng.integers(1, 1700))
    return edited(content, ("UPDATE sample SET packet = packet % 97 WHERE sample_id > ?", (after,)))


def one_stamp(content: bytes, rng: np.random.Generator) -> bytes:
    return edited(content, ("UPDATE sample SET phone_stamp = 5, server_stamp = 5, device_stamp = 5", ()))


def no_stamps(content: bytes, rng: np.random.Generator) -> bytes:
    return edited(content, ("UPDATE sample SET phone_stamp = NULL, server_stamp = NULL, device_stamp = NULL", ()))


def no_counter(content: bytes, rng: np.random.Generator) -> bytes:
    return edited(content, ("UPDATE sample SET packet = NULL, position = NULL", ()))


def emptied(content: bytes, rng: np.random.Generator) -> bytes:
    return edited(content, (f"DELETE FROM {('device', 'experiment', 'sample')[rng.integers(3)]}", ()))


def missing_table(content: bytes, rng: np.random.Generator) -> bytes:
    return edited(content, (f"DROP TABLE {('device', 'experiment', 'sample')[rng.integers(3)]}", ()))


def hostile_names(content: bytes, rng: np.random.Generator) -> bytes:
    name = HOSTILE[rng.integers(len(HOSTILE))].replace('"', '""')
    place = HOSTILE[rng.integers(len(HOSTILE))]
    old = ("device", "sample", "experiment")[rng.integers(3)]
    change = [
        (f'CREATE TABLE "{name}" ("{name}" INTEGER)', ()),
        (f'ALTER TABLE {old} RENAME TO "{name}"', ()),
        (f'ALTER TABLE sample RENAME COLUMN ax TO "{name}"', ()),
    ][rng.integers(3)]
    return edited(
        content, change, *([("UPDATE device SET name = ?, place = ?", (place, place))] if old != "device" else [])
    )


def endless_view(content: bytes, rng: np.random.Generator) -> bytes:
    endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i AS sample_id FROM n"
    return edited(content, ("DROP TABLE sample", ()), (f"CREATE VIEW sample AS {endless}", ()))


def wrong_acceleration_unit(content: bytes, rng: np.random.Generator) -> bytes:
    unit = ("g", "mg", "m/s^2")[rng.integers(3)]
    return edited(content, ("UPDATE device SET accelerometer_unit = ?", (unit,)))


def wrong_range(content: bytes, rng: np.random.Generator) -> bytes:
    return edited(content, ("UPDATE device SET accelerometer_range_g = ?", (float(rng.choice([2, 8, 16])),)))


def wrong_angular_rate_unit(content: bytes, rng: np.random.Generator) -> bytes:
    """Counts turned into one unit and declared as the other."""
    count = 2000.0 / 2**15  # deg/s
    size, declared = ((count, "rad/s"), (count * np.pi / 180, "deg/s"))[rng.integers(2)]
    return edited(
        content,
        ("UPDATE sample SET gx = gx * ?, gy = gy * ?, gz = gz * ?", (size, size, size)),
        ("UPDATE device SET gyroscope_unit = ?", (declared,)),
    )


HARMFUL: tuple[Damage, ...] = (
    truncated,
    flipped,
    overwritten_head,
    binary,
    strange_cells,
    strange_cells,
    strange_device,
    shuffled,
    thinned,
    repeated,
    restarted,
    one_stamp,
    no_stamps,
    no_counter,
    emptied,
    missing_table,
    hostile_names,
    endless_view,
)
NEVER_ACCEPTED: tuple[Damage, ...] = (
    wrong_acceleration_unit,
    wrong_range,
    wrong_angular_rate_unit,
    swapped_sensors,
)
