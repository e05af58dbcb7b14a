"""Starts worker processes, listens to them, ends them with whatever they started, and says how they ended."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pipeline.cache import processor
from pipeline.execution import forked
from pipeline.execution.job import Job, Task
from pipeline.home import engine

Message = dict[str, Any]

_PR_SET_PDEATHSIG = 1
_DYING_S = 10.0  # from the end of its messages to the end of a process
_KINDS = {"began", "progress", "done", "failed"}
_SETTINGS = {
    "MPLBACKEND": "Agg",
    "PYTHONHASHSEED": "0",
    "SOURCE_DATE_EPOCH": "0",
}


def get_ready() -> None:
    """Start what workers will be forked from, where they are: it takes a while, in which others can be busy."""
    if forked.HERE:
        forked.get_ready(_environment())


def _environment() -> dict[str, str]:
    """What a worker finds in its environment."""
    search = [str(engine()), *(os.environ.get("PYTHONPATH") or "").split(os.pathsep)]
    path = os.pathsep.join(str(Path(part).absolute()) for part in search if part)
    return {**os.environ, **_SETTINGS, **processor.environment(), "PYTHONPATH": path}


class Worker:
    """A process that computes points of one job. `tell` is given its messages, from another thread, and at last {}.

    What it writes to standard error goes to the file `log`. It starts in the folder this program lies in: in the
    study's, a `pipeline.py` of the user's would be taken for this program.
    """

    def __init__(self, job: Job, folder: Path | str, tell: Callable[[Message], None], log: Path | None = None) -> None:
        environment = _environment()
        self._process: forked.Forked | subprocess.Popen[bytes]
        with open(log or os.devnull, "wb") as errors:
            if forked.HERE:
                self._process = forked.started(environment, errors, job)
            else:
                self._process = subprocess.Popen(
                    [sys.executable, "-m", "pipeline.execution.worker"],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=errors,
                    cwd=engine(),
                    env=environment,
                    start_new_session=os.name == "posix",
                )
        threading.Thread(target=self._listen, args=(tell,), daemon=True).start()
        self._send(json.dumps([str(folder), job.text()]))

    def compute(self, tasks: Sequence[Task]) -> None:
        """Hand over points."""
        self._send(json.dumps(tasks))

    def end(self, dying: bool = False) -> str:
        """Kill the process and whatever it started; how it ended, for the end of a sentence.

        One that is `dying` by itself gets some time for that, as it has a reason of its own.
        """
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout=_DYING_S if dying else 0)
        with contextlib.suppress(OSError):
            if os.name == "posix" or not isinstance(self._process, subprocess.Popen):
                os.killpg(self._process.pid, signal.SIGKILL)
            else:
                self._process.kill()
        code = self._process.wait()
        if code < 0:
            with contextlib.suppress(ValueError):
                return f"its process was ended by the system ({signal.Signals(-code).name})"
        return f"its process ended by itself with code {code}"

    def _send(self, line: str) -> None:
        """A worker that is dead already shows when it is listened to."""
        assert self._process.stdin is not None
        with contextlib.suppress(OSError, ValueError):
            self._process.stdin.write(line.encode() + b"\n")
            self._process.stdin.flush()

    def _listen(self, tell: Callable[[Message], None]) -> None:
        """Pass messages on; what something else printed before the worker took over its output is none."""
        assert self._process.stdout is not None
        for line in self._process.stdout:
            with contextlib.suppress(ValueError):
                message = json.loads(line)
                if isinstance(message, dict) and message.keys() & _KINDS:
                    tell(message)
        tell({})


def continue_when_parent_ends() -> None:
    """Let this process go on when its parent ends, should somebody have stopped it: it could not notice that itself.

    It then finds its input closed. On Linux only; elsewhere a stopped process waits until it is told to go on.
    """
    if sys.platform == "linux":
        import ctypes

        with contextlib.suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGCONT, 0, 0, 0)


def end_group() -> None:
    """End this process, one that is a worker, and whatever it started itself."""
    if hasattr(os, "killpg") and os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(1)
