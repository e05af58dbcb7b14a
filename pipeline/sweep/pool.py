"""The points of a sweep on this machine: a thread with a worker for each core, and how many points each gets."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterator, Sequence

from pipeline.execution.job import Job, Task
from pipeline.sweep.bench import Bench
from pipeline.sweep.journal import Row

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
