"""The points of a sweep on this machine: a thread with a worker process for each core."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator

from pipeline.execution.job import Job
from pipeline.sweep.bench import Bench
from pipeline.sweep.chunks import Chunks
from pipeline.sweep.row import Row

_Event = tuple[int, Row] | BaseException | None


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
