"""What a run says while it runs: one plain line for each stage, and on a terminal a live bar."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable
from typing import Any

from pipeline import layout

_LINE_EVERY_S = 10.0


class Display:
    """Says nothing but notes: what `--json` uses, and the base of what says more."""

    def started(self, stage: str, reasons: Iterable[str]) -> None:
        """A stage began to compute."""

    def progress(self, stage: str, fraction: float, what: str) -> None:
        """A running stage reported how far it is."""

    def points(self, done: int, total: int, sentence: str) -> None:
        """One more point of a sweep is done."""

    def finished(self, stage: str, how: str, seconds: float, summary: str) -> None:
        """A stage is up to date."""

    def failed(self, stage: str) -> None:
        """A stage did not finish; the sentence comes at the end."""

    def note(self, sentence: str) -> None:
        """Something worth knowing that stops nothing."""
        print(f"note: {sentence}", file=sys.stderr)

    def close(self) -> None:
        """The run is over: give the terminal back."""


class Lines(Display):
    """One line for each stage on standard output; with `verbose`, why it runs. `live`, bars on standard error as well.

    The terminal library is loaded with the first stage that computes, so that a run with nothing to do is quick.
    """

    def __init__(self, verbose: bool = False, live: bool = False) -> None:
        self.verbose, self.live = verbose, live
        self._said = time.monotonic()
        self._bars: Any = None
        self._tasks: dict[str, Any] = {}

    def started(self, stage: str, reasons: Iterable[str]) -> None:
        """Name the reasons, and open a bar."""
        if self.verbose:
            self._say("\n".join(layout.folded(f"{stage:<13} computing: {'; '.join(reasons)}", 15)))
        self.progress(stage, 0.0, "")

    def progress(self, stage: str, fraction: float, what: str) -> None:
        """Move the bar."""
        if not self.live:
            return
        if self._bars is None:
            self._bars = _bars()
            self._bars.start()
        if stage not in self._tasks:
            self._tasks[stage] = self._bars.add_task(stage, total=1.0, what="")
        self._bars.update(self._tasks[stage], completed=fraction, what=what)

    def points(self, done: int, total: int, sentence: str) -> None:
        """Move the sweep's bar; without bars, a line on standard error now and then."""
        if not self.live and time.monotonic() - self._said >= _LINE_EVERY_S:
            self._said = time.monotonic()
            print(sentence, file=sys.stderr, flush=True)
        self.progress("points", done / total, sentence)

    def finished(self, stage: str, how: str, seconds: float, summary: str) -> None:
        """Time and what was found."""
        spent = f"{seconds:7.1f} s" if how == "computed" else " " * 9
        self._end(stage, layout.beside(f"{stage:<13} {how:<8} {spent}  ", summary))

    def failed(self, stage: str) -> None:
        """Name the stage."""
        self._end(stage, f"{stage:<13} failed")

    def close(self) -> None:
        """Take the bars away."""
        if self._bars is not None:
            self._bars.stop()
            self._bars = None
            self._tasks.clear()
            sys.stderr.flush()

    def _end(self, stage: str, line: str) -> None:
        """The stage's line in place of its bar."""
        if stage in self._tasks:
            self._bars.remove_task(self._tasks.pop(stage))
        self._say(line)

    def _say(self, line: str) -> None:
        """Print one line at once, above the bars."""
        if self._bars is None:
            print(line, flush=True)
        else:
            self._bars.console.print(line, highlight=False, markup=False, soft_wrap=True)


def for_terminal(verbose: bool, as_json: bool) -> Display:
    """The display that fits: none for JSON, a live one on a terminal, else plain lines."""
    return Display() if as_json else Lines(verbose, live=sys.stdout.isatty() and sys.stderr.isatty())


def _bars() -> Any:
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = TextColumn("{task.description:<12}"), BarColumn(), TimeElapsedColumn(), TextColumn("{task.fields[what]}")
    return Progress(*columns, transient=True)
