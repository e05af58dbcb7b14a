"""Ways in which a log goes wrong, each a function of a random generator and of the database's content."""

import sqlite3
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

Damage = Callable[[bytes, np.random.Generator], bytes]
VALUES = ("packet", "position", "device_stamp", "phone_stamp", "server_stamp", "ax", "ay", "az", "gx", "gy", "gz")
COLUMNS = ", ".join(("experiment_id", "device_id", *VALUES))
TABLES = ("device", "experiment", "sample")
HOSTILE = ("x'; DROP TABLE sample; --", 'a"b', "\x1b[31m", "💥", "select", "a\nb", "%s{0}" * 50)
#: Hostile words as SQL quotes them, where a name of a table or column stands and where a value does.
NAMES, WORDS = [one.replace('"', '""') for one in HOSTILE], [one.replace("'", "''") for one in HOSTILE]


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
    content: bytes, *statements: str, values: Sequence[object] = (), rng: np.random.Generator | None = None
) -> bytes:
    """The database after SQL statements, the first with these values; random() draws from `rng`."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "edited.sqlite"
        path.write_bytes(content)
        connection = sqlite3.connect(path)
        if rng is not None:
            connection.create_function("random", 0, lambda: int(rng.integers(2**32)))
        for number, sql in enumerate(statements):
            connection.execute(sql, values if number == 0 else ())
        connection.commit()
        connection.close()
        return path.read_bytes()


def by(*statements: str, **drawn: Sequence[object]) -> Damage:
    """SQL in which `{name}` stands for one of some words, and a `?` in the first statement for one of `value`."""

    def damage(content: bytes, rng: np.random.Generator) -> bytes:
        chosen = {name: every[rng.integers(len(every))] for name, every in drawn.items()}
        values = [chosen["value"]] if "value" in chosen else []
        return edited(content, *(sql.format(**chosen) for sql in statements), values=values, rng=rng)

    return damage


CALLED = "UPDATE device SET name = '{word}', place = '{word}'"
ENDLESS = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i AS sample_id FROM n"
MIXED = ("CREATE TABLE other AS SELECT * FROM sample ORDER BY {order}", "UPDATE other SET sample_id = NULL",
         "DELETE FROM sample", "INSERT INTO sample SELECT * FROM other")  # fmt: skip
HARMFUL: Mapping[str, Damage] = {
    "truncated": truncated,
    "flipped": flipped,
    "overwritten head": overwritten_head,
    "binary": binary,
    "strange cells": by(
        "UPDATE sample SET {column} = ? WHERE random() % 1000 < {share}", column=VALUES, share=(1, 10, 100, 1000),
        value=(None, "NaN", "abc", b"\x00\xff", 1e308, -1e308, 9e999, 2**62, -(2**62), "", 0)),
    "strange device": by(
        "UPDATE device SET {column} = ?", value=(None, -1, 0, "abc", 1e-9, 1e300, 9e999, b"\x00", 7, "+q"),
        column=("rate_hz", "bandwidth_hz", "bits", "batch_size", "counter_modulus", "accelerometer_range_g",
                "up_axis")),
    "shuffled": by(*MIXED, order=["random()"]),
    "thinned": by("DELETE FROM sample WHERE random() % 100 < {share}", share=range(1, 101)),
    "repeated": by(f"INSERT INTO sample ({COLUMNS}) SELECT {COLUMNS} FROM sample WHERE random() % 100 < 10"),
    "restarted": by("UPDATE sample SET packet = packet % 97 WHERE sample_id > {after}", after=range(1, 1700)),
    "one stamp": by("UPDATE sample SET phone_stamp = 5, server_stamp = 5, device_stamp = 5"),
    "no stamps": by("UPDATE sample SET phone_stamp = NULL, server_stamp = NULL, device_stamp = NULL"),
    "no counter": by("UPDATE sample SET packet = NULL, position = NULL"),
    "emptied": by("DELETE FROM {table}", table=TABLES),
    "missing table": by("DROP TABLE {table}", table=TABLES),
    "hostile table": by('CREATE TABLE "{name}" ("{name}" INTEGER)', CALLED, name=NAMES, word=WORDS),
    "hostile name of a table": by('ALTER TABLE {table} RENAME TO "{name}"', table=TABLES, name=NAMES),
    "hostile name of a column": by('ALTER TABLE sample RENAME COLUMN ax TO "{name}"', CALLED, name=NAMES, word=WORDS),
    "endless view": by("DROP TABLE sample", f"CREATE VIEW sample AS {ENDLESS}"),
}  # fmt: skip
COUNT_DEG_S = 2000.0 / 2**15
#: Counts turned into one unit and declared as the other.
TURNED = "UPDATE sample SET gx = gx * {size}, gy = gy * {size}, gz = gz * {size}"
NEVER_ACCEPTED: Mapping[str, Damage] = {
    **{f"acceleration in {unit}": by(f"UPDATE device SET accelerometer_unit = '{unit}'")
       for unit in ("g", "mg", "m/s^2")},
    **{f"range of {full} g": by(f"UPDATE device SET accelerometer_range_g = {full}.0") for full in (2, 8, 16)},
    "deg/s as rad/s": by(TURNED, "UPDATE device SET gyroscope_unit = 'rad/s'", size=[COUNT_DEG_S]),
    "rad/s as deg/s": by(TURNED, "UPDATE device SET gyroscope_unit = 'deg/s'", size=[COUNT_DEG_S * np.pi / 180]),
    "sensors swapped": by("UPDATE sample SET device_id = 3 - device_id"),
}  # fmt: skip
