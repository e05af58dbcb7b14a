"""What a run says while it runs: one plain line for each stage, and on a terminal a live bar."""

import sys
import time
from collections.abc import Iterable
from typing import Any

from pipeline import layout

_LINE_EVERY_S = 10.0


class Display:
    """A line for each stage on standard output, unless it is `quiet`, as for --json; notes on standard error. With
    `verbose` why a stage runs; `live`, bars as well.

    The terminal library is loaded with the first stage that computes, so that a run with nothing to do is quick.
    """

    def __init__(self, quiet: bool = True, verbose: bool = False, live: bool = False) -> None:
        self.quiet, self.verbose, self.live = quiet, verbose, live
        self._said = time.monotonic()
        self._bars: Any = None
        self._tasks: dict[str, Any] = {}

    def note(self, sentence: str) -> None:
        """Something worth knowing that stops nothing."""
        print(f"note: {sentence}", file=sys.stderr)

    def started(self, stage: str, reasons: Iterable[str]) -> None:
        """A stage began to compute: name the reasons, and open a bar."""
        if self.verbose:
            why = f"{stage:<{layout.STAGE}} computing: {'; '.join(reasons)}"
            self._say("\n".join(layout.folded(why, layout.STAGE + 2)))
        self.progress(stage, 0.0, "")

    def progress(self, stage: str, fraction: float, what: str) -> None:
        """A running stage reported how far it is: move its bar."""
        if not self.live:
            return
        if self._bars is None:
            self._bars = _bars()
            self._bars.start()
        if stage not in self._tasks:
            self._tasks[stage] = self._bars.add_task(stage, total=1.0, what="")
        self._bars.update(self._tasks[stage], completed=fraction, what=what)

    def points(self, done: int, total: int, sentence: str) -> None:
        """One more point of a sweep is done: move its bar; without bars, a line on standard error now and then."""
        if not (self.quiet or self.live) and time.monotonic() - self._said >= _LINE_EVERY_S:
            self._said = time.monotonic()
            print(sentence, file=sys.stderr, flush=True)
        self.progress("points", done / total, sentence)

    def finished(self, stage: str, how: str, seconds: float, summary: str) -> None:
        """A stage is up to date: time and what was found."""
        spent = f"{seconds:7.1f} s" if how == "computed" else " " * 9
        self._end(stage, layout.beside(f"{stage:<{layout.STAGE}} {how:<8} {spent}  ", summary))

    def failed(self, stage: str) -> None:
        """A stage did not finish; the sentence comes at the end."""
        self._end(stage, f"{stage:<{layout.STAGE}} failed")

    def close(self) -> None:
        """The run is over: take the bars away, and give the terminal back."""
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
        if self._bars is not None:
            self._bars.console.print(line, highlight=False, markup=False, soft_wrap=True)
        elif not self.quiet:
            print(line, flush=True)


def for_terminal(verbose: bool, as_json: bool) -> Display:
    """The display that fits: a quiet one for JSON, a live one on a terminal, else plain lines."""
    return Display(as_json, verbose, not as_json and sys.stdout.isatty() and sys.stderr.isatty())


def _bars() -> Any:
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    name, what = TextColumn(f"{{task.description:<{layout.STAGE}}}"), TextColumn("{task.fields[what]}")
    return Progress(name, BarColumn(), TimeElapsedColumn(), what, transient=True)
