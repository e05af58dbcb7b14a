"""A place where points are computed: a worker process that is replaced when it dies, and ended when it hangs."""

from __future__ import annotations

import math
import queue
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence

from pipeline.errors import StageFailed
from pipeline.execution.job import Job, Task
from pipeline.execution.process import Message, Worker
from pipeline.sweep.journal import COMPUTED, CRASH, ERROR, NO_ANSWER, TIME_LIMIT, Row

_MOST_DEATHS = 2  # at the same point
_MOST_FALSE_STARTS = 5
_NOWHERE = -1  # where a worker is before it begins a point


class Bench:
    """Computes chunks of points of one job, one chunk at a time."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self._worker: Worker | None = None
        self._messages: queue.SimpleQueue[Message] = queue.SimpleQueue()
        self._scratch = ""
        self._fresh = True
        self._closed = False

    def work(self, tasks: Sequence[Task]) -> Iterator[tuple[int, Row]]:
        """Yield the row of every point, as it comes. A point that takes its worker down twice is a row that says so.

        A point over its time limit loses its worker, and the others go on in a new one. Raises `StageFailed` if the
        worker cannot compute this job at all.
        """
        waiting = list(tasks)
        deaths = Counter[int]()  # of workers, by the point they were at
        while waiting and not self._closed:
            lost = None
            for index, row in self._attempt(waiting):
                if row is None:
                    lost = index
                    break
                waiting = [task for task in waiting if task[0] != index]
                deaths[_NOWHERE] = 0
                yield index, row
            if lost is not None:
                deaths[lost] += 1
                how = self._end(dying=True)
                if deaths[_NOWHERE] >= _MOST_FALSE_STARTS and not self._closed:
                    raise StageFailed(f"the sweep's workers cannot start: {how}")
                if lost != _NOWHERE and deaths[lost] >= _MOST_DEATHS and not self._closed:
                    waiting = [task for task in waiting if task[0] != lost]
                    yield lost, Row(CRASH, f"{how}, twice")

    def close(self) -> None:
        """End the worker, also while another thread listens to it."""
        self._closed = True
        self._end()

    def _attempt(self, tasks: Sequence[Task]) -> Iterator[tuple[int, Row | None]]:
        """Rows as long as the worker lives; at its death the point it was at (or `_NOWHERE`) with None."""
        self._start().compute(tasks)
        began, at = time.monotonic(), _NOWHERE
        left = len(tasks)
        while left:
            limit = self.job.time_limit_s + (self.job.start_limit_s if self._fresh else 0.0)
            try:
                wait = None if limit == math.inf else max(0.0, began + limit - time.monotonic())
                message = self._messages.get(timeout=wait)
            except queue.Empty:
                self._end()
                late = tasks[0][0] if at == _NOWHERE else at
                yield late, Row(TIME_LIMIT, f"took longer than {limit:g} s", {}, limit)
                return
            if not message:
                yield at, None
                return
            if "began" in message:
                at, began = message["began"], began if self._fresh else time.monotonic()
            elif "index" in message:
                self._fresh, left, began = False, left - 1, time.monotonic()
                yield message["index"], _row(message)
                at = _NOWHERE
            elif "failed" in message:
                failed = message["failed"]
                edited = f"{failed['file']} differs from what the sweep was started with"
                raise StageFailed(edited if failed["file"] else failed["text"])

    def _start(self) -> Worker:
        if self._worker is None:
            self._messages = queue.SimpleQueue()
            self._scratch = tempfile.mkdtemp(prefix="bipedstudy-sweep-")
            self._worker = Worker(self.job, self._scratch, self._messages.put)
            self._fresh = True
        return self._worker

    def _end(self, dying: bool = False) -> str:
        """End the worker if there is one; how it ended."""
        gone, self._worker = self._worker, None
        how = gone.end(dying) if gone else ""
        shutil.rmtree(self._scratch, ignore_errors=True)
        return how


def _row(message: Message) -> Row:
    seconds = message["seconds"]
    if "done" in message:
        return Row(COMPUTED, "", message["done"], seconds)
    failed = message["failed"]
    if failed["kind"] == "answer":
        return Row(NO_ANSWER, failed["text"], {}, seconds)
    return Row(ERROR, f"{failed['text']} ({failed['at']})", {}, seconds)
