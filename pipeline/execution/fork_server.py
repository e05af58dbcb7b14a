"""A process that loads what stages import from other packages, once, and forks their workers, which then have it.

It is asked by `forked` over the socket that is its standard input, by files alone: the first has JSON with the package
of stages, its folder, and the source files that the worker's key was made from with what they mean; then come the
worker's standard input, output and error, and a pipe on which its process id and, at its end, its exit code are told.
Without these it only loads what a worker will need. Whoever asked is gone when the socket ends; then this process ends
as well.

It never runs code of the stages: a worker imports that itself, under observation, so that its result's key stays true.
Sources are only compiled here. It computes nothing and starts no thread, as a forked process has none of its parent's;
if some package starts threads when it is loaded, workers are started afresh from then on.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import select
import signal
import socket
import subprocess
import sys
import traceback
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from pipeline.cache import durable
from pipeline.cache.closure import with_parents
from pipeline.cache.syntax import Imports, SyntaxMemo, beside
from pipeline.errors import StudyError
from pipeline.execution import worker
from pipeline.execution.observed_import import Compiled
from pipeline.execution.process import continue_when_parent_ends
from pipeline.stage_modules import home_of

_THREADS = Path("/proc/self/task")


def main() -> NoReturn:
    """Entry of `python -m pipeline.execution.fork_server`."""
    continue_when_parent_ends()
    gc.set_threshold(worker.OBJECTS)
    server = _Server()
    os.register_at_fork(after_in_child=np.random.seed)  # or numbers drawn without a seed would be the same in all
    while server.serve():
        pass
    os._exit(0)


class _Server:
    """The socket, what is loaded, and the pipe of each worker that has not ended, by process id."""

    def __init__(self) -> None:
        self.line = socket.socket(fileno=os.dup(0))
        self.nothing = os.open(os.devnull, os.O_RDWR)
        os.dup2(self.nothing, 0)
        self.woken, wake = os.pipe()
        for end in (self.woken, wake):
            os.set_blocking(end, False)
        signal.signal(signal.SIGCHLD, lambda number, frame: None)
        signal.set_wakeup_fd(wake)
        self.own = (self.line.fileno(), self.nothing, self.woken, wake)
        self.compiled = Compiled(SyntaxMemo(None))
        self.heads: dict[str, dict[str, tuple[str, Imports]]] = {}
        self.seen: set[tuple[str, tuple[str, ...]]] = set()
        self.workers: dict[int, int] = {}

    def serve(self) -> bool:
        """Wait for a request, or the end of a worker. False if nobody can ask any more."""
        ready, _, _ = select.select([self.woken, self.line.fileno()], [], [])
        if self.woken in ready:
            os.read(self.woken, 4096)
            self._take_leave()
        if self.line.fileno() not in ready:
            return True
        said, ends, _, _ = socket.recv_fds(self.line, 1, 5)
        if not said:
            return False
        with open(ends.pop(0), "rb") as request:
            request.seek(0)
            wanted = json.load(request)
        if ends:
            os.dup2(ends[2], 2)  # what packages say while they are loaded
        self._load(**wanted)
        if ends:
            self._begin(ends)
        return True

    def _load(self, package: str, code_root: str, code: dict[str, str], modules: list[str]) -> None:
        """Compile the files of `code`, and import what the import of `modules` will, but what was before; the worker
        says what is wrong with them.
        """
        with contextlib.suppress(StudyError):
            home = home_of(package, Path(code_root))
            heads = self.heads.setdefault(str(home), {})
            self.compiled.memo = beside(home / package)  # with what whoever asked has just found in the sources
            for file, meaning in code.items():
                if file.endswith(".py") and heads.get(file, ("", ()))[0] != meaning:
                    source = durable.read(home / file)
                    heads[file] = meaning, self.compiled.take(home / file, source) if source else ()
            for module, names in foreign(package, modules, {file: found for file, (_, found) in heads.items()}):
                if (module, names) not in self.seen:
                    self.seen.add((module, names))
                    with contextlib.suppress(BaseException):
                        __import__(module, fromlist=names)
            with contextlib.suppress(Exception):
                ready_numba(sys.modules.get("numba"))

    def _begin(self, ends: list[int]) -> None:
        """Start a worker with the four files that came for it."""
        try:
            pid = self._forked(ends) if len([*_THREADS.iterdir()]) == 1 else self._afresh(ends)
            self.workers[pid] = ends.pop()
        except OSError:  # no room for another process: that its pipe ends untold says so
            traceback.print_exc()
        os.dup2(self.nothing, 2)
        for end in ends:
            os.close(end)

    def _forked(self, ends: list[int]) -> int:
        gc.freeze()  # what is loaded here is never looked through for garbage again, and so stays shared
        pid = os.fork()
        if pid:
            return pid
        try:
            os.setsid()
            signal.set_wakeup_fd(-1)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            for number, end in enumerate(ends[:3]):
                os.dup2(end, number)
            _tell(ends[3], os.getpid())
            for end in (*self.own, *ends, *self.workers.values()):
                os.close(end)
            worker.main(self.compiled)
        except BaseException as error:
            traceback.print_exception(error)
        os._exit(1)

    def _afresh(self, ends: list[int]) -> int:
        process = subprocess.Popen([sys.executable, "-m", worker.__name__], stdin=ends[0], stdout=ends[1],
                                   stderr=ends[2], start_new_session=True)  # fmt: skip
        process.returncode = 0  # it is waited for here, like the others
        _tell(ends[3], process.pid)
        return process.pid

    def _take_leave(self) -> None:
        """Tell the exit codes of the workers that have ended."""
        with contextlib.suppress(ChildProcessError):
            while True:
                pid, status = os.waitpid(-1, os.WNOHANG)
                if not pid:
                    return
                end = self.workers.pop(pid)
                _tell(end, os.waitstatus_to_exitcode(status))
                os.close(end)


def foreign(
    package: str, modules: Iterable[str], heads: Mapping[str, Imports]
) -> Iterator[tuple[str, tuple[str, ...]]]:
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


@cache
def ready_numba(numba: Any) -> None:
    """Let numba take in what it knows of Python and NumPy, which it leaves to the first function it compiles: .2 s."""
    if numba is not None:
        numba.njit("int64()")(_zero)


def _zero() -> int:
    return 0


def _tell(end: int, number: int) -> None:
    with contextlib.suppress(OSError):  # nobody may want to know any more
        os.write(end, b"%d\n" % number)


if __name__ == "__main__":
    main()
