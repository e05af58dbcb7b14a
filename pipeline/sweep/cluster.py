"""The points of a sweep on a dask cluster: dask carries chunks of points, a bench beside each of its threads computes.

The benches are worker processes of their own, so a point that hangs or crashes costs that process and not dask's; a
dask worker that dies costs its chunks, which dask gives to another. What dask carries are texts in JSON and the name
of the function `work`, none of this program's objects. At the end stand the options that request a cluster.
"""

import contextlib
import functools
import json
import logging
import platform
import threading
import uuid
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import click

from pipeline.commands.options import Command
from pipeline.errors import StageFailed, StudyError
from pipeline.execution.job import Job, Task
from pipeline.room.confine import landlock
from pipeline.sweep.pool import CRASH, Bench, Chunks, Row

_AHEAD = 3  # chunks for each thread that dask holds, so that none waits for the next
_CONNECT_S = 15
_ATTEMPTS = 3
_IDLE_S = 60.0  # after which a bench that nobody asks any more ends: its client may have been killed
_SAME = "every machine of a cluster needs this program, in the same version"

_benches: dict[tuple[str, int], Bench] = {}  # of a job and a thread
_endings: dict[tuple[str, int], threading.Timer] = {}  # of those that rest


def connected(address: str, certificates: Mapping[str, str]) -> Any:
    """A client of the scheduler at `address`.

    `certificates` are dask's `tls_ca_file`, `tls_client_cert` and `tls_client_key`; what is not among them is taken
    from dask's own configuration (`distributed.comm.tls`). Raises `StudyError` if dask is not installed, the
    certificates cannot be used, or nobody answers.
    """
    try:
        from distributed import Client
        from distributed.security import Security
    except ImportError:
        raise StudyError("--cluster needs the extra cluster: pip install 'bipedstudy[cluster]'") from None
    for name in ("distributed", "distributed.client"):  # it logs a traceback for a connection that was lost
        logging.getLogger(name).setLevel(logging.CRITICAL)
    encrypted = urlsplit(address).scheme == "tls"
    if certificates and not encrypted:
        raise StudyError(f"--cluster {address}: certificates are for an address that begins with tls://")
    try:
        security = Security(**certificates, **({"require_encryption": True} if encrypted else {}))
        usable = security.get_connection_args("client")["ssl_context"] is not None
    except (OSError, ValueError) as error:
        raise StudyError(f"--cluster {address}: the certificates cannot be used: {error}") from None
    if encrypted and not usable:
        raise StudyError(f"--cluster {address}: needs certificates: --tls-ca-file, --tls-cert and --tls-key, or dask's "
                         "configuration distributed.comm.tls")  # fmt: skip
    try:
        client = Client(address, timeout=_CONNECT_S, security=security)
    except (OSError, TimeoutError, ValueError, TypeError, RuntimeError) as error:
        raise StudyError(f"--cluster {address}: no dask scheduler answers there ({_first_line(error)})") from None
    if not client.scheduler_info(n_workers=-1)["workers"]:
        client.close()
        raise StudyError(f"--cluster {address}: the scheduler has no workers")
    return client


def is_open(address: str) -> bool:
    """Whether whoever reaches `address` can run programs there: on this machine that is each of its users."""
    return urlsplit(address if "://" in address else f"tcp://{address}").scheme not in ("tls", "inproc")


def unconfined(client: Any) -> list[str]:
    """The machines of the cluster that cannot keep what they compute from other files."""
    answers = client.run(landlock, on_error="ignore")
    return sorted({str(urlsplit(worker).hostname) for worker, version in answers.items() if not version})


def threads(client: Any) -> int:
    """Points that the cluster computes at a time."""
    return sum(int(count) for count in client.nthreads().values())


def compute(client: Any, job: Job, chunks: Chunks) -> Iterator[tuple[int, Row]]:
    """Yield the row of each point of `chunks`, as their chunks come back.

    Raises `StageFailed` if a worker refuses the job, or the scheduler is lost.
    """
    from distributed import as_completed
    from distributed.scheduler import KilledWorker

    name = uuid.uuid4().hex  # distinguishes this job from others
    carried: Any = None  # the job, which goes to each worker once and not with each chunk
    sent: dict[Any, list[Task]] = {}
    attempts: dict[int, int] = {}
    done = as_completed(with_results=False, raise_errors=False)

    def send(tasks: list[Task]) -> None:
        nonlocal carried
        if carried is None or carried.status == "error":  # every worker that had it was lost
            carried = client.submit(str, job.text(), pure=False)
        future = client.submit(work, name, carried, json.dumps(tasks), pure=False)
        sent[future] = tasks
        done.add(future)

    try:
        for _ in range(_AHEAD * max(1, threads(client))):
            if tasks := chunks.take():
                send(tasks)
        while sent:
            future = next(done)
            tasks = sent.pop(future)
            if isinstance(_error(future), KilledWorker):
                yield from _again(tasks, attempts, send)
            else:
                rows = _rows(future)
                chunks.took(len(rows), sum(row.seconds for _, row in rows))
                yield from rows
            if more := chunks.take():
                send(more)
    finally:
        with contextlib.suppress(Exception):
            client.cancel([carried, *sent])
            client.run(forget, name, on_error="ignore")


def _error(future: Any) -> BaseException | None:
    error: BaseException | None = future.exception() if future.status == "error" else None
    return error


def _rows(future: Any) -> list[tuple[int, Row]]:
    """The rows of a chunk that came back. Raises `StageFailed`."""
    from distributed import CancelledError

    if error := _error(future):
        raise StageFailed(f"a machine of the cluster cannot compute this: {_first_line(error)}; {_SAME}")
    try:
        answers = json.loads(future.result())
    except (CancelledError, OSError):  # the one that a lost connection raises is a CancelledError
        raise StageFailed("the dask scheduler was lost, and the workers ended with it; what came back is kept: start "
                          "both again, then run the sweep again") from None
    if "refused" in answers:
        raise StageFailed(answers["refused"])
    return [(index, Row(**row)) for index, row in answers["rows"]]


def _again(tasks: list[Task], attempts: dict[int, int], send: Any) -> Iterator[tuple[int, Row]]:
    """Points of a chunk that took dask's workers down: each by itself, and given up after a few attempts."""
    for task in tasks:
        attempts[task[0]] = attempts.get(task[0], 0) + 1
        if attempts[task[0]] < _ATTEMPTS:
            send([task])
        else:
            yield task[0], Row(CRASH, "the machines that computed it were lost, again and again")


def work(name: str, job: str, tasks: str) -> str:
    """On a dask worker: compute a chunk in the bench of this thread, and report its rows, or why it refuses."""
    place = name, threading.get_ident()
    if ending := _endings.pop(place, None):
        ending.cancel()
    try:
        if place not in _benches:
            _benches[place] = Bench(Job.of(job))
        points = [(index, point) for index, point in json.loads(tasks)]
        return json.dumps({"rows": [(index, vars(row)) for index, row in _benches[place].work(points)]})
    except StudyError as error:
        return json.dumps({"refused": f"the machine {platform.node()}: {error}"})
    finally:
        _endings[place] = ending = threading.Timer(_IDLE_S, _end_idle, (place,))
        ending.daemon = True
        ending.start()


def forget(name: str) -> None:
    """On a dask worker: end the job's benches; other sweeps go on."""
    for place in [*_benches]:
        if place[0] == name and (bench := _benches.pop(place, None)):
            bench.close()


def _end_idle(place: tuple[str, int]) -> None:
    if _endings.pop(place, None) and (bench := _benches.pop(place, None)):
        bench.close()


def _first_line(error: BaseException) -> str:
    return next(iter(str(error).splitlines()), type(error).__name__)


#: Gives, in a context, a client and how much it computes at a time; it is handed what takes notes.
Connect = Callable[[Callable[[str], None]], contextlib.AbstractContextManager[tuple[Any, int]]]


@contextlib.contextmanager
def client(
    address: str | None, certificates: Mapping[str, str], note: Callable[[str], None]
) -> Iterator[tuple[Any, int]]:
    """A client of the scheduler at `address`, with certificates by dask's names, and how much it computes at a time;
    None and 0 on this machine, which has no address. Raises `StudyError`.
    """
    if address is None:
        yield None, 0
        return
    if is_open(address):
        note(f"the way to {address} is not encrypted, and whoever reaches that port, on your own computer "
             "each of its users, can run programs there; docs/sweeps.md has the way with certificates")  # fmt: skip
    found = connected(address, certificates)
    if machines := unconfined(found):
        note(f"what is computed on {', '.join(machines)} is not confined there, as Landlock is missing: it can "
             "read and write whatever the worker's user can")  # fmt: skip
    try:
        yield found, threads(found)
    finally:
        found.close()


here: Connect = functools.partial(client, None, {})


def offered(function: Command) -> Command:
    """`--jobs` for this machine, `--cluster` and its certificates; the command gets `jobs`, and `connect` to it."""

    @click.option("--jobs", "-j", metavar="N", type=click.IntRange(min=1),
                  help="How much is computed side by side (default: cores).")  # fmt: skip
    @click.option("--cluster", "address", metavar="ADDRESS",
                  help="Compute on the dask cluster of the scheduler at ADDRESS.")  # fmt: skip
    @click.option("--tls-ca-file", metavar="FILE", help="Authority of its certificates, for ADDRESS = tls://...")
    @click.option("--tls-cert", metavar="FILE", help="Certificate that shows who you are.")
    @click.option("--tls-key", metavar="FILE", help="Its key, if it is not in the certificate's file.")
    @functools.wraps(function)
    def with_cluster(
        *given: Any, jobs: int | None, address: str | None, tls_ca_file: str | None, tls_cert: str | None,
        tls_key: str | None, **options: Any,
    ) -> Any:  # fmt: skip
        if jobs and address:
            raise StudyError("--jobs is for this machine; a cluster has as many workers as it has")
        files = {"tls_ca_file": tls_ca_file, "tls_client_cert": tls_cert, "tls_client_key": tls_key}
        certificates = {name: file for name, file in files.items() if file}
        if certificates and not address:
            raise StudyError("--tls-ca-file, --tls-cert and --tls-key are for --cluster tls://...")
        for file in certificates.values():
            if not Path(file).is_file():
                raise StudyError(f"--cluster {address}: there is no file {file}")
        return function(*given, jobs=jobs, connect=functools.partial(client, address, certificates), **options)

    return with_cluster
