"""What a run says while it runs: one plain line for each stage, and on a terminal a live bar."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable
from typing import Any, TextIO

from pipeline import layout

_LINE_EVERY_S = 10.0


class Display:
    """Says nothing: the base of the others, and what `--json` uses."""

    def started(self, stage: str, reasons: Iterable[str]) -> None:
        """A stage began to compute."""

    def progress(self, stage: str, fraction: float, what: str) -> None:
        """A running stage reported how far it is."""

    def points(self, done: int, total: int, sentence: str) -> None:
        """One more point of a sweep is done."""

    def finished(self, stage: str, how: str, seconds: float, summary: str) -> None:
        """A stage is up to date."""

    def failed(self, stage: str) -> None:
        """A stage did not finish."""

    def note(self, sentence: str) -> None:
        """Something worth knowing that stops nothing."""
        print(f"note: {sentence}", file=sys.stderr)

    def close(self) -> None:
        """The run is over."""


class Lines(Display):
    """One line for each stage on standard output; with `verbose`, why it runs."""

    def __init__(self, verbose: bool = False, out: TextIO | None = None) -> None:
        self.verbose, self.out = verbose, out
        self._said = time.monotonic()

    def started(self, stage: str, reasons: Iterable[str]) -> None:
        """Name the reasons."""
        if self.verbose:
            self.say("\n".join(layout.folded(f"{stage:<13} computing: {'; '.join(reasons)}", 15)))

    def points(self, done: int, total: int, sentence: str) -> None:
        """A line on standard error now and then."""
        if time.monotonic() - self._said >= _LINE_EVERY_S:
            self._said = time.monotonic()
            print(sentence, file=sys.stderr, flush=True)

    def finished(self, stage: str, how: str, seconds: float, summary: str) -> None:
        """Time and what was found."""
        spent = f"{seconds:7.1f} s" if how == "computed" else " " * 9
        self.say(layout.beside(f"{stage:<13} {how:<8} {spent}  ", summary))

    def failed(self, stage: str) -> None:
        """Name the stage; the sentence comes at the end."""
        self.say(f"{stage:<13} failed")

    def say(self, line: str) -> None:
        """Print one line at once."""
        print(line, file=self.out or sys.stdout, flush=True)


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


def for_terminal(verbose: bool, as_json: bool) -> Display:
    """The display that fits: none for JSON, a live one on a terminal, else plain lines."""
    if as_json:
        return Display()
    if sys.stdout.isatty() and sys.stderr.isatty():
        return Live(verbose)
    return Lines(verbose)


def _bars() -> Any:
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = TextColumn("{task.description:<12}"), BarColumn(), TimeElapsedColumn(), TextColumn("{task.fields[what]}")
    return Progress(*columns, transient=True)
