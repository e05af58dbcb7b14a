"""Measurements from an SQLite database, opened so that nothing in it or beside it can change."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from stages.imu.errors import SourceRefused, printable
from stages.imu.sources.files import plain_file
from stages.imu.sources.schema import TABLES
from stages.imu.sources.source_tables import Extent, TableSource

MAGIC = b"SQLite format 3\x00"
WRITE_AHEAD = 2  # in byte 18 or 19 of a database in write-ahead mode


class SqliteSource(TableSource):
    """A database file; use as a context manager.

    Raises SourceRefused, in one sentence, for a file that is missing, no database, broken, locked, or of another shape.
    """

    order = "rowid"

    def __init__(self, path: Path, timeout_s: float = 2.0) -> None:
        super().__init__(path.name)
        self._connection = _open(path, timeout_s)
        self.open_tables()

    def query(self, sql: str, **values: Any) -> Iterator[tuple[Any, ...]]:
        """Rows of a SELECT."""
        try:
            yield from self._connection.execute(sql, values)
        except UnicodeDecodeError as error:
            raise SourceRefused(f"{self.name}: is a broken SQLite database") from error
        except (sqlite3.Error, OverflowError) as error:
            raise SourceRefused(f"{self.name}: {_plain(error)}") from error

    def present(self) -> dict[str, set[str]]:
        """Tables with their columns; no views, which may never end."""
        names = [name for (name,) in self.query("SELECT name FROM sqlite_master WHERE type = 'table'")]
        return {
            name: {row[1] for row in self.query(f"PRAGMA table_xinfo({name})")} if name in TABLES else set()
            for name in names
        }

    def extents(self) -> list[Extent]:
        """Where each run lies, found in one walk through the table: an index of a damaged file may lie."""
        extent: dict[Any, list[int]] = {}
        for row, experiment_id in self.query("SELECT rowid, experiment_id FROM sample ORDER BY rowid"):
            extent.setdefault(experiment_id, [row, row])[1] = row
        return [(experiment_id, first, last) for experiment_id, (first, last) in extent.items()]

    def close(self) -> None:
        """Close the file."""
        self._connection.close()


def _open(path: Path, timeout_s: float) -> sqlite3.Connection:
    beside = [path.with_name(path.name + ending) for ending in ("-journal", "-wal", "-shm")]
    for each in (path, *(other for other in beside if other.exists())):
        plain_file.check(each)
    try:
        with path.open("rb") as file:
            head = file.read(20)
    except OSError as error:
        raise SourceRefused(f"{path.name}: cannot be read ({error.strerror})") from error
    if not head.startswith(MAGIC):
        raise SourceRefused(f"{path.name}: is not an SQLite database")
    # A reader of a write-ahead database creates a -shm file beside it, unless told that nobody writes.
    log = path.with_name(path.name + "-wal")
    at_rest = WRITE_AHEAD in head[18:20] and not (log.exists() and log.stat().st_size)
    mode = "mode=ro&immutable=1" if at_rest else "mode=ro"
    try:
        connection = sqlite3.connect(f"{path.absolute().as_uri()}?{mode}", uri=True, timeout=timeout_s)
        connection.text_factory = lambda text: text.decode("utf-8", "replace")
    except sqlite3.Error as error:
        raise SourceRefused(f"{path.name}: {_plain(error)}") from error
    return connection


def _plain(error: Exception) -> str:
    text = str(error)
    if "locked" in text or "busy" in text:
        return "is locked by a program that writes to it; try again when it is done"
    if "not a database" in text or "malformed" in text:
        return "is a broken SQLite database"
    if "unable to open" in text:
        return "cannot be opened read-only (a writer may have left its log behind)"
    return f"cannot be read ({printable(text, 120)})"
