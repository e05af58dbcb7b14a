"""A place where points are computed: a worker process that is replaced when it dies, and ended when it hangs."""

from __future__ import annotations

import contextlib
import json
import queue
import shutil
import subprocess
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from pipeline.errors import StageFailed
from pipeline.execution import process
from pipeline.sweep.chain import Job
from pipeline.sweep.row import CRASH, TIME_LIMIT, Row

_MODULE = "pipeline.sweep.worker"
_MOST_DEATHS = 2  # at the same point
_MOST_FALSE_STARTS = 5
_DYING_S = 10.0  # from the end of its messages to the end of a process
_NOWHERE = -1  # where a worker is before it begins a point

Task = tuple[int, str]


class Bench:
    """Computes chunks of points of one job, one chunk at a time."""

    def __init__(self, job: Job) -> None:
        self.job, self._line = job, job.line()
        self._process: subprocess.Popen[bytes] | None = None
        self._messages: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
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
                how = process.ending(self._end(dying=True))
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
        self._start()
        self._send(json.dumps(tasks))
        began, at = time.monotonic(), _NOWHERE
        left = len(tasks)
        while left:
            limit = self.job.time_limit_s + (self.job.start_limit_s if self._fresh else 0.0)
            try:
                message = self._messages.get(timeout=max(0.0, began + limit - time.monotonic()))
            except queue.Empty:
                self._end()
                late = tasks[0][0] if at == _NOWHERE else at
                yield late, Row(TIME_LIMIT, f"took longer than {limit:g} s", {}, limit)
                return
            if message is None:
                yield at, None
                return
            if "unfit" in message:
                raise StageFailed(message["unfit"])
            if "began" in message:
                at, began = message["began"], began if self._fresh else time.monotonic()
                continue
            self._fresh, left, began = False, left - 1, time.monotonic()
            yield message.pop("index"), Row(**message)
            at = _NOWHERE

    def _start(self) -> None:
        if self._process is not None:
            return
        folder = Path(self.job.root)
        self._messages = queue.SimpleQueue()
        self._process = process.start(
            _MODULE, self.job.code_root, folder if folder.is_dir() else None, subprocess.DEVNULL
        )
        self._fresh = True
        threading.Thread(target=_listen, args=(self._process, self._messages), daemon=True).start()
        self._scratch = tempfile.mkdtemp(prefix="bipedstudy-sweep-")
        self._send(self._line)
        self._send(self._scratch)

    def _send(self, line: str) -> None:
        """A worker that is dead already shows when it is listened to."""
        assert self._process is None or self._process.stdin is not None
        with contextlib.suppress(OSError, ValueError):
            if self._process is not None and self._process.stdin is not None:
                self._process.stdin.write(line.encode() + b"\n")
                self._process.stdin.flush()

    def _end(self, dying: bool = False) -> int:
        """End the worker if there is one; its exit code. One that is dying by itself has its own reason."""
        gone, self._process = self._process, None
        if gone is None:
            return 0
        with contextlib.suppress(subprocess.TimeoutExpired):
            gone.wait(timeout=_DYING_S if dying else 0)
        process.end(gone)
        shutil.rmtree(self._scratch, ignore_errors=True)
        return int(gone.returncode)


def _listen(worker: subprocess.Popen[bytes], messages: queue.SimpleQueue[dict[str, Any] | None]) -> None:
    assert worker.stdout is not None
    for line in worker.stdout:
        with contextlib.suppress(ValueError):
            messages.put(json.loads(line))
    messages.put(None)
