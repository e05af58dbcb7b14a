"""The SQLite source: read-only in fact, clear when it cannot read."""

import contextlib
import os
import sqlite3
from pathlib import Path

import pytest

from stages.imu.sources.databases import SqliteSource
from stages.imu.sources.opening import SourceRefused
from tests.imu.damage import MIXED, edited
from tests.imu.stand_in import make_database, make_run


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
    assert [count for _, _, count in stored.fetchall()] == [*expected["run 1"], *expected["run 2"]]
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
    for path in (tmp_path / "log.sqlite", *([tmp_path] if content_of is None else [])):
        with pytest.raises(SourceRefused, match=words):
            rows(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
@pytest.mark.parametrize(("name", "words"), [
    ("pipe.sqlite", "a pipe, device or socket, not a file"), ("/dev/zero", "a pipe, device or socket, not a file"),
    ("sparse.sqlite", "is not an SQLite database"),
    ("log.sqlite", r"log\.sqlite-journal' cannot be read: it is a pipe"),
])  # fmt: skip
def test_a_pipe_a_device_and_a_sparse_file_are_refused_at_once(name: str, words: str, path: Path) -> None:
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
