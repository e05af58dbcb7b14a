"""The documented schema is the one in the code."""

import re
from pathlib import Path

import pytest

from stages.imu.sources.schema import TABLES


@pytest.mark.parametrize("table", TABLES)
def test_the_documented_schema_is_the_one_in_the_code(table: str, repository: Path) -> None:
    text = (repository / "docs/measurements.md").read_text()
    between = text.split(f"<!-- {table} -->")[1].split(f"<!-- /{table} -->")[0]
    rows = re.findall(r"^\| `(\w+)` \| (.+) \|$", between, re.M)
    assert rows == [(name, meaning) for name, _, meaning in TABLES[table]]
