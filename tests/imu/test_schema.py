"""The documented schema is the one in the code."""

import re
import sqlite3
from functools import partial
from pathlib import Path

import pytest

from stages.imu.sources.schema import TABLES, DatabaseWriter


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
