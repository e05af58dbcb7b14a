"""Measurements from databases in the schema of `stages.imu.sources.schema`: SQLite, PostgreSQL, MySQL.

An SQLite file is opened so that nothing in it or beside it can change. A server is asked through SQLAlchemy (extra
`sql`) in a read-only transaction, and left where it does not answer. What it says when it cannot be reached quotes
users, hosts and databases. None of that is passed on: every error becomes a sentence of our own, and the connection
string is kept nowhere.
"""

import os
import sqlite3
import threading
from abc import abstractmethod
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future
from contextlib import AbstractContextManager, contextmanager, suppress
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from stages.imu.sources.cells import (
    AT_ONCE,
    as_stored,
    device_from_row,
    experiment_from_row,
    number,
    numbers,
    recording_from_columns,
)
from stages.imu.sources.formats import FORMATS
from stages.imu.sources.opening import SourceRefused, check, printable, refuse
from stages.imu.sources.schema import SAMPLE_VALUES, TABLES, Device, Experiment, Recording

T = TypeVar("T")
Extent = tuple[Any, Any, Any]
MAGIC = b"SQLite format 3\x00"
WRITE_AHEAD = 2  # in byte 18 or 19 of a database in write-ahead mode
DRIVERS = {"postgresql": "postgresql+psycopg", "postgres": "postgresql+psycopg"}
DRIVERS |= {"mysql": "mysql+pymysql", "mariadb": "mysql+pymysql"}
TITLES = {"postgresql+psycopg": "PostgreSQL database", "mysql+pymysql": "MySQL database"}
CONNECT_S = 5
LOCK_S = 2
STATEMENT_S = 600  # an endless view must end
GRACE_S = 10  # after the server should have ended a statement by itself, or refused a connection

FORM = "postgresql://user:password@host/database"
LOGIN, MISSING = "refuses this user and password", "has no database of that name"
FORBIDDEN, LOCKED = "does not let this user read the tables", "is locked by a writer; try again when it is done"
LOCKED_FILE = "is locked by a program that writes to it; try again when it is done"
BROKEN = "is a broken SQLite database"
SLOW, UNREACHABLE = "did not answer in time", "cannot be reached"

#: Words by which an engine's sentence is recognised, all of them needed, and what is said in its place.
Reasons = tuple[tuple[tuple[str, ...], str], ...]
SQLITE_REASONS: Reasons = (
    (("locked",), LOCKED_FILE),
    (("busy",), LOCKED_FILE),
    (("not a database",), BROKEN),
    (("malformed",), BROKEN),
    (("codec can't decode",), BROKEN),
    (("unable to open",), "cannot be opened read-only (a writer may have left its log behind)"),
)
SERVER_REASONS: Reasons = (
    (("support ssl",), "does not offer TLS, which the connection string demands"),
    (("certificate verify failed",), "shows a certificate of an authority that is not known (see sslrootcert)"),
    (("root certificate",), "cannot be verified, as sslrootcert names a file that is missing or holds no certificate"),
    (("does not match host name",), "shows a certificate of another host name, which verify-full does not take"),
    (("pg_hba.conf",), "lets in nobody with this user, database, address and encryption (sslmode may help)"),
    (("invalid", "connection"), "does not know an option of the connection string, or its value"),
    (("authentication failed",), LOGIN),
    (("access denied",), LOGIN),
    (("no password supplied",), LOGIN),
    (("role", "does not exist"), LOGIN),
    (("permission denied",), FORBIDDEN),
    (("command denied",), FORBIDDEN),
    (("database", "does not exist"), MISSING),
    (("unknown database",), MISSING),
    (("lock timeout",), LOCKED),
    (("lock wait timeout",), LOCKED),
    (("timeout",), SLOW),
    (("timed out",), SLOW),
    (("connect",), UNREACHABLE),
    (("resolve host",), UNREACHABLE),
    (("host name",), UNREACHABLE),
    (("name or service",), UNREACHABLE),  # the system's own words, which psycopg 3.1 repeats
    (("name resolution",), UNREACHABLE),
)


class TableSource(AbstractContextManager["TableSource"]):
    """A database with the three tables; use as a context manager.

    An engine says how to ask (`query`), what there is (`present`) and where each run lies (`extents`). Raises
    SourceRefused, in one sentence that names the source by `name`, for what is missing or has no meaning.
    """

    #: Column whose order is that of arrival.
    order = "sample_id"
    elsewhere, in_the_open = "", False  # where the tables are, in words; whether others on the way can read the rows

    def __init__(self, name: str) -> None:
        self.name = name

    def __exit__(self, *error: object) -> None:
        self.close()

    @abstractmethod
    def query(self, sql: str, **values: Any) -> Iterator[tuple[Any, ...]]:
        """Rows of a SELECT with parameters written :name."""

    @abstractmethod
    def present(self) -> dict[str, set[str]]:
        """Tables that can be read, each with its columns."""

    @abstractmethod
    def extents(self) -> list[Extent]:
        """Experiment, first and last `order` of each run, in the order of arrival and in constant memory."""

    @abstractmethod
    def close(self) -> None:
        """Let go of the source."""

    def open_tables(self) -> None:
        """Check the tables and read the devices: the last step of a constructor. Closes the source if it fails."""
        try:
            present = self.present()
            for table, columns in TABLES.items():
                found = ", ".join(printable(name) for name in list(present)[:5]) or "no tables"
                missing = [name for name, _, _ in columns if name not in present.get(table, ())]
                refuse((table not in present,
                        f"{self.name}: needs a table named {table}; found {found}{self.elsewhere}"),
                       (bool(missing), f"{self.name}: table {table} lacks {', '.join(missing)}"))  # fmt: skip
            self.devices: dict[float, Device] = {}
            for row in self._rows("device"):
                identity = number(row["device_id"])
                refuse((identity != identity, f"{self.name}: table device has a row without a device_id"))
                self.devices[identity] = device_from_row(row, f"{self.name}, device {identity:g}")
        except BaseException:
            self.close()
            raise

    def runs(self) -> Iterator[tuple[Experiment, tuple[Recording, ...]]]:
        """Each experiment with its recordings; one experiment is in memory at a time."""
        experiments = {row["experiment_id"]: experiment_from_row(row) for row in self._rows("experiment")}
        extents = self.extents()
        refuse((not extents, f"{self.name}: table sample is empty"))
        for experiment_id, first, last in extents:
            experiment = experiments.get(experiment_id) or Experiment(name=f"run {experiment_id}", origin="unknown")
            values = {"first": first, "last": last} | ({} if experiment_id is None else {"run": experiment_id})
            rows = self.query(
                f"SELECT device_id, {', '.join(SAMPLE_VALUES)} FROM sample WHERE {self.order} BETWEEN :first AND :last "
                f"AND experiment_id {'IS NULL' if experiment_id is None else '= :run'} ORDER BY {self.order}",
                **values,
            )
            table = numbers(list(rows), len(SAMPLE_VALUES) + 1)
            yield experiment, tuple(self._recordings(experiment, table))

    def raw(self) -> Iterator[tuple[str, Iterator[tuple[Any, ...]]]]:
        """Each table with its rows as they stand there, in the order of arrival; see `as_stored`."""
        for table, columns in TABLES.items():
            names = [name for name, _, _ in columns]
            order = self.order if self.order == "rowid" else names[0]
            rows = self.query(f"SELECT {', '.join(names)} FROM {table} ORDER BY {order}")
            yield table, (tuple(map(as_stored, row)) for row in rows)

    def _recordings(self, experiment: Experiment, table: np.ndarray) -> Iterator[Recording]:
        for device_id in np.unique(table[:, 0]):
            device = self.devices.get(device_id)
            if device is None:
                raise SourceRefused(f"{self.name}: table sample names device {device_id:g}, which table device lacks")
            yield recording_from_columns(experiment, device, table[table[:, 0] == device_id, 1:])

    def _rows(self, table: str) -> list[dict[str, Any]]:
        names = [name for name, _, _ in TABLES[table]]
        return [dict(zip(names, row)) for row in self.query(f"SELECT {', '.join(names)} FROM {table}")]


class SqliteSource(TableSource):
    """A database file; use as a context manager.

    Raises SourceRefused, in one sentence, for a file that is missing, no database, broken, locked, or of another shape.
    """

    order = "rowid"

    def __init__(self, path: Path, timeout_s: float = 2.0) -> None:
        super().__init__(path.name)
        with _refusing(self, SQLITE_REASONS):
            self._connection = _open(path, timeout_s)
        self.open_tables()

    def query(self, sql: str, **values: Any) -> Iterator[tuple[Any, ...]]:
        """Rows of a SELECT."""
        with _refusing(self, SQLITE_REASONS):
            yield from self._connection.execute(sql, values)

    def present(self) -> dict[str, set[str]]:
        """Tables with their columns; no views, which may never end, and no virtual tables, which may be of views."""
        names = [name for (name,) in self.query("SELECT name FROM sqlite_master WHERE type = 'table' "
                                                "AND sql NOT LIKE 'create virtual%'")]  # fmt: skip
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
    refuse((path.is_dir(), f"{printable(path.name)} is a folder, not an SQLite database: ingest {printable(path.name)} "
            "--map MAP --store FILE makes one of the files in it"))
    real = path.resolve()  # SQLite looks there for what belongs to the file
    journal, log, index = (real.with_name(real.name + ending) for ending in ("-journal", "-wal", "-shm"))
    for each in (path, *(other for other in (journal, log, index) if other.exists())):
        check(each)
    try:
        with path.open("rb") as file:
            head = file.read(20)
    except OSError as error:
        raise SourceRefused(f"{path.name}: cannot be read ({error.strerror})") from error
    refuse((not head.startswith(MAGIC), f"{path.name}: is not an SQLite database; ingest --propose looks into "
            f"tables of text and {', '.join(FORMATS)}, and ingest --map --store makes a database of them"))
    # A reader of a write-ahead database creates an index of its log beside it, unless it knows nobody writes, or that
    # it is alone: whoever writes has made one.
    ahead, logged = WRITE_AHEAD in head[18:20], log.exists() and log.stat().st_size > 0
    alone = ahead and logged and not index.exists() and os.name == "posix"
    mode = "mode=ro&immutable=1" if ahead and not logged else "mode=ro&vfs=unix-none" if alone else "mode=ro"
    connection = sqlite3.connect(f"{real.as_uri()}?{mode}", uri=True, timeout=timeout_s)
    connection.execute("PRAGMA temp_store = MEMORY")  # who reads may write no file to sort the rows of a long run in
    if alone:
        connection.execute("PRAGMA locking_mode = EXCLUSIVE")
    connection.text_factory = partial(str, encoding="utf-8", errors="replace")
    return connection


class SqlSource(TableSource):
    """The database behind a connection string such as postgresql://user:password@host/database.

    Its tables may be views. All is read in one transaction that sees one state and cannot write. Raises SourceRefused,
    in one sentence without any part of the connection string, also for a server that is silent for longer than a
    statement may take.
    """

    def __init__(self, connection_string: str, statement_s: float = STATEMENT_S) -> None:
        super().__init__("SQL database")
        self._engine: Any = None
        self._connection: Any = None
        self._limit_s = statement_s + GRACE_S
        try:
            with _refusing(self, SERVER_REASONS):
                self._open(connection_string, statement_s)
        except SourceRefused:
            self.close()
            raise
        self.open_tables()

    def _open(self, connection_string: str, statement_s: float) -> None:
        sqlalchemy = _sqlalchemy()
        try:
            url = sqlalchemy.make_url(connection_string)
        except Exception:
            raise SourceRefused(f"{self.name}: its connection string is not of the form {FORM}") from None
        driver = DRIVERS.get(url.drivername.partition("+")[0])
        if driver is None:
            raise SourceRefused(f"{self.name}: its connection string must begin with postgresql:// or mysql://")
        self.name = TITLES[driver]
        refuse(("@" in (url.host or ""), f"{self.name}: its connection string has an @ in the password; write it %40"))
        arguments: dict[str, Any] = {"connect_timeout": CONNECT_S}
        options: dict[str, Any] = {"isolation_level": "REPEATABLE READ"}
        if driver == DRIVERS["mysql"]:
            arguments["init_command"] = "SET SESSION TRANSACTION READ ONLY"
            limits = [f"SET SESSION lock_wait_timeout = {LOCK_S}"]
        else:
            options["postgresql_readonly"] = True
            limits = [f"SET lock_timeout = '{LOCK_S}s'", f"SET statement_timeout = {round(1000 * statement_s)}"]
        self._engine = sqlalchemy.create_engine(
            url.set(drivername=driver), poolclass=sqlalchemy.NullPool, connect_args=arguments, hide_parameters=True
        )
        self._connection = _within(CONNECT_S + GRACE_S, self._engine.connect).execution_options(**options)
        for limit in limits:
            _within(self._limit_s, partial(self._connection.exec_driver_sql, limit))
        if driver == DRIVERS["mysql"]:
            ((_, cipher),) = self.query("SHOW SESSION STATUS LIKE 'Ssl_cipher'")
            self.in_the_open = not cipher and "unix_socket" not in url.query
        else:
            session = self._connection.connection.driver_connection
            self.in_the_open = not session.pgconn.ssl_in_use and not session.info.host.startswith("/")

    def query(self, sql: str, **values: Any) -> Iterator[tuple[Any, ...]]:
        """Rows of a SELECT."""
        with _refusing(self, SERVER_REASONS):
            how = {"stream_results": True}
            ask = partial(self._connection.execute, _sqlalchemy().text(sql), values, execution_options=how)
            result = _within(self._limit_s, ask)
            while rows := _within(self._limit_s, partial(result.fetchmany, AT_ONCE)):
                yield from map(tuple, rows)

    def present(self) -> dict[str, set[str]]:
        """Tables and views with their columns."""
        with _refusing(self, SERVER_REASONS):
            found = _within(self._limit_s, self._present)
        if not {*TABLES} <= {*found} and self.name == TITLES[DRIVERS["postgresql"]]:
            names = ", ".join(f"'{table}'" for table in TABLES)
            for (schema,) in self.query(
                f"SELECT table_schema FROM information_schema.tables WHERE table_name IN ({names}) "
                f"GROUP BY table_schema HAVING count(*) = {len(TABLES)} ORDER BY table_schema DESC"
            ):
                self.elsewhere = (f"; schema {printable(schema)} has all of them: end the connection string with "
                                  "?options=-csearch_path%3D and its name")  # fmt: skip
        return found

    def _present(self) -> dict[str, set[str]]:
        look = _sqlalchemy().inspect(self._connection)
        names = [*look.get_table_names(), *look.get_view_names()]
        return {
            name: {column["name"] for column in look.get_columns(name)} if name in TABLES else set() for name in names
        }

    def extents(self) -> list[Extent]:
        """Where each run lies, found by the server."""
        return list(self.query(
            "SELECT experiment_id, min(sample_id), max(sample_id) FROM sample GROUP BY experiment_id "
            "ORDER BY min(sample_id)"))  # fmt: skip

    def close(self) -> None:
        """End the transaction and the connection."""
        if self._connection is not None:
            with suppress(Exception):  # nothing was written
                _within(LOCK_S, self._connection.close)
        if self._engine is not None:
            self._engine.dispose()


def _sqlalchemy() -> Any:
    """The package, by name: no stage reads from a server, so it is in no result's key."""
    return import_module("sqlalchemy")


def _within(seconds: float, work: Callable[[], T]) -> T:
    """What `work` gives. Raises TimeoutError where it takes longer; its thread is then left behind."""
    found: Future[T] = Future()

    def answer() -> None:
        try:
            found.set_result(work())
        except BaseException as error:
            found.set_exception(error)

    threading.Thread(target=answer, daemon=True).start()
    return found.result(seconds)


@contextmanager
def _refusing(source: TableSource, reasons: Reasons) -> Generator[None, None, None]:
    """Our own words for an engine's; its words only choose among ours. Raises SourceRefused."""
    try:
        yield
    except SourceRefused:
        raise
    except ImportError:
        raise SourceRefused("a database server needs more packages; install bipedstudy with [sql]") from None
    except Exception as error:
        text = str(error) or type(error).__name__
        shown = printable(text, 120) if reasons is SQLITE_REASONS else type(error).__name__
        why = next((said for words, said in reasons if all(word in text.lower() for word in words)), "")
        raise SourceRefused(f"{source.name}: {why or f'cannot be read ({shown})'}") from None
