"""The SQLite source: read-only in fact, clear when it cannot read."""

import os
import sqlite3
from pathlib import Path

import pytest

from stages.imu.sources.databases import SqliteSource
from stages.imu.sources.opening import SourceRefused
from tests.imu.damage import edited
from tests.imu.stand_in import make_database, make_run


@pytest.fixture(scope="module")
def content() -> bytes:
    return make_database([make_run(seed, steps=6, rest_s=1.0) for seed in (1, 2)])


def rows(path: Path) -> dict[str, list[int]]:
    with SqliteSource(path, timeout_s=0.1) as source:
        return {experiment.name: [one.rows for one in recordings] for experiment, recordings in source.runs()}


def test_reads_what_was_stored(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "log.sqlite"
    path.write_bytes(content)
    stored = sqlite3.connect(path).execute(
        "SELECT experiment_id, device_id, count(*) FROM sample GROUP BY experiment_id, device_id"
    )
    assert [count for _, _, count in stored.fetchall()] == [*rows(path)["run 1"], *rows(path)["run 2"]]


def test_interleaved_runs_are_told_apart(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "log.sqlite"
    path.write_bytes(content)
    expected = rows(path)
    mixed = edited(
        content,
        ("CREATE TABLE other AS SELECT * FROM sample ORDER BY server_stamp % 10", ()),
        ("UPDATE other SET sample_id = NULL", ()),
        ("DELETE FROM sample", ()),
        ("INSERT INTO sample SELECT * FROM other", ()),
    )
    path.write_bytes(mixed)
    assert rows(path) == expected


def test_a_locked_database_is_said_to_be_locked(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "log.sqlite"
    path.write_bytes(content)
    writer = sqlite3.connect(path, isolation_level=None)
    writer.execute("BEGIN EXCLUSIVE")
    with pytest.raises(SourceRefused, match="locked"):
        rows(path)
    writer.execute("ROLLBACK")
    writer.close()
    assert path.read_bytes() == content


def test_a_write_ahead_database_leaves_nothing_behind(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "log.sqlite"
    path.write_bytes(content)
    writer = sqlite3.connect(path)
    writer.execute("PRAGMA journal_mode = WAL")
    writer.close()
    before = path.read_bytes()
    assert rows(path)
    assert [child.name for child in tmp_path.iterdir()] == ["log.sqlite"]
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("content_of", "words"),
    [
        (b"", "not an SQLite database"),
        (b"\x00" * 5000, "not an SQLite"),
        (b"SQLite format 3\x00" + b"x" * 200, "broken"),
    ],
)
def test_no_database(content_of: bytes, words: str, tmp_path: Path) -> None:
    path = tmp_path / "log.sqlite"
    path.write_bytes(content_of)
    with pytest.raises(SourceRefused, match=words):
        rows(path)


def test_no_file_and_a_folder(tmp_path: Path) -> None:
    for path in (tmp_path / "none.sqlite", tmp_path):
        with pytest.raises(SourceRefused, match="cannot be read"):
            rows(path)


def test_a_path_with_uri_characters(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "a?mode=rwc&b #100%.sqlite"
    path.write_bytes(content)
    assert rows(path)
    assert [child.name for child in tmp_path.iterdir()] == [path.name]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
def test_a_pipe_a_device_and_a_sparse_file_are_refused_at_once(content: bytes, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.sqlite")
    for path in (tmp_path / "pipe.sqlite", Path("/dev/zero")):
        with pytest.raises(SourceRefused, match="a pipe, device or socket, not a file"):
            rows(path)
    with open(tmp_path / "sparse.sqlite", "wb") as file:
        file.truncate(5_000_000_000)
    with pytest.raises(SourceRefused, match="is not an SQLite database"):
        rows(tmp_path / "sparse.sqlite")
    (tmp_path / "log.sqlite").write_bytes(content)
    os.mkfifo(tmp_path / "log.sqlite-journal")
    with pytest.raises(SourceRefused, match=r"log\.sqlite-journal' cannot be read: it is a pipe"):
        rows(tmp_path / "log.sqlite")
