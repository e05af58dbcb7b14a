"""A process that loads what stages import from other packages, once, and forks their workers, which then have it.

It is asked by `process` over the socket that is its standard input, by four files: the worker's job, and its standard
input, output and error. When the socket ends, nobody can ask any more, and it ends as well. Each worker has a process
of its own above it, which waits for it; on the worker's output that one writes the process id and, at last, the exit
code.

It never runs code of the stages: a worker imports that itself, under observation, so that its result's key stays true.
It computes nothing and starts no thread, as a forked process has none of its parent's;
if some package starts threads when it is loaded, workers are started afresh from then on.
"""

import contextlib
import gc
import json
import os
import signal
import socket
import sys
import traceback
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from pipeline.cache import disk
from pipeline.cache.sources import Imports, beside, with_parents
from pipeline.errors import StudyError
from pipeline.execution import worker
from pipeline.execution.job import Job
from pipeline.home import home_of
from pipeline.room.confine import when_parent_ends

_THREADS = Path("/proc/self/task")


def main() -> NoReturn:
    """Entry of `python -m pipeline.execution.fork_server`."""
    when_parent_ends(signal.SIGCONT)
    os.register_at_fork(after_in_child=np.random.seed)  # or numbers drawn without a seed would be the same in all
    line = socket.socket(fileno=os.dup(0))
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    while files := socket.recv_fds(line, 1, 4)[1]:
        request, stdin, stdout, errors = files
        os.dup2(errors, 2)  # what packages say while they are loaded
        with open(request, "rb") as text:
            text.seek(0)
            load(Job.of(text.read().decode()))
        gc.freeze()  # what is loaded here is never looked through for garbage again, and so stays shared
        alone = False
        with contextlib.suppress(PermissionError):  # where a stranger's study confines all of its command
            alone = len([*_THREADS.iterdir()]) == 1
        try:
            if not os.fork():
                line.close()
                _keep(stdin, stdout, alone)
        except OSError:  # no room for another process
            traceback.print_exc()
            _reply(stdout, ended=1)
        for number in (stdin, stdout, errors):
            os.close(number)
        os.dup2(nothing, 2)
        with contextlib.suppress(ChildProcessError):
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
    signal.alarm(1)  # whoever is stopped, and so does not end, goes on when this process is gone
    with contextlib.suppress(ChildProcessError):
        while os.wait():
            pass
    os._exit(0)


def load(job: Job) -> None:
    """Import what the import of the job's modules will from other packages; the worker says what is wrong with them."""
    with contextlib.suppress(StudyError):
        home = home_of(job.package, Path(job.code_root))
        memo = beside(home / job.package)  # with what whoever asked has just found in the sources
        heads: dict[str, Imports] = {}
        for file in job.code:
            if file.endswith(".py"):
                heads[file] = memo.meaning(disk.read(home / file) or b"").heads
        for module, names in foreign(job.package, job.modules, heads):
            with contextlib.suppress(BaseException):
                __import__(module, fromlist=names)


def foreign(
    package: str, modules: Iterable[str], heads: Mapping[str, Imports]
) -> Iterator[tuple[str, list[str]]]:
    """What `modules` of a package import from others when they are imported; `heads` by file, of all of the package.

    What is imported inside of functions is not, nor what a statement at the head has around it.
    """
    waiting, seen = [*modules], set[str]()
    while waiting:
        for module in with_parents(waiting.pop()):
            if module in seen:
                continue
            seen.add(module)
            base = module.replace(".", "/")
            for target, names in (*heads.get(f"{base}.py", ()), *heads.get(f"{base}/__init__.py", ())):
                if target.split(".")[0] == package:
                    waiting += [target, *(f"{target}.{name}" for name in names)]
                else:
                    yield target, names


def _keep(stdin: int, stdout: int, alone: bool) -> NoReturn:
    """Be the process above a worker: start it, and report how it ended."""
    when_parent_ends(signal.SIGKILL)
    code = 1
    try:
        pid = os.fork()
        if not pid:
            _work(stdin, stdout, alone)
        code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    except OSError:
        traceback.print_exc()
    _reply(stdout, ended=code)
    os._exit(0)


def _work(stdin: int, stdout: int, alone: bool) -> NoReturn:
    try:
        os.setsid()
        _reply(stdout, pid=os.getpid())
        for number, end in enumerate((stdin, stdout)):
            os.dup2(end, number)
            os.close(end)
        if alone:
            os.environ["STAGE_PROCESSES"] = "fork"  # what a stage may do: no library has threads here
            worker.main()
        os.execv(sys.executable, [sys.executable, "-m", worker.__name__])
    except BaseException as error:
        traceback.print_exception(error)
    os._exit(1)


def _reply(stdout: int, **what: Any) -> None:
    with contextlib.suppress(OSError):  # nobody may want to know any more
        os.write(stdout, b"\n" + json.dumps(what).encode() + b"\n")


if __name__ == "__main__":
    main()
