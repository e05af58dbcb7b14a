"""Points computed on this machine, and what came of them: a thread with a worker for each core, a file that grows.

A bench is a place where points are computed: a worker that is replaced when it dies, and ended when it hangs. How many
points each gets follows the time they take. A line of the journal is written when its point is done, so a sweep that is
killed loses what was on its way and nothing else. A line that was torn or edited fails its seal and counts as never
written.
"""

import json
import math
import os
import queue
import shutil
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline.cache import disk
from pipeline.errors import StageFailed
from pipeline.execution.job import Job, Task, named_files
from pipeline.execution.process import Message, Worker

_SYNC_EVERY_S = 2.0
_SEAL = 16
COMPUTED = "computed"
NO_ANSWER = "no answer"  # the stage's own reasoned refusal
NOT_ALLOWED = "not allowed"  # the values break a rule between parameters
TIME_LIMIT = "time limit"
CRASH = "crash"
ERROR = "error"
KEPT = (COMPUTED, NO_ANSWER)  # what follows from the point alone; the rest may be the machine's fault


@dataclass(frozen=True)
class Row:
    """Outcome of a point, the reason where there is no result, values by column, and the seconds it took."""

    outcome: str
    reason: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)
    seconds: float = 0.0


class Journal:
    """Rows on disk, of each only its place in the file in memory; what follows not from its point alone is kept there
    until the end.
    """

    def __init__(self, path: Path) -> None:
        self._places: dict[str, int] = {}
        self._unkept: dict[str, Row] = {}
        self._path, self._file = path, disk.opened_at_end(path)
        self._read_all()
        self._synced = time.monotonic()

    def close(self) -> None:
        """Flush and close the file."""
        with disk.naming(self._path):
            self._sync()
            self._file.close()

    def __contains__(self, key: str) -> bool:
        return key in self._places or key in self._unkept

    def row(self, key: str) -> Row:
        """The row of a point. Raises KeyError if it is not there."""
        if key in self._unkept:
            return self._unkept[key]
        self._file.seek(self._places[key])
        stored = json.loads(self._file.readline()[_SEAL + 1 :])
        return Row(stored["outcome"], stored["reason"], stored["values"])

    def add(self, key: str, row: Row) -> None:
        """Keep a row. What follows from the point alone is written; the seconds it took are not."""
        if row.outcome not in KEPT:
            self._unkept[key] = row
            return
        body = json.dumps({"key": key, "outcome": row.outcome, "reason": row.reason, "values": dict(row.values)})
        with disk.naming(self._path):
            place = self._file.seek(0, os.SEEK_END)
            self._file.write(disk.digest(body.encode())[:_SEAL].encode() + b" " + body.encode() + b"\n")
            self._places[key] = place
            if time.monotonic() - self._synced > _SYNC_EVERY_S:
                self._sync()
            else:
                self._file.flush()

    def _sync(self) -> None:
        self._file.flush()
        os.fsync(self._file.fileno())
        self._synced = time.monotonic()

    def _read_all(self) -> None:
        self._file.seek(0)
        place, line = 0, b"\n"
        for line in self._file:
            seal, _, body = line.rstrip(b"\n").partition(b" ")
            if line.endswith(b"\n") and disk.digest(body)[:_SEAL].encode() == seal:
                self._places[json.loads(body)["key"]] = place
            place += len(line)
        if not line.endswith(b"\n"):
            self._file.write(b"\n")  # what a killed run left half-written must not spoil the next line


_MOST_DEATHS = 2  # at the same point
_MOST_FALSE_STARTS = 5
_NOWHERE = -1


class Bench:
    """Computes chunks of points of one job, one chunk at a time."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self._worker: Worker | None = None
        self._messages: queue.SimpleQueue[Message] = queue.SimpleQueue()
        self._scratch = ""
        self._fresh = True
        self._closed = False
        self._named = set[str]()

    def work(self, tasks: Sequence[Task]) -> Iterator[tuple[int, Row]]:
        """Yield the row of every point, as it comes. A point that takes its worker down twice is a row that says so.

        A point over its time limit loses its worker, and the others go on in a new one. Raises `StageFailed` if the
        worker cannot compute this job at all.
        """
        waiting = dict(tasks)
        deaths = Counter[int]()  # of workers, by the point they were at
        while waiting and not self._closed:
            left = len(waiting)
            at, how = yield from self._attempt(waiting)
            deaths[_NOWHERE] *= left == len(waiting)
            deaths[at] += bool(how)
            if deaths[_NOWHERE] >= _MOST_FALSE_STARTS and not self._closed:
                raise StageFailed(f"the sweep's workers cannot start: {how}")
            if at in waiting and deaths[at] >= _MOST_DEATHS and not self._closed:
                del waiting[at]
                yield at, Row(CRASH, f"{how}, twice")

    def close(self) -> None:
        """End the worker, also while another thread listens to it."""
        self._closed = True
        self._end()

    def _attempt(self, waiting: dict[int, Any]) -> Generator[tuple[int, Row], None, tuple[int, str]]:
        """Rows as long as the worker lives, of points that then wait no more; at its death the point, and how it ended.

        The point is `_NOWHERE` before it begins one.
        """
        if not self.job.function and not (named := named_files(waiting.items())) <= self._named:
            self._end()  # a worker may read what its first points name
            self._named = named
        self._start().compute([*waiting.items()])
        began, at = time.monotonic(), _NOWHERE
        while waiting:
            limit = self.job.time_limit_s + (self.job.start_limit_s if self._fresh else 0.0)
            try:
                wait = None if limit == math.inf else max(0.0, began + limit - time.monotonic())
                message = self._messages.get(timeout=wait)
            except queue.Empty:
                self._end()
                late = next(iter(waiting)) if at == _NOWHERE else at
                del waiting[late]
                yield late, Row(TIME_LIMIT, f"took longer than {limit:g} s", {}, limit)
                break
            if "began" in message:
                at, began = message["began"], began if self._fresh else time.monotonic()
            elif "index" in message:
                self._fresh, at, began = False, _NOWHERE, time.monotonic()
                del waiting[message["index"]]
                yield message["index"], _row(message)
            elif "failed" in message:
                failed = message["failed"]
                if failed["kind"] == CRASH:
                    self._end()
                    return at, failed["text"]
                edited = f"{failed['file']} differs from what the sweep was started with"
                raise StageFailed(edited if failed["file"] else failed["text"])
        return _NOWHERE, ""

    def _start(self) -> Worker:
        if self._worker is None:
            self._messages = queue.SimpleQueue()
            self._scratch = tempfile.mkdtemp(prefix="bipedstudy-sweep-")
            self._worker = Worker(self.job, self._scratch, self._messages.put)
            self._fresh = True
        return self._worker

    def _end(self) -> None:
        """End the worker if there is one."""
        gone, self._worker = self._worker, None
        if gone is not None:
            gone.end()
        shutil.rmtree(self._scratch, ignore_errors=True)


def _row(message: Message) -> Row:
    seconds = message["seconds"]
    if "done" in message:
        return Row(COMPUTED, "", message["done"], seconds)
    failed = message["failed"]
    if failed["kind"] == "answer":
        return Row(NO_ANSWER, failed["text"], {}, seconds)
    return Row(ERROR, f"{failed['text']} ({failed['at']})", {}, seconds)


_TARGET_S = 2.0
_Event = tuple[int, Row] | BaseException | None


class Chunks:
    """Hands out the points of a sweep, from several threads; the sizes follow the time points have taken so far.

    Enough at once that handing them over costs little, few enough to share the end.
    """

    def __init__(self, indices: Sequence[int], task: Callable[[int], Task], workers: int) -> None:
        self._indices, self._task, self._workers = indices, task, workers
        self._next, self._done, self._seconds = 0, 0, 0.0
        self._lock = threading.Lock()

    def take(self) -> list[Task]:
        """The next points; none when all are handed out."""
        with self._lock:
            left = len(self._indices) - self._next
            mean = self._seconds / self._done if self._done else _TARGET_S
            fair = -(-left // (2 * self._workers))
            size = max(1, min(int(_TARGET_S / max(mean, 1e-6)), fair, 10_000))
            chosen = self._indices[self._next : self._next + size]
            self._next += len(chosen)
        return [self._task(index) for index in chosen]

    def took(self, points: int, seconds: float) -> None:
        """Points have taken this long."""
        with self._lock:
            self._done += points
            self._seconds += seconds


def rows(
    job: Job, numbers: Sequence[int], task: Callable[[int], Task], workers: int, client: Any
) -> Iterator[tuple[int, Row]]:  # fmt: skip
    """The row of each of the numbered tasks as it comes: from processes here, or from the cluster of a `client`."""
    chunks = Chunks(numbers, task, workers)
    if client is None:
        return compute(job, chunks, min(workers, len(numbers)))
    from pipeline.sweep import cluster

    return cluster.compute(client, job, chunks)


def compute(job: Job, chunks: Chunks, workers: int) -> Iterator[tuple[int, Row]]:
    """Yield the row of each point of `chunks` as it comes, from `workers` processes. Closing it ends them."""
    events: queue.SimpleQueue[_Event] = queue.SimpleQueue()
    benches = [Bench(job) for _ in range(workers)]
    for bench in benches:
        threading.Thread(target=_work, args=(bench, chunks, events), daemon=True).start()
    running = workers
    try:
        while running:
            event = events.get()
            if event is None:
                running -= 1
            elif isinstance(event, BaseException):
                raise event
            else:
                yield event
    finally:
        for bench in benches:
            bench.close()


def _work(bench: Bench, chunks: Chunks, events: queue.SimpleQueue[_Event]) -> None:
    try:
        while tasks := chunks.take():
            for index, row in bench.work(tasks):
                chunks.took(1, row.seconds)
                events.put((index, row))
    except BaseException as error:
        events.put(error)
    finally:
        events.put(None)
