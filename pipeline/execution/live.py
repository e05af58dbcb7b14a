"""Live progress on a terminal: a bar for each running stage under the finished ones' lines."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Any

from pipeline.execution.display import Lines


class Live(Lines):
    """Draws bars on standard error; the stages' lines go to standard output as always.

    The terminal library is loaded with the first stage that computes, so that a run with nothing to do is quick.
    """

    def __init__(self, verbose: bool = False) -> None:
        super().__init__(verbose)
        self._bars: Any = None
        self._tasks: dict[str, Any] = {}

    def started(self, stage: str, reasons: Iterable[str]) -> None:
        """Open a bar."""
        super().started(stage, reasons)
        self.progress(stage, 0.0, "")

    def progress(self, stage: str, fraction: float, what: str) -> None:
        """Move the bar."""
        if self._bars is None:
            self._bars = _bars()
            self._bars.start()
        if stage not in self._tasks:
            self._tasks[stage] = self._bars.add_task(stage, total=1.0, what="")
        self._bars.update(self._tasks[stage], completed=fraction, what=what)

    def points(self, done: int, total: int, sentence: str) -> None:
        """Move the sweep's bar."""
        self.progress("points", done / total, sentence)

    def finished(self, stage: str, how: str, seconds: float, summary: str) -> None:
        """Replace the bar by the stage's line."""
        self._remove(stage)
        super().finished(stage, how, seconds, summary)

    def failed(self, stage: str) -> None:
        """Remove the bar."""
        self._remove(stage)
        super().failed(stage)

    def say(self, line: str) -> None:
        """Print above the bars."""
        if self._bars is None:
            super().say(line)
        else:
            self._bars.console.print(line, highlight=False, markup=False, soft_wrap=True)

    def close(self) -> None:
        """Give the terminal back."""
        if self._bars is not None:
            self._bars.stop()
            self._bars = None
            self._tasks.clear()
            sys.stderr.flush()

    def _remove(self, stage: str) -> None:
        if stage in self._tasks:
            self._bars.remove_task(self._tasks.pop(stage))


def _bars() -> Any:
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = TextColumn("{task.description:<12}"), BarColumn(), TimeElapsedColumn(), TextColumn("{task.fields[what]}")
    return Progress(*columns, transient=True)
