"""Computes points in processes of their own, so that one that dies or never returns costs that point alone."""

import contextlib
import time
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection, wait
from typing import Any

from stages.biped.processes import context
from stages.extremes.parameters import CRASHED, HUNG
from stages.extremes.result import Finding

Evaluate = Callable[[Any, Any], Finding]
POLL_S = 1.0
#: Processes in a row that may end before they begin a point: it is not the points then.
MOST_FALSE_STARTS = 3
_BEGUN = None


class NoProcess(Exception):
    """No process lives long enough to begin a point."""


class _Hand:
    """One process that computes what it is sent; started when first needed, and again after its death."""

    def __init__(self, evaluate: Evaluate, common: Any) -> None:
        self.evaluate, self.common = evaluate, common
        self.process: Any = None
        self.line: Connection
        self.index, self.begun, self.since = -1, False, 0.0

    def send(self, index: int, point: Any) -> None:
        """Hand over a point. A process that cannot be started, or is dead, shows when it is listened to."""
        self.index, self.begun, self.since = index, False, time.monotonic()
        with contextlib.suppress(OSError):
            if self.process is None:
                self._start()
            self.line.send(point)

    def listen(self, longest_s: float) -> Finding | None:
        """The finding on the point at hand, if there is one by now; if that is not `begun`, it is on the process."""
        try:
            if self.process is None:
                raise EOFError
            while self.line.poll():
                word: Finding | None = self.line.recv()
                if word is not _BEGUN:
                    self.index = -1
                    return word
                self.begun, self.since = True, time.monotonic()
        except (EOFError, OSError):
            self.end()
            return Finding(CRASHED, reason="the process that computed it died")
        if time.monotonic() - self.since <= longest_s:
            return None
        self.end()
        return Finding(HUNG, reason=f"no answer within {longest_s:g} s")

    def end(self) -> None:
        if self.process is not None:
            self.line.close()
            self.process.kill()
            self.process.join()
            self.process = None
        self.index = -1

    def _start(self) -> None:
        begin = context()
        self.line, other = begin.Pipe()
        with other:
            process = begin.Process(target=_serve, args=(other, self.evaluate, self.common), daemon=True)
            process.start()
        self.process = process


def _serve(line: Connection, evaluate: Evaluate, common: Any) -> None:
    while True:
        try:
            point = line.recv()
        except EOFError:
            return
        line.send(_BEGUN)
        line.send(evaluate(common, point))


def compute(
    evaluate: Evaluate,
    common: Any,
    points: Sequence[Any],
    *,
    processes: int,
    longest_s: float,
    done: Callable[[int], None] = lambda count: None,
) -> list[Finding]:
    """`evaluate(common, point)` of every point, in order, in `processes` processes; all three must be picklable.

    A process that dies at a point gives the finding CRASHED, one that takes longer than `longest_s` HUNG; both are
    replaced. `done` gets how many points are finished. Raises `NoProcess` if one after the other ends, or hangs,
    before it begins any.
    """
    hands = [_Hand(evaluate, common) for _ in range(min(processes, len(points)))]
    findings: dict[int, Finding] = {}
    waiting = list(enumerate(points))[::-1]
    false_starts = 0
    try:
        while len(findings) < len(points):
            for hand in hands:
                if hand.index < 0 and waiting:
                    hand.send(*waiting.pop())
            busy = [hand for hand in hands if hand.index >= 0]
            wait([hand.line for hand in busy if hand.process is not None], POLL_S)
            for hand in busy:
                index, begun = hand.index, hand.begun
                finding = hand.listen(longest_s)
                if hand.begun > begun:
                    false_starts = 0
                if finding is not None and hand.begun:
                    findings[index] = finding
                elif finding is not None:
                    waiting.append((index, points[index]))
                    false_starts += 1
                if false_starts >= MOST_FALSE_STARTS:
                    raise NoProcess(f"{false_starts} processes in a row ended before they could compute a point")
            done(len(findings))
    finally:
        for hand in hands:
            hand.end()
    return list(dict(sorted(findings.items())).values())
