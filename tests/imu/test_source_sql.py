"""The SQL source against a real PostgreSQL server: same rows as from SQLite, read-only, silent about the connection."""

import contextlib
import os
import pwd
import shutil
import signal
import socket
import sqlite3
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stages.imu.sources import databases
from stages.imu.sources.databases import SqliteSource, SqlSource, TableSource
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.schema import TABLES, create_statements
from tests import commands
from tests.imu.stand_in import make_database, make_run

CERTIFICATE = ("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=lab.invalid")
USER, PASSWORD = "lab", "hunter2-secret"


@dataclass(frozen=True)
class Server:
    """Where the server listens."""

    folder: Path
    port: int

    def url(self, database: str = "postgres", user: str = USER, password: str = PASSWORD) -> str:
        return f"postgresql://{user}:{password}@/{database}?host={self.folder}&port={self.port}"

    def by_network(self, *options: str, password: str = PASSWORD, port: int | None = None) -> str:
        """The same server by its port, or another one at `port`."""
        return f"postgresql://{USER}:{password}@127.0.0.1:{port or self.port}/postgres?{'&'.join(options)}"

    @property
    def certificate(self) -> Path:
        """Its own certificate's file, where it offers TLS; the certificate says another host name."""
        return self.folder / "server.crt"


def missing() -> str:
    """Why no server can be started here; empty where one can."""
    if os.name != "posix":
        return "the server's socket needs a posix system"
    if _program("initdb") is None or _program("postgres") is None:
        return "PostgreSQL's server is not installed (Debian: postgresql)"
    if os.geteuid() == 0 and _unprivileged() is None:
        return "PostgreSQL does not run as root, and there is no user postgres or nobody"
    return ""


@contextlib.contextmanager
def running(tls: bool = False) -> Iterator[Server]:
    """A fresh server, stopped and removed at the end; with `tls` it offers that, with a certificate of its own."""
    account = _unprivileged() if os.geteuid() == 0 else None
    folder = Path(tempfile.mkdtemp(prefix="bipedstudy-pg-"))
    (folder / "password").write_text(PASSWORD)
    if account is not None:
        for path in (folder, folder / "password"):
            shutil.chown(path, account)
    how = {"cwd": folder, "user": account, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    initdb = [_program("initdb"), "-D", folder / "base", "-U", USER, "-A", "scram-sha-256", "-E", "UTF8"]
    server = None
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    try:
        subprocess.run([*initdb, f"--pwfile={folder / 'password'}", "--no-sync"], check=True, timeout=600, **how)
        command = [_program("postgres"), "-D", folder / "base", "-k", folder, "-p", str(port), "-F"]
        command += ["-c", "listen_addresses=127.0.0.1"]
        if tls:
            subprocess.run([*CERTIFICATE, "-keyout", folder / "server.key", "-out", folder / "server.crt"], check=True,
                           **how)  # fmt: skip
            (folder / "server.key").chmod(0o600)
            command += ["-c", "ssl=on"]
            command += ["-c", f"ssl_cert_file={folder}/server.crt", "-c", f"ssl_key_file={folder}/server.key"]
        server = subprocess.Popen(command, **how)
        _wait_for(folder / "base/postmaster.pid", server)
        yield Server(folder, port)
    finally:
        if server is not None:
            server.terminate()
            server.wait(60)
        shutil.rmtree(folder, ignore_errors=True)


def _wait_for(state: Path, server: subprocess.Popen[bytes]) -> None:
    """Until the server says in its file that it takes calls: its socket is there before."""
    for _ in range(1800):
        if state.exists() and "ready" in state.read_text():
            return
        if server.poll() is not None:
            break
        time.sleep(0.1)
    raise RuntimeError("the PostgreSQL server did not start")


def _program(name: str) -> str | None:
    debian = sorted(Path("/usr/lib/postgresql").glob(f"*/bin/{name}"))
    return str(debian[-1]) if debian else shutil.which(name)


def _unprivileged() -> str | None:
    names = {entry.pw_name for entry in pwd.getpwall()}
    return next((name for name in ("postgres", "nobody") if name in names), None)


# --- The source against that server.


pytestmark = [
    pytest.mark.skipif(find_spec(name) is None, reason=f"{name} is not installed (extra [sql])")
    for name in ("sqlalchemy", "psycopg")
] + [pytest.mark.skipif(bool(missing()), reason=missing() or "none")]


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with running() as server:
        yield server


@contextlib.contextmanager
def writer(server: Server, *statements: str) -> Iterator[Any]:
    """A connection that may write, as the lab's own programs have; first it executes and keeps these."""
    import sqlalchemy  # here: every process that collects tests would load it

    url = sqlalchemy.make_url(server.url()).set(drivername="postgresql+psycopg")
    with sqlalchemy.create_engine(url, poolclass=sqlalchemy.NullPool).connect() as connection:
        for statement in statements:
            connection.exec_driver_sql(statement)
        connection.commit()
        yield connection


def contents(server: Server) -> dict[str, list[str]]:
    """Every row of every table as the server prints it, with its place on the disk, which any change moves."""
    with writer(server) as connection:
        return {
            table: [row[0] for row in connection.exec_driver_sql(f"SELECT ctid::text || t::text FROM {table} t")]
            for table in TABLES
        }


@pytest.fixture(scope="module")
def filled(server: Server, tmp_path_factory: pytest.TempPathFactory) -> Path:
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


def test_a_server_gives_what_a_file_gives(server: Server, filled: Path) -> None:
    before = contents(server)
    from_server, from_file = columns_of(SqlSource(server.url())), columns_of(SqliteSource(filled))
    assert len(from_server) == 4
    for (experiment, device, values), (same_experiment, same_device, same) in zip(from_server, from_file):
        assert (experiment, device) == (same_experiment, same_device)
        np.testing.assert_array_equal(values, same)
    assert contents(server) == before


def test_nothing_can_be_written(server: Server, filled: Path) -> None:
    before = contents(server)
    with SqlSource(server.url()) as source:
        for change in ("INSERT INTO device (device_id) VALUES (99) RETURNING 1", "DELETE FROM sample RETURNING 1"):
            with pytest.raises(SourceRefused):
                list(source.query(change))
    assert contents(server) == before


def test_nothing_of_the_connection_is_told(server: Server, filled: Path, tmp_path: Path) -> None:
    wrong = {
        server.url(password="swordfish-secret"): "user and password",
        server.url(user="nobody-secret"): "user and password",
        server.url(database="nothing-secret"): "no database of that name",
        server.url(password="pass@word-secret"): "an @ in the password; write it %40",
        server.by_network(password="pass@word-secret"): "an @ in the password; write it %40",
        server.by_network("sslmode=require"): "does not offer TLS",
        server.by_network("sslmode=always-secret"): "does not know an option",
        server.by_network("ssl_secret=1"): "does not know an option",
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


@pytest.mark.slow
def test_a_server_whose_certificate_is_not_trusted(tmp_path: Path) -> None:
    """Each reason is a sentence of its own; with the right authority, and no host name asked for, it is read."""
    stranger = tmp_path / "stranger.crt"
    subprocess.run([*CERTIFICATE, "-keyout", tmp_path / "key", "-out", stranger], check=True,
                   stderr=subprocess.DEVNULL)  # fmt: skip
    with running(tls=True) as server:
        own, hba = f"sslrootcert={server.certificate}", server.folder / "base/pg_hba.conf"
        wrong = {
            server.by_network("sslmode=verify-full", f"sslrootcert={tmp_path}/none"): "is missing",
            server.by_network("sslmode=verify-full", f"sslrootcert={stranger}"): "authority that is not known",
            server.by_network("sslmode=verify-full", own): "another host name",
            server.by_network("sslmode=require", password="wrong"): "refuses this user and password",
        }
        for url, words in wrong.items():
            with pytest.raises(SourceRefused, match=words) as refused:
                SqlSource(url)
            assert str(tmp_path) not in str(refused.value)
        with writer(server, *create_statements()):
            ways = ("sslmode=verify-ca", "sslmode=require", "sslmode=disable")
            seen = []
            for url in (*(server.by_network(way, own) for way in ways), server.url()):
                with SqlSource(url) as source:
                    seen.append(source.in_the_open)
            assert seen == [False, False, True, False], "a socket of this machine is no network"
        hba.write_text(hba.read_text().replace("host ", "hostssl "))
        with writer(server, "SELECT pg_reload_conf()"):
            time.sleep(1)
        with pytest.raises(SourceRefused, match=r"lets in nobody with this .* encryption"):
            SqlSource(server.by_network("sslmode=disable"))


@pytest.mark.slow
def test_a_silent_server_is_left(server: Server, filled: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that takes the call and says nothing, and one whose process stops while it is read."""
    began = time.monotonic()
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        for scheme in ("postgresql", "mysql") if find_spec("pymysql") else ("postgresql",):
            with pytest.raises(SourceRefused, match="did not answer in time"):
                SqlSource(server.by_network(port=silent.getsockname()[1]).replace("postgresql", scheme))
    monkeypatch.setattr(databases, "GRACE_S", 1.0)
    with SqlSource(server.url(), statement_s=1.0) as source:
        ((process,),) = source.query("SELECT pg_backend_pid()")
        os.kill(process, signal.SIGSTOP)
        try:
            with pytest.raises(SourceRefused, match="did not answer in time"):
                list(source.runs())
        finally:
            os.kill(process, signal.SIGCONT)
    assert time.monotonic() - began < 60


def test_a_schema_of_its_own_is_named(server: Server, filled: Path) -> None:
    views = [f"CREATE VIEW gait_lab.{table} AS SELECT * FROM public.{table}" for table in TABLES]
    empty = ("CREATE SCHEMA nothing_here", "CREATE SCHEMA gait_lab")
    with writer(server, *empty, *views):
        looked = server.url() + "&options=-csearch_path%3D"
        with pytest.raises(SourceRefused, match=r"'gait_lab' has all of them: .* \?options=-csearch_path%3D"):
            SqlSource(looked + "nothing_here")
        assert len(columns_of(SqlSource(looked + "gait_lab"))) == 4


def test_a_copy_has_each_row_in_its_place(
    server: Server, filled: Path, repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a server and of that copy: identities with gaps, the sensors' rows mixed, times as a database has them."""
    shown = {name: name for name, _, _ in TABLES["sample"]}
    shown |= {"sample_id": "10 * sample_id", "phone_stamp": "to_timestamp(phone_stamp)"}
    shown |= {"packet": "packet::numeric", "experiment_id": "md5(experiment_id::text)::uuid"}
    columns = ", ".join(f"{value} AS {name}" for name, value in shown.items())
    with writer(server, "CREATE SCHEMA apart", "CREATE VIEW apart.device AS SELECT * FROM public.device",
                "CREATE VIEW apart.experiment AS SELECT md5(experiment_id::text)::uuid AS experiment_id, name, origin, "
                "slope_deg FROM public.experiment", f"CREATE VIEW apart.sample AS SELECT {columns} FROM public.sample"):
        copies = tmp_path / "one.sqlite", tmp_path / "two.sqlite"
        monkeypatch.setenv("LAB", server.url() + "&options=-csearch_path%3Dapart")
        told = [commands.run("ingest", source, "--store", copy, cwd=repository)
                for source, copy in (("env:LAB", copies[0]), (copies[0], copies[1]))]  # fmt: skip
    assert [one.returncode for one in told] == [3, 3], "runs too short to be used are kept as well"
    assert told[0].stdout == told[1].stdout and copies[0].read_bytes() == copies[1].read_bytes()
    names = list(shown)
    rows, kept = (sqlite3.connect(path).execute("SELECT * FROM sample ORDER BY rowid").fetchall()
                  for path in (filled, copies[0]))  # fmt: skip
    sensors = [row[names.index("device_id")] for row in rows]
    assert len(kept) == len(rows) > 1000 and sensors != sorted(sensors)
    for row, same in zip(rows, kept):
        before, after = dict(zip(names, row)), dict(zip(names, same))
        assert after["phone_stamp"] == pytest.approx(before["phone_stamp"], abs=1e-6)
        assert len(after["experiment_id"]) == 36 and after["sample_id"] == 10 * before["sample_id"]
        others = set(names) - {"phone_stamp", "experiment_id", "sample_id"}
        assert all(after[name] == before[name] for name in others)


@pytest.mark.slow
def test_a_locked_table_and_an_endless_view_end(server: Server, filled: Path) -> None:
    with writer(server) as connection:
        connection.exec_driver_sql("LOCK TABLE sample IN ACCESS EXCLUSIVE MODE")
        began = time.monotonic()
        with pytest.raises(SourceRefused, match="locked"), SqlSource(server.url()) as source:
            list(source.runs())
        assert time.monotonic() - began < 60
    with SqlSource(server.url(), statement_s=0.2) as source, pytest.raises(SourceRefused, match="in time"):
        list(source.query("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i FROM n) SELECT max(i) FROM n"))


def test_missing_and_hostile_tables(server: Server, filled: Path) -> None:
    hostile = '"x""; DROP TABLE sample; --"'
    with writer(server, f"ALTER TABLE device RENAME TO {hostile}"), pytest.raises(SourceRefused, match="named device"):
        SqlSource(server.url())
    with writer(server, f"ALTER TABLE {hostile} RENAME TO device"):
        pass
    assert len(columns_of(SqlSource(server.url()))) == 4
