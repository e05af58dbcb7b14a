"""Worker processes that have what they import from other packages from their first moment: the asking side.

One server (`fork_server`) serves all runs of this process, as long as they share an environment and limits. On Linux
only: elsewhere a system's own libraries do not outlive a fork (NumPy computes with Apple's when it is loaded).
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import select
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from typing import IO, Any

from pipeline.execution.job import Job
from pipeline.home import engine

#: Whether workers are forked here.
HERE = sys.platform == "linux"
_LONGEST_LOADING_S = 60.0
_lock = threading.Lock()
_server: _Server | None = None


class Forked:
    """A worker process, to be used like a `subprocess.Popen`."""

    def __init__(self, server: _Server, stdin: IO[bytes], stdout: IO[bytes], told: int) -> None:
        self.stdin, self.stdout = stdin, stdout
        self._server, self._told, self._text = server, told, b""

    def __del__(self) -> None:
        os.close(self._told)

    @property
    def pid(self) -> int:
        """Process id, and group. Raises `ProcessLookupError` if there is none; a server that hangs is ended."""
        try:
            if self._lines(1, _LONGEST_LOADING_S):
                return int(self._text.split()[0])
        except subprocess.TimeoutExpired:
            self._server.process.kill()
        raise ProcessLookupError

    def wait(self, timeout: float | None = None) -> int:
        """Exit code; -9 for a process that signal 9 ended. Raises `subprocess.TimeoutExpired`."""
        if self._lines(2, timeout):
            return int(self._text.split()[1])
        with contextlib.suppress(subprocess.TimeoutExpired):  # then its end says most
            return self._server.process.wait(1.0)
        return 1

    def _lines(self, count: int, timeout: float | None) -> bool:
        """Read what the server told until it has so many lines. False if it does not tell any more."""
        end = None if timeout is None else time.monotonic() + timeout
        poll = select.poll()
        poll.register(self._told, select.POLLIN)
        while self._text.count(b"\n") < count:
            if not poll.poll(None if end is None else 1000.0 * max(0.0, end - time.monotonic())):
                raise subprocess.TimeoutExpired("worker", timeout or 0.0)
            part = os.read(self._told, 64)
            if not part:
                return False
            self._text += part
        return True


class _Server:
    """The process that workers are forked from."""

    def __init__(self, environment: Mapping[str, str]) -> None:
        self.fits = _traits(environment)
        self.line, other = socket.socketpair()
        with other:
            self.process: subprocess.Popen[bytes] = subprocess.Popen(
                [sys.executable, "-m", "pipeline.execution.fork_server"], stdin=other.fileno(),
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=engine(), env=dict(environment),
                start_new_session=True,
            )  # fmt: skip
        atexit.register(self.close)

    def start(self, wanted: bytes, errors: IO[bytes]) -> Forked:
        """A new worker. Raises OSError if the server is gone."""
        (stdin, send), (listen, stdout), (told, tell) = os.pipe(), os.pipe(), os.pipe()
        worker = Forked(self, os.fdopen(send, "wb"), os.fdopen(listen, "rb"), told)
        try:
            self.ask(wanted, stdin, stdout, errors.fileno(), tell)
        finally:
            for end in (stdin, stdout, tell):
                os.close(end)
        return worker

    def ask(self, wanted: bytes, *ends: int) -> None:
        """Let it load what is wanted, and start a worker with the four files that it is given, or none."""
        with open(os.memfd_create("wanted"), "wb") as request:
            request.write(wanted)
            request.flush()
            socket.send_fds(self.line, [b"?"], [request.fileno(), *ends])

    def close(self) -> None:
        """Let the server end."""
        atexit.unregister(self.close)
        self.line.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(1.0)


def started(environment: Mapping[str, str], errors: IO[bytes], job: Job) -> Forked:
    """A worker process for a job; it writes its errors to the open file `errors`."""
    wanted = _wanted(job.package, job.code_root, job.code, job.modules)
    with _lock:
        with contextlib.suppress(OSError):
            return _serving(environment, anew=False).start(wanted, errors)
        return _serving(environment, anew=True).start(wanted, errors)


def get_ready(environment: Mapping[str, str]) -> None:
    """Start the server, unless there is one."""
    with _lock:
        _serving(environment, anew=False)


def prepare(package: str, code_root: str, code: Mapping[str, str], modules: Sequence[str]) -> None:
    """Let the server, where there is one, load what a later worker needs."""
    with _lock, contextlib.suppress(OSError):
        if _server is not None:
            _server.ask(_wanted(package, code_root, code, modules))


def _serving(environment: Mapping[str, str], anew: bool) -> _Server:
    """The server, another one in its place where it does not fit the environment or shall be `anew`."""
    global _server
    if anew or _server is None or _server.fits != _traits(environment):
        if _server is not None:
            _server.close()
        _server = _Server(environment)
    return _server


def _wanted(package: str, code_root: str, code: Mapping[str, str], modules: Sequence[str]) -> bytes:
    return json.dumps({"package": package, "code_root": code_root, "code": {**code}, "modules": modules}).encode()


def _traits(environment: Mapping[str, str]) -> tuple[Any, ...]:
    """What a process hands down to those that it starts."""
    import resource

    names = sorted(name for name in vars(resource) if name.startswith("RLIMIT_"))
    limits = [resource.getrlimit(getattr(resource, name)) for name in names]
    return os.getpid(), dict(environment), limits
