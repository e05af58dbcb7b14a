"""Starts worker processes, listens to them, ends them with whatever they started, and says how they ended.

On Linux they are forked from a process that has what they import from other packages (`fork_server`). One serves all
that this process starts, as long as it hands down the same environment and limits. Elsewhere workers are started
afresh: a system's own libraries need not outlive a fork (NumPy computes with Apple's when it is loaded).
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import IO, Any

from pipeline.cache import processor
from pipeline.execution.job import Job, Task
from pipeline.home import engine

Message = dict[str, Any]

#: Whether workers are forked here.
FORKED = sys.platform == "linux"
_DYING_S = 10.0  # from the end of its messages to the end of a process
_KINDS = {"began", "progress", "done", "failed"}
_SETTINGS = {
    "MPLBACKEND": "Agg",
    "PYTHONHASHSEED": "0",
    "SOURCE_DATE_EPOCH": "0",
}
_lock = threading.Lock()
_server: _Server | None = None


class Worker:
    """A process that computes points of one job. `tell` is given its messages, from another thread.

    The last one is that it `failed` where its process ended by itself. What it writes to standard error goes to the
    file `log`. It starts in the folder this program lies in: in the study's, a `pipeline.py` of the user's would be
    taken for this program.
    """

    def __init__(self, job: Job, folder: Path | str, tell: Callable[[Message], None], log: Path | None = None) -> None:
        self._pid = 0
        text = job.text()
        with open(log or os.devnull, "wb") as errors:
            if FORKED:
                self._parent, self._input, output = _forked(text, errors)
            else:
                self._parent = process = subprocess.Popen(
                    [sys.executable, "-m", "pipeline.execution.worker"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                    stderr=errors, cwd=engine(), env=_environment(), start_new_session=os.name == "posix",
                )  # fmt: skip
                assert process.stdin is not None and process.stdout is not None
                self._input, output = process.stdin, process.stdout
                self._pid = process.pid if os.name == "posix" else 0
        self._listener = threading.Thread(target=self._listen, args=(output, tell), daemon=True)
        self._listener.start()
        self._send(json.dumps([str(folder), text]))

    def compute(self, tasks: Sequence[Task]) -> None:
        """Hand over points."""
        self._send(json.dumps(tasks))

    def end(self) -> None:
        """Kill the process and whatever it started; a server that still loads what it needs with it."""
        with contextlib.suppress(OSError):
            if self._pid:
                os.killpg(self._pid, signal.SIGKILL)
            elif self._listener.is_alive():
                self._parent.kill()
        with contextlib.suppress(OSError):
            self._input.close()
        self._listener.join(_DYING_S)

    def _send(self, line: str) -> None:
        """A worker that is dead already shows when it is listened to."""
        with contextlib.suppress(OSError, ValueError):
            self._input.write(line.encode() + b"\n")
            self._input.flush()

    def _listen(self, output: IO[bytes], tell: Callable[[Message], None]) -> None:
        """Pass messages on; what something else printed before the worker took over its output is none."""
        code: int | None = None
        with output:
            for line in output:
                with contextlib.suppress(ValueError):
                    message = json.loads(line)
                    if isinstance(message, dict) and message.keys() & _KINDS:
                        tell(message)
                    elif isinstance(message, dict) and FORKED:
                        self._pid, code = self._pid or message.get("pid", 0), message.get("ended")
                if code is not None:
                    break
        with contextlib.suppress(subprocess.TimeoutExpired):
            code = self._parent.wait(_DYING_S) if code is None else code
        tell({"failed": {"kind": "crash", "text": _how_it_ended(1 if code is None else code), "file": ""}})


class _Server:
    """The process that workers are forked from, of an environment."""

    def __init__(self, environment: Mapping[str, str]) -> None:
        self.fits = _traits(environment)
        self._line, other = socket.socketpair()
        with other:
            self.process: subprocess.Popen[bytes] = subprocess.Popen(
                [sys.executable, "-m", "pipeline.execution.fork_server"], stdin=other.fileno(),
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=engine(), env=dict(environment),
                start_new_session=True,
            )  # fmt: skip
        atexit.register(self.close)

    def fork(self, job: str, errors: IO[bytes]) -> tuple[subprocess.Popen[bytes], IO[bytes], IO[bytes]]:
        """This process, and the standard input and output of a new worker. Raises OSError if the server is gone."""
        (stdin, send), (listen, stdout) = os.pipe(), os.pipe()
        whole = os.fdopen(send, "wb"), os.fdopen(listen, "rb")
        with open(stdin, "rb"), open(stdout, "wb"), open(os.memfd_create("job"), "wb") as request:
            request.write(job.encode())
            request.flush()
            socket.send_fds(self._line, [b"?"], [request.fileno(), stdin, stdout, errors.fileno()])
        return self.process, *whole

    def close(self) -> None:
        """Let the server end."""
        atexit.unregister(self.close)
        self._line.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(1.0)
            return
        self.process.kill()


def get_ready() -> None:
    """Start what workers will be forked from, where they are: it takes a while, in which others can be busy."""
    if FORKED:
        with _lock:
            _serving()


def _forked(job: str, errors: IO[bytes]) -> tuple[subprocess.Popen[bytes], IO[bytes], IO[bytes]]:
    with _lock:
        with contextlib.suppress(OSError):
            return _serving().fork(job, errors)
        return _serving(anew=True).fork(job, errors)


def _serving(anew: bool = False) -> _Server:
    """The server, another one in its place where it does not fit the environment or shall be `anew`."""
    global _server
    environment = _environment()
    if anew or _server is None or _server.fits != _traits(environment):
        if _server is not None:
            _server.close()
        _server = _Server(environment)
    return _server


def _environment() -> dict[str, str]:
    """What a worker finds in its environment."""
    search = [str(engine()), *(os.environ.get("PYTHONPATH") or "").split(os.pathsep)]
    path = os.pathsep.join(str(Path(part).absolute()) for part in search if part)
    return {**os.environ, **_SETTINGS, **processor.environment(), "PYTHONPATH": path}


def _traits(environment: Mapping[str, str]) -> tuple[Any, ...]:
    """What a process hands down to those that it starts."""
    import resource

    names = sorted(name for name in vars(resource) if name.startswith("RLIMIT_"))
    limits = [resource.getrlimit(getattr(resource, name)) for name in names]
    return os.getpid(), dict(environment), limits


def _how_it_ended(code: int) -> str:
    if code < 0:
        with contextlib.suppress(ValueError):
            return f"its process was ended by the system ({signal.Signals(-code).name})"
    return f"its process ended by itself with code {code}"
