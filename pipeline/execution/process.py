"""Starts a worker process, listens to it, and says in one sentence how it ended."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import IO, Any

from pipeline.execution.order import Order

Event = tuple[str, dict[str, Any]]
_SETTINGS = {
    "MPLBACKEND": "Agg",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "PYTHONHASHSEED": "0",
    "SOURCE_DATE_EPOCH": "0",
}


class Worker:
    """One running stage. Its messages arrive in `events` as (stage, message), the last one "done" or "failed"."""

    def __init__(self, order: Order, root: Path, log: Path, events: queue.SimpleQueue[Event]) -> None:
        self.stage, self.log, self._events = order.stage, log, events
        with open(log, "wb") as errors:
            self._process = start("pipeline.execution.worker", order.code_root, root, errors)
        assert self._process.stdin is not None
        with contextlib.suppress(OSError):
            self._process.stdin.write(order.line())
            self._process.stdin.flush()
        threading.Thread(target=self._listen, daemon=True).start()

    def end(self) -> None:
        """Kill the worker and whatever it started."""
        end(self._process)

    def _listen(self) -> None:
        assert self._process.stdout is not None
        last: dict[str, Any] = {}
        for line in self._process.stdout:
            with contextlib.suppress(ValueError):
                last = json.loads(line)
            if "done" in last or "failed" in last:
                break
            self._events.put((self.stage, last))
        else:
            last = {"failed": {"kind": "crash", "text": ending(self._process.wait())}}
        self.end()
        self._events.put((self.stage, last))


def start(module: str, code_root: str, folder: Path | None, errors: IO[bytes] | int) -> subprocess.Popen[bytes]:
    """A process of its own group that runs `module` with pipes to and from it, and its standard error in `errors`."""
    package_home = str(Path(__file__).resolve().parents[2])
    search = [code_root, package_home, os.environ.get("PYTHONPATH", "")]
    return subprocess.Popen(
        [sys.executable, "-m", module],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=errors,
        cwd=folder,
        env={**os.environ, **_SETTINGS, "PYTHONPATH": os.pathsep.join(part for part in search if part)},
        start_new_session=os.name == "posix",
    )


def end(process: subprocess.Popen[bytes]) -> None:
    """Kill a process that `start` made, and whatever it started."""
    with contextlib.suppress(OSError):
        if os.name == "posix":
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
    process.wait()


def end_group() -> None:
    """End this process, one that `start` made, and whatever it started itself."""
    if hasattr(os, "killpg") and os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


def ending(code: int) -> str:
    """How a process ended, for the end of a sentence."""
    if code < 0:
        with contextlib.suppress(ValueError):
            return f"its process was ended by the system ({signal.Signals(-code).name})"
    return f"its process ended by itself with code {code}"
