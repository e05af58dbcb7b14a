"""The points of a sweep on a dask cluster: dask carries chunks of points, a bench beside each of its threads computes.

The benches are worker processes of their own, so a point that hangs or crashes costs that process and not dask's; a
dask worker that dies costs its chunks, which dask gives to another.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from typing import Any

from pipeline.errors import StudyError
from pipeline.execution.job import Job, Task
from pipeline.sweep.bench import Bench
from pipeline.sweep.chunks import Chunks
from pipeline.sweep.row import CRASH, Row

_AHEAD = 3  # chunks for each thread that dask holds, so that none waits for the next
_PLUGIN = "bipedstudy-sweep"
_CONNECT_S = 15
_ATTEMPTS = 3

_here = threading.local()
_benches: dict[str, list[Bench]] = {}
_jobs: dict[str, Job] = {}


def connected(address: str) -> Any:
    """A client of the scheduler at `address`. Raises `StudyError` if dask is not installed or nobody answers."""
    try:
        from distributed import Client
    except ImportError:
        raise StudyError("--cluster needs the extra cluster: pip install 'bipedstudy[cluster]'") from None
    try:
        client = Client(address, timeout=_CONNECT_S)
    except (OSError, TimeoutError, ValueError) as error:
        raise StudyError(f"--cluster {address}: no dask scheduler answers there ({error})") from None
    if not client.scheduler_info(n_workers=-1)["workers"]:
        client.close()
        raise StudyError(f"--cluster {address}: the scheduler has no workers")
    return client


def threads(client: Any) -> int:
    """Points that the cluster computes at a time."""
    return sum(int(count) for count in client.nthreads().values())


def compute(client: Any, job: Job, chunks: Chunks, name: str) -> Iterator[tuple[int, Row]]:
    """Yield the row of each point of `chunks`, as their chunks come back. `name` tells this job from others."""
    from distributed import as_completed
    from distributed.scheduler import KilledWorker

    plugin = f"{_PLUGIN}-{name}"
    client.register_plugin(_plugin(name, job), name=plugin)
    sent: dict[Any, list[Task]] = {}
    attempts: dict[int, int] = {}
    done = as_completed(with_results=False, raise_errors=False)

    def send(tasks: list[Task]) -> None:
        future = client.submit(work, name, tasks, pure=False)
        sent[future] = tasks
        done.add(future)

    try:
        for _ in range(_AHEAD * max(1, threads(client))):
            if tasks := chunks.take():
                send(tasks)
        while sent:
            future = next(done)
            tasks = sent.pop(future)
            if future.status == "finished":
                rows = future.result()
                chunks.took(len(rows), sum(row.seconds for _, row in rows))
                yield from rows
            elif isinstance(future.exception(), KilledWorker) or future.cancelled():
                yield from _again(tasks, attempts, send)
            else:
                raise future.exception()
            if more := chunks.take():
                send(more)
    finally:
        with contextlib.suppress(Exception):
            client.cancel(list(sent))
            client.unregister_worker_plugin(plugin)


def _again(tasks: list[Task], attempts: dict[int, int], send: Any) -> Iterator[tuple[int, Row]]:
    """Points of a chunk that took dask's workers down: each by itself, and given up after a few attempts."""
    for task in tasks:
        attempts[task[0]] = attempts.get(task[0], 0) + 1
        if attempts[task[0]] < _ATTEMPTS:
            send([task])
        else:
            yield task[0], Row(CRASH, "the machines that computed it were lost, again and again")


def work(name: str, tasks: list[Task]) -> list[tuple[int, Row]]:
    """Compute a chunk in the bench of this thread of this dask worker."""
    job = _jobs.get(name)
    if job is None:
        raise RuntimeError("this dask worker does not know the sweep's job")
    mine: dict[str, Bench] = _here.__dict__.setdefault("benches", {})
    if name not in mine:
        mine[name] = Bench(job)
        _benches.setdefault(name, []).append(mine[name])
    return list(mine[name].work(tasks))


def remember(name: str, job: Job) -> None:
    """Know the job on this dask worker."""
    _jobs[name] = job


def forget(name: str) -> None:
    """End the job's benches on this dask worker; other sweeps go on."""
    _jobs.pop(name, None)
    for bench in _benches.pop(name, []):
        bench.close()


def _plugin(name: str, job: Job) -> Any:
    """What dask installs on every worker, also on those that come later."""
    from distributed.diagnostics.plugin import WorkerPlugin

    class Install(WorkerPlugin):  # type: ignore[misc]
        def setup(self, worker: Any) -> None:
            remember(name, job)

        def teardown(self, worker: Any) -> None:
            forget(name)

    return Install()
