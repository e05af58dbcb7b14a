"""How far a sweep is: a bar on a terminal, else a plain line now and then; rate and time left in both."""

from __future__ import annotations

import sys
import time
from typing import Any

_LINE_EVERY_S = 10.0


class Progress:
    """Plain lines on standard error. `done` counts points of this run, not those found in the journal."""

    def __init__(self, total: int) -> None:
        self.total, self.done, self.failed = total, 0, 0
        self._began = self._said = time.monotonic()

    def one_more(self, failed: bool) -> None:
        """A point is done."""
        self.done += 1
        self.failed += failed
        self.show()

    def show(self) -> None:
        """Say a line if the last one is long ago."""
        if time.monotonic() - self._said >= _LINE_EVERY_S:
            self._said = time.monotonic()
            print(self.sentence(), file=sys.stderr, flush=True)

    def close(self) -> None:
        """The sweep is over."""

    def sentence(self) -> str:
        """`120 of 2000 points, 3 without result, 18.3 points/s, 1 min 43 s left`."""
        spent = time.monotonic() - self._began
        rate = self.done / spent if spent > 0 else 0.0
        left = duration((self.total - self.done) / rate) if rate else "unknown time"
        return f"{self.done} of {self.total} points, {self.failed} without result, {rate:.3g} points/s, {left} left"


class Bar(Progress):
    """A live bar on standard error."""

    def __init__(self, total: int) -> None:
        super().__init__(total)
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn
        from rich.progress import Progress as Bars

        columns = BarColumn(), TextColumn("{task.description}")
        self._bars: Any = Bars(*columns, transient=True, console=Console(stderr=True), refresh_per_second=5)
        self._task = self._bars.add_task(self.sentence(), total=total)
        self._bars.start()

    def show(self) -> None:
        """Move the bar."""
        self._bars.update(self._task, completed=self.done, description=self.sentence())

    def close(self) -> None:
        """Give the terminal back."""
        self._bars.stop()


class Silence(Progress):
    """Says nothing, for --json."""

    def show(self) -> None:
        """Say nothing."""


def duration(seconds: float) -> str:
    """A time as people say it: `43 s`, `1 min 43 s`, `3 h 10 min`, `2 d 5 h`."""
    whole = int(seconds + 0.5)
    for large, small, size, part in (("d", "h", 86400, 3600), ("h", "min", 3600, 60), ("min", "s", 60, 1)):
        if whole >= size:
            return f"{whole // size} {large} {whole % size // part} {small}"
    return f"{whole} s"


def for_terminal(total: int, as_json: bool) -> Progress:
    """The progress that fits."""
    if as_json:
        return Silence(total)
    return Bar(total) if sys.stderr.isatty() else Progress(total)
