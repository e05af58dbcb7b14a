"""Computes points in processes of their own, so that one that dies or never returns costs that point alone."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection, wait
from typing import Any

from stages.extremes.verdict import CRASHED, HUNG, Finding

Evaluate = Callable[[Any, Any], Finding]
POLL_S = 1.0


class _Hand:
    """One process that computes what it is sent; started when first needed, and again after its death."""

    def __init__(self, evaluate: Evaluate, common: Any) -> None:
        self.evaluate, self.common = evaluate, common
        self.process: Any = None
        self.line: Connection
        self.index, self.since = -1, 0.0

    def send(self, index: int, point: Any) -> None:
        if self.process is None:
            context = multiprocessing.get_context("spawn")
            self.line, other = context.Pipe()
            self.process = context.Process(target=_serve, args=(other, self.evaluate, self.common), daemon=True)
            self.process.start()
            other.close()
        self.index, self.since = index, time.monotonic()
        self.line.send(point)

    def end(self) -> None:
        if self.process is not None:
            self.line.close()
            self.process.kill()
            self.process.join()
            self.process = None
        self.index = -1


def _serve(line: Connection, evaluate: Evaluate, common: Any) -> None:
    while True:
        try:
            point = line.recv()
        except EOFError:
            return
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

    A process that dies gives the finding CRASHED, one that takes longer than `longest_s` HUNG; both are replaced.
    `done` is told how many points are finished.
    """
    hands = [_Hand(evaluate, common) for _ in range(min(processes, len(points)))]
    findings: dict[int, Finding] = {}
    waiting = list(enumerate(points))[::-1]
    try:
        while len(findings) < len(points):
            for hand in hands:
                if hand.index < 0 and waiting:
                    hand.send(*waiting.pop())
            busy = {hand.line: hand for hand in hands if hand.index >= 0}
            ready = wait(list(busy), POLL_S)
            for line in ready:
                hand = busy[line]  # type: ignore[index]
                index = hand.index
                try:
                    findings[index], hand.index = hand.line.recv(), -1
                except (EOFError, OSError):
                    hand.end()
                    findings[index] = Finding(CRASHED, reason="the process that computed it died")
            for hand in hands:
                if hand.index >= 0 and time.monotonic() - hand.since > longest_s:
                    index = hand.index
                    hand.end()
                    findings[index] = Finding(HUNG, reason=f"no answer within {longest_s:g} s")
            done(len(findings))
    finally:
        for hand in hands:
            hand.end()
    return [findings[index] for index in range(len(points))]
