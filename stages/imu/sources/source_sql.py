"""Measurements from a PostgreSQL or MySQL server, through SQLAlchemy (extra `sql`), in a read-only transaction.

What the server says when it cannot be reached quotes users, hosts and databases. None of that is passed on: every
error becomes a sentence of our own, and the connection string is kept nowhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from stages.imu.errors import SourceRefused
from stages.imu.sources.schema import TABLES
from stages.imu.sources.source_tables import Extent, TableSource

DRIVERS = {"postgresql": "postgresql+psycopg", "postgres": "postgresql+psycopg"}
DRIVERS |= {"mysql": "mysql+pymysql", "mariadb": "mysql+pymysql"}
TITLES = {"postgresql+psycopg": "PostgreSQL database", "mysql+pymysql": "MySQL database"}
CONNECT_S = 5
LOCK_S = 2
STATEMENT_S = 600  # an endless view must end

FORM = "postgresql://user:password@host/database"
LOGIN, MISSING = "refuses this user and password", "has no database of that name"
FORBIDDEN, LOCKED = "does not let this user read the tables", "is locked by a writer; try again when it is done"
SLOW, UNREACHABLE = "did not answer in time", "cannot be reached"

#: Words by which a server's sentence is recognised, all of them needed, and what is said in its place.
REASONS: tuple[tuple[tuple[str, ...], str], ...] = (
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
    (("statement timeout",), SLOW),
    (("timeout expired",), UNREACHABLE),
    (("connect",), UNREACHABLE),
    (("resolve host",), UNREACHABLE),
    (("host name",), UNREACHABLE),
    (("name or service",), UNREACHABLE),  # the system's own words, which psycopg 3.1 repeats
    (("name resolution",), UNREACHABLE),
)


class SqlSource(TableSource):
    """The database behind a connection string such as postgresql://user:password@host/database.

    Its tables may be views. All is read in one transaction that sees one state and cannot write. Raises SourceRefused,
    in one sentence without any part of the connection string.
    """

    def __init__(self, connection_string: str, statement_s: float = STATEMENT_S) -> None:
        super().__init__("SQL database")
        self._engine: Any = None
        self._connection: Any = None
        try:
            self._open(connection_string, statement_s)
        except ImportError:
            raise SourceRefused("a database server needs more packages; install bipedstudy with [sql]") from None
        except SourceRefused:
            raise
        except Exception as error:
            self.close()
            raise SourceRefused(f"{self.name}: {_plain(error)}") from None
        self.open_tables()

    def _open(self, connection_string: str, statement_s: float) -> None:
        import sqlalchemy

        try:
            url = sqlalchemy.make_url(connection_string)
        except Exception:
            raise SourceRefused(f"{self.name}: its connection string is not of the form {FORM}") from None
        driver = DRIVERS.get(url.drivername.partition("+")[0])
        if driver is None:
            raise SourceRefused(f"{self.name}: its connection string must begin with postgresql:// or mysql://")
        self.name = TITLES[driver]
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
        self._connection = self._engine.connect().execution_options(**options)
        for limit in limits:
            self._connection.exec_driver_sql(limit)

    def query(self, sql: str, **values: Any) -> Iterator[tuple[Any, ...]]:
        """Rows of a SELECT."""
        import sqlalchemy

        try:
            for row in self._connection.execute(sqlalchemy.text(sql), values):
                yield tuple(row)
        except Exception as error:
            raise SourceRefused(f"{self.name}: {_plain(error)}") from None

    def present(self) -> dict[str, set[str]]:
        """Tables and views with their columns."""
        import sqlalchemy

        try:
            look = sqlalchemy.inspect(self._connection)
            names = [*look.get_table_names(), *look.get_view_names()]
            return {
                name: {column["name"] for column in look.get_columns(name)} if name in TABLES else set()
                for name in names
            }
        except Exception as error:
            raise SourceRefused(f"{self.name}: {_plain(error)}") from None

    def extents(self) -> list[Extent]:
        """Where each run lies, found by the server."""
        rows = self.query(
            "SELECT experiment_id, min(sample_id), max(sample_id) FROM sample GROUP BY experiment_id "
            "ORDER BY min(sample_id)"
        )
        return [(run, first, last) for run, first, last in rows]

    def close(self) -> None:
        """End the transaction and the connection."""
        if self._connection is not None:
            self._connection.close()
        if self._engine is not None:
            self._engine.dispose()


def _plain(error: Exception) -> str:
    """Our own words for a server's; its words only choose among ours."""
    text = str(error).lower()
    for words, reason in REASONS:
        if all(word in text for word in words):
            return reason
    return f"cannot be read ({type(error).__name__})"
