"""How far a sweep is, as a sentence: points, rate and time left."""

from __future__ import annotations

import time

from pipeline.execution.display import Display


class Meter:
    """Counts the points of this run, not those found in the journal, and tells a display."""

    def __init__(self, total: int, display: Display) -> None:
        self.total, self.done, self.failed, self._display = total, 0, 0, display
        self._began = time.monotonic()

    def one_more(self, failed: bool) -> None:
        """A point is done."""
        self.done += 1
        self.failed += failed
        self._display.points(self.done, self.total, self.sentence())

    def sentence(self) -> str:
        """`120 of 2000 points, 3 without result, 18.3 points/s, 1 min 43 s left`."""
        spent = time.monotonic() - self._began
        rate = self.done / spent if spent > 0 else 0.0
        left = duration((self.total - self.done) / rate) if rate else "unknown time"
        return f"{self.done} of {self.total} points, {self.failed} without result, {rate:.3g} points/s, {left} left"


def duration(seconds: float) -> str:
    """A time as people say it: `43 s`, `1 min 43 s`, `3 h 10 min`, `2 d 5 h`."""
    whole = int(seconds + 0.5)
    for large, small, size, part in (("d", "h", 86400, 3600), ("h", "min", 3600, 60), ("min", "s", 60, 1)):
        if whole >= size:
            return f"{whole // size} {large} {whole % size // part} {small}"
    return f"{whole} s"
