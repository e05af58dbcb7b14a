"""What the study's own campaign and its ingest are given."""

from pathlib import Path
from typing import Any

import pytest

from pipeline.study import locate


@pytest.fixture(scope="session")
def every(repository: Path) -> dict[str, Any]:
    return locate(start=repository).parameters(("analytic", "campaign", "imu"))
