"""CSV and SQLite sources: what the column map may say, read-only in fact, clear when they cannot read."""

import contextlib
import operator
import os
import re
import sqlite3
from copy import deepcopy
from functools import partial, reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stages.imu.sources.column_map import CsvSource
from stages.imu.sources.databases import SqliteSource
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.schema import TABLES, DatabaseWriter
from tests.imu.damage import MIXED, edited
from tests.imu.stand_in import make_database, make_run

TEXT = "made by a device\nN;X;Y;Z;P;Q;R\n1;0;0;9.81;0.1;0;0\n2;0;;9.8;0;0;0\n\n4;0;0;abc;0;0\n"
DESCRIPTION: dict[str, Any] = {
    "experiment": {"name": "one", "slope_deg": 2},
    "files": [
        {
            "file": "one.csv",
            "delimiter": "semicolon",
            "header_rows": 1,
            "device": {"place": "hip", "rate_hz": 100, "accelerometer_unit": "m/s2", "gyroscope_unit": "rad/s"},
            "columns": {"packet": "N", "ax": "X", "ay": "Y", "az": "Z", "gx": "P", "gy": "Q", "gz": "R"},
        }
    ],
}


def test_cells_become_numbers_or_nothing(tmp_path: Path) -> None:
    (tmp_path / "one.csv").write_text(TEXT)
    ((experiment, (recording,)),) = CsvSource(DESCRIPTION, tmp_path).runs()
    assert experiment.slope_deg == 2
    assert recording.packet.tolist() == [1, 2, 4]
    np.testing.assert_array_equal(recording.acceleration[:, 1:], [[0, 9.81], [np.nan, 9.8], [0, np.nan]])
    assert np.isnan(recording.angular_rate[2, 2]) and np.isnan(recording.phone_stamp).all()


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("files",), [], "list of files"),
        (("files",), "one.csv", "list of files"),
        (("files", 0, "file"), "two.csv", "cannot be read"),
        (("files", 0, "file"), 7, "name of a file"),
        (("files", 0, "file"), "", "name of a file"),
        (("files", 0, "delimiter"), "pipe", "delimiter"),
        (("files", 0, "header_rows"), -1, "header_rows"),
        (("experiment", "slope"), 1, "unknown key 'slope'"),
        (("experiment", "slope_deg"), "two", "slope_deg is 'two', must be a number between -90 and 90"),
        (("files", 0, "surprise"), 1, "unknown key 'surprise'"),
        (("files", 0, "device"), None, "mapping"),
        (("files", 0, "device", "rate_hz"), "fast", "rate_hz"),
        (("files", 0, "device", "accelerometer_unit"), "furlong", "accelerometer_unit"),
        (("files", 0, "columns"), {"ax": "X"}, "columns lack ay"),
        (("files", 0, "columns"), dict.fromkeys(("ax", "ay", "az", "gx", "gy", "gz", "nanoseconds"), "X"),
         "columns lack device_stamp"),
        (("files", 0, "columns", "az"), "W", "no column 'W'"),
        (("files", 0, "columns", "blood"), "W", "unknown key 'blood'"),
    ],
)
def test_what_is_wrong_is_named(path: tuple, value: object, words: str, tmp_path: Path) -> None:
    (tmp_path / "one.csv").write_text(TEXT)
    description = deepcopy(DESCRIPTION)
    reduce(operator.getitem, path[:-1], description)[path[-1]] = value
    with pytest.raises(SourceRefused, match=words):
        list(CsvSource(description, tmp_path).runs())


@pytest.mark.parametrize("content", [b"", b"\x00" * 100, b"\xff\xfe\x00N;X", b'"' * 200_000, b"N;N;X;Y;Z;P;Q;R\n"])
def test_no_table(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "one.csv").write_bytes(content)
    with pytest.raises(SourceRefused):
        list(CsvSource(DESCRIPTION, tmp_path).runs())


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
@pytest.mark.parametrize(("kind", "words"), [
    ("pipe", "a pipe, device or socket, not a file"), ("device", "a pipe, device or socket, not a file"),
    ("sparse", "a line of more than 1,000,000 characters"),
])  # fmt: skip
def test_a_pipe_a_device_and_a_sparse_file_are_refused_at_once(kind: str, words: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "device").symlink_to("/dev/zero")
    with open(tmp_path / "sparse", "wb") as file:
        file.truncate(50_000_000_000)
    (tmp_path / kind).rename(tmp_path / "one.csv")
    with pytest.raises(SourceRefused, match=words):
        list(CsvSource(DESCRIPTION, tmp_path).runs())


def test_several_experiments_in_one_description(tmp_path: Path) -> None:
    (tmp_path / "one.csv").write_text(TEXT)
    second = deepcopy(DESCRIPTION) | {"experiment": {"name": "two"}}
    source = CsvSource({"runs": [DESCRIPTION, second]}, tmp_path)
    assert [(experiment.name, len(recordings)) for experiment, recordings in source.runs()] == [("one", 1), ("two", 1)]
    for wrong in ([], "one", [3], [DESCRIPTION | {"blood": 1}]):
        with pytest.raises(SourceRefused):
            CsvSource({"runs": wrong}, tmp_path)


@pytest.mark.parametrize("name", ["x' OR 1 -- DROP TABLE sample", "\x1b[31m", "💥", "%s{0}", "a\tb"])
def test_hostile_column_names_are_names(name: str, tmp_path: Path) -> None:
    """They are found where they are, shown harmlessly where they are not, and the files stay as they were."""
    content = TEXT.replace("Z;P", f"{name};P").encode()
    (tmp_path / "one.csv").write_bytes(content)
    description = deepcopy(DESCRIPTION)
    description["files"][0]["columns"]["az"] = name
    ((_, (recording,)),) = CsvSource(description, tmp_path).runs()
    assert recording.acceleration[0, 2] == 9.81
    (tmp_path / "one.csv").write_text(TEXT)
    with pytest.raises(SourceRefused) as refused:
        list(CsvSource(description, tmp_path).runs())
    assert str(refused.value).isprintable() and ("💥" in name) == ("💥" in str(refused.value))
    assert (tmp_path / "one.csv").read_text() == TEXT
    assert [child.name for child in tmp_path.iterdir()] == ["one.csv"]


# --- The SQLite source: read-only in fact, clear when it cannot read.


@pytest.fixture(scope="module")
def content() -> bytes:
    return make_database([make_run(seed, steps=6, rest_s=1.0) for seed in (1, 2)])


@pytest.fixture
def path(content: bytes, tmp_path: Path) -> Path:
    """A database of two runs."""
    (tmp_path / "log.sqlite").write_bytes(content)
    return tmp_path / "log.sqlite"


def rows(path: Path) -> dict[str, list[int]]:
    with SqliteSource(path, timeout_s=0.1) as source:
        return {experiment.name: [one.rows for one in recordings] for experiment, recordings in source.runs()}


def test_runs_are_read_as_they_were_stored_and_told_apart_where_they_are_mixed(path: Path, content: bytes) -> None:
    stored = sqlite3.connect(path).execute(
        "SELECT experiment_id, device_id, count(*) FROM sample GROUP BY experiment_id, device_id"
    )
    expected = rows(path)
    assert [count for _, _, count in stored.fetchall()] == [count for run in expected.values() for count in run]
    path.write_bytes(edited(content, *(sql.format(order="server_stamp % 10") for sql in MIXED)))
    assert rows(path) == expected


def test_a_locked_database_is_said_to_be_locked(path: Path, content: bytes) -> None:
    writer = sqlite3.connect(path, isolation_level=None)
    writer.execute("BEGIN EXCLUSIVE")
    with pytest.raises(SourceRefused, match="locked"):
        rows(path)
    writer.execute("ROLLBACK")
    writer.close()
    assert path.read_bytes() == content


@pytest.mark.parametrize("name", ["log.sqlite", "a?mode=rwc&b #100%.sqlite"])
def test_a_write_ahead_database_leaves_nothing_behind_whatever_its_name(name: str, path: Path) -> None:
    path = path.rename(path.with_name(name))
    writer = sqlite3.connect(path)
    writer.execute("PRAGMA journal_mode = WAL")
    writer.close()
    before = path.read_bytes()
    assert rows(path)
    assert [child.name for child in path.parent.iterdir()] == [name]
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("content_of", "words"),
    [
        (b"", "not an SQLite database"),
        (b"\x00" * 5000, "not an SQLite"),
        (b"SQLite format 3\x00" + b"x" * 200, "broken"),
        (None, "cannot be read"),
    ],
)
def test_what_is_no_database_or_no_file_is_refused(content_of: bytes | None, words: str, tmp_path: Path) -> None:
    if content_of is not None:
        (tmp_path / "log.sqlite").write_bytes(content_of)
    with pytest.raises(SourceRefused, match=words):
        rows(tmp_path / "log.sqlite")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
@pytest.mark.parametrize(("name", "words"), [
    ("pipe.sqlite", "a pipe, device or socket, not a file"), ("/dev/zero", "a pipe, device or socket, not a file"),
    ("sparse.sqlite", "is not an SQLite database"),
    ("", "is a folder, not an SQLite database: ingest .* --map MAP --store FILE makes one of the files in it"),
    ("log.sqlite", r"log\.sqlite-journal' cannot be read: it is a pipe"),
])  # fmt: skip
def test_no_pipe_no_sparse_file_and_no_folder_is_taken_for_a_database(name: str, words: str, path: Path) -> None:
    for pipe in ("pipe.sqlite", "log.sqlite-journal"):
        os.mkfifo(path.with_name(pipe))
    with open(path.with_name("sparse.sqlite"), "wb") as file:
        file.truncate(5_000_000_000)
    with pytest.raises(SourceRefused, match=words):
        rows(path.parent / name)


def test_a_log_is_read_with_its_database_or_alone(tmp_path: Path) -> None:
    """Copied with the database but without its index, and by a link: what was committed is seen, nothing is written."""
    path, copy = tmp_path / "log.sqlite", tmp_path / "copy"
    path.write_bytes(make_database([make_run(1, steps=2, rest_s=0.5)]))
    copy.mkdir()
    with contextlib.closing(sqlite3.connect(path)) as writer:
        writer.execute("PRAGMA journal_mode = WAL")
        writer.execute("UPDATE experiment SET name = 'as the log has it'")
        writer.commit()
        for name in (path.name, f"{path.name}-wal"):
            (copy / name).write_bytes((tmp_path / name).read_bytes())
    (tmp_path / "link").symlink_to(copy / path.name)
    before = {each.name: each.read_bytes() for each in copy.iterdir()}
    for place in (copy / path.name, tmp_path / "link"):
        with SqliteSource(place) as source:
            assert [experiment.name for experiment, _ in source.runs()] == ["as the log has it"]
        assert {each.name: each.read_bytes() for each in copy.iterdir()} == before


# --- The documented schema is the one in the code.


@pytest.mark.parametrize("table", TABLES)
def test_the_documented_schema_is_the_one_in_the_code(table: str, repository: Path) -> None:
    text = (repository / "docs/measurements.md").read_text()
    between = text.split(f"<!-- {table} -->")[1].split(f"<!-- /{table} -->")[0]
    rows = re.findall(r"^\| `(\w+)` \| (.+) \|$", between, re.M)
    assert rows == [(name, meaning) for name, _, meaning in TABLES[table]]


def test_a_database_has_the_same_bytes_where_python_begins_no_transaction(tmp_path: Path, monkeypatch) -> None:
    """In a Turkish locale it does not know INSERT, and would store each row by itself."""
    rows = [(number, *[None] * (len(TABLES["experiment"]) - 1)) for number in range(9)]
    for name in ("usual", "turkish"):
        with DatabaseWriter(tmp_path / name, keys=False) as writer:
            writer.copy("experiment", rows)
        monkeypatch.setattr(sqlite3, "connect", partial(sqlite3.connect, isolation_level=None))
    assert (tmp_path / "usual").read_bytes() == (tmp_path / "turkish").read_bytes()
