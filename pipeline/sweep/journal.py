"""What came of points: a row of each, and those computed before by the key of their point, a file that only grows.

A line is written when its point is done, so a sweep that is killed loses what was on its way and nothing else. A line
that was torn or edited fails its seal and counts as never written.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any

from pipeline.cache import disk

_SYNC_EVERY_S = 2.0
_SEAL = 16
COMPUTED = "computed"
NO_ANSWER = "no answer"  # the stage's own reasoned refusal
NOT_ALLOWED = "not allowed"  # the values break a rule between parameters
TIME_LIMIT = "time limit"
CRASH = "crash"
ERROR = "error"
KEPT = (COMPUTED, NO_ANSWER)  # what follows from the point alone; the rest may be the machine's fault


@dataclass(frozen=True)
class Row:
    """Outcome of a point, the reason where there is no result, values by column, and the seconds it took."""

    outcome: str
    reason: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)
    seconds: float = 0.0


class Journal:
    """Rows on disk; of each only its place in the file is kept in memory."""

    def __init__(self, path: Path) -> None:
        self._places: dict[str, int] = {}
        self._file = disk.opened_at_end(path)
        self._read_all()
        self._synced = time.monotonic()

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._sync()
        self._file.close()

    def __contains__(self, key: str) -> bool:
        return key in self._places

    def row(self, key: str) -> Row:
        """The row of a point. Raises KeyError if it is not there."""
        self._file.seek(self._places[key])
        stored = json.loads(self._file.readline()[_SEAL + 1 :])
        return Row(stored["outcome"], stored["reason"], stored["values"])

    def add(self, key: str, row: Row) -> None:
        """Keep a row. What follows from the point alone is written; the seconds it took are not."""
        body = json.dumps({"key": key, "outcome": row.outcome, "reason": row.reason, "values": dict(row.values)})
        place = self._file.seek(0, os.SEEK_END)
        self._file.write(disk.digest(body.encode())[:_SEAL].encode() + b" " + body.encode() + b"\n")
        self._places[key] = place
        if time.monotonic() - self._synced > _SYNC_EVERY_S:
            self._sync()
        else:
            self._file.flush()

    def _sync(self) -> None:
        self._file.flush()
        os.fsync(self._file.fileno())
        self._synced = time.monotonic()

    def _read_all(self) -> None:
        self._file.seek(0)
        place, line = 0, b"\n"
        for line in self._file:
            seal, _, body = line.rstrip(b"\n").partition(b" ")
            if line.endswith(b"\n") and disk.digest(body)[:_SEAL].encode() == seal:
                self._places[json.loads(body)["key"]] = place
            place += len(line)
        if not line.endswith(b"\n"):
            self._file.write(b"\n")  # what a killed run left half-written must not spoil the next line
