"""The side log: when each stage ran and how long it took. Artefacts carry no times, so that their bytes repeat."""

from __future__ import annotations

import contextlib
import json
import time
from pathlib import Path
from typing import Any

from pipeline.cache import durable, regular


class Log:
    """Lines of JSON appended to one file. A log that cannot be written never stops a run."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def add(self, **what: Any) -> None:
        """Append one line with the time."""
        line = json.dumps({"time": time.strftime("%Y-%m-%dT%H:%M:%S%z"), **what})
        with contextlib.suppress(OSError), durable.opened_at_end(self.path) as file:
            file.write(line.encode() + b"\n")

    def keep(self, source: Path, target: Path) -> bool:
        """Copy a worker's own log to where the user finds it. Whether that worked."""
        try:
            durable.write(target, regular.blocks(source))
        except OSError:
            return False
        return True
