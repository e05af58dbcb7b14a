"""The SQL source against a real PostgreSQL server: same rows as from SQLite, read-only, silent about the connection."""

from __future__ import annotations

import contextlib
import sqlite3
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stages.imu.sources.databases import SqliteSource, SqlSource, TableSource
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.schema import TABLES, create_statements
from tests.imu import postgres
from tests.imu.stand_in import make_database, make_run

pytestmark = [
    pytest.mark.skipif(find_spec(name) is None, reason=f"{name} is not installed (extra [sql])")
    for name in ("sqlalchemy", "psycopg")
] + [pytest.mark.skipif(bool(postgres.missing()), reason=postgres.missing() or "none")]


@pytest.fixture(scope="module")
def server() -> Iterator[postgres.Server]:
    with postgres.running() as server:
        yield server


@contextlib.contextmanager
def writer(server: postgres.Server, *statements: str) -> Iterator[Any]:
    """A connection that may write, as the lab's own programs have; first it executes and keeps these."""
    import sqlalchemy  # here: every process that collects tests would load it

    url = sqlalchemy.make_url(server.url()).set(drivername="postgresql+psycopg")
    with sqlalchemy.create_engine(url, poolclass=sqlalchemy.NullPool).connect() as connection:
        for statement in statements:
            connection.exec_driver_sql(statement)
        connection.commit()
        yield connection


def contents(server: postgres.Server) -> dict[str, list[str]]:
    """Every row of every table as the server prints it, with its place on the disk, which any change moves."""
    with writer(server) as connection:
        return {
            table: [row[0] for row in connection.exec_driver_sql(f"SELECT ctid::text || t::text FROM {table} t")]
            for table in TABLES
        }


@pytest.fixture(scope="module")
def filled(server: postgres.Server, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two runs on the server; the SQLite file they come from."""
    path = tmp_path_factory.mktemp("same") / "log.sqlite"
    path.write_bytes(make_database([make_run(seed, steps=6, rest_s=1.0) for seed in (1, 2)]))
    source = sqlite3.connect(path)
    with writer(server, *create_statements()) as connection:
        for table, columns in TABLES.items():
            rows = source.execute(f"SELECT * FROM {table}").fetchall()
            marks = ", ".join("%s" for _ in columns)
            connection.exec_driver_sql(f"INSERT INTO {table} VALUES ({marks})", rows)
        connection.commit()
    source.close()
    return path


def columns_of(source: TableSource) -> list[tuple[Any, Any, np.ndarray]]:
    with source:
        return [
            (experiment, one.device, np.column_stack((one.packet, one.phone_stamp, one.acceleration, one.angular_rate)))
            for experiment, recordings in source.runs()
            for one in recordings
        ]


def test_a_server_gives_what_a_file_gives(server: postgres.Server, filled: Path) -> None:
    before = contents(server)
    from_server, from_file = columns_of(SqlSource(server.url())), columns_of(SqliteSource(filled))
    assert len(from_server) == 4
    for (experiment, device, values), (same_experiment, same_device, same) in zip(from_server, from_file):
        assert (experiment, device) == (same_experiment, same_device)
        np.testing.assert_array_equal(values, same)
    assert contents(server) == before


def test_views_stand_for_tables_of_other_names(server: postgres.Server, filled: Path) -> None:
    views = [f"CREATE VIEW shown.{table} AS SELECT * FROM public.{table}" for table in TABLES]
    with writer(server, "CREATE SCHEMA shown", *views, "CREATE ROLE guest LOGIN PASSWORD 'guest'",
                "ALTER ROLE guest SET search_path = shown", "GRANT USAGE ON SCHEMA shown TO guest",
                "GRANT SELECT ON ALL TABLES IN SCHEMA shown TO guest"):  # fmt: skip
        assert len(columns_of(SqlSource(server.url(user="guest", password="guest")))) == 4


def test_nothing_can_be_written(server: postgres.Server, filled: Path) -> None:
    before = contents(server)
    with SqlSource(server.url()) as source:
        for change in ("INSERT INTO device (device_id) VALUES (99) RETURNING 1", "DELETE FROM sample RETURNING 1"):
            with pytest.raises(SourceRefused):
                list(source.query(change))
    assert contents(server) == before


def test_nothing_of_the_connection_is_told(server: postgres.Server, filled: Path, tmp_path: Path) -> None:
    wrong = {
        server.url(password="swordfish-secret"): "user and password",
        server.url(user="nobody-secret"): "user and password",
        server.url(database="nothing-secret"): "no database of that name",
        f"postgresql://lab:hunter2-secret@/postgres?host={tmp_path}/nowhere-secret": "cannot be reached",
        "postgresql://lab:hunter2-secret@host-secret.invalid/postgres": "cannot be reached",
        "postgresql://lab:hunter2-secret@127.0.0.1:9/postgres": "cannot be reached",
        "postgresql://lab:hunter2-secret@[::/secret": "not of the form",
        "oracle://lab:hunter2-secret@host-secret/postgres": "must begin with",
        "hunter2-secret": "not of the form",
    }
    for url, words in wrong.items():
        with pytest.raises(SourceRefused, match=words) as refused:
            SqlSource(url)
        told = str(refused.value)
        parts = ("secret", "lab", "guest", str(server.folder), "127.0.0.1", "invalid")
        assert not [part for part in parts if part in told], told
        assert refused.value.__suppress_context__ or refused.value.__context__ is None


def test_a_locked_table_and_an_endless_view_end(server: postgres.Server, filled: Path) -> None:
    with writer(server) as connection:
        connection.exec_driver_sql("LOCK TABLE sample IN ACCESS EXCLUSIVE MODE")
        began = time.monotonic()
        with pytest.raises(SourceRefused, match="locked"), SqlSource(server.url()) as source:
            list(source.runs())
        assert time.monotonic() - began < 60
    with SqlSource(server.url(), statement_s=0.2) as source, pytest.raises(SourceRefused, match="in time"):
        list(source.query("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i FROM n) SELECT max(i) FROM n"))


def test_missing_and_hostile_tables(server: postgres.Server, filled: Path) -> None:
    hostile = '"x""; DROP TABLE sample; --"'
    with writer(server, f"ALTER TABLE device RENAME TO {hostile}"), pytest.raises(SourceRefused, match="named device"):
        SqlSource(server.url())
    with writer(server, f"ALTER TABLE {hostile} RENAME TO device"):
        pass
    assert len(columns_of(SqlSource(server.url()))) == 4
