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
from typing import Any

from pipeline.order import Order

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
        package_home = str(Path(__file__).resolve().parent.parent)
        search = [order.code_root, package_home, os.environ.get("PYTHONPATH", "")]
        environment = {**os.environ, **_SETTINGS, "PYTHONPATH": os.pathsep.join(part for part in search if part)}
        with open(log, "wb") as errors:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "pipeline.worker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                cwd=root,
                env=environment,
                start_new_session=os.name == "posix",
            )
        assert self._process.stdin is not None
        with contextlib.suppress(OSError):
            self._process.stdin.write(order.line())
            self._process.stdin.flush()
        threading.Thread(target=self._listen, daemon=True).start()

    def end(self) -> None:
        """Kill the worker and whatever it started."""
        with contextlib.suppress(OSError):
            if os.name == "posix":
                os.killpg(self._process.pid, signal.SIGKILL)
            else:
                self._process.kill()
        self._process.wait()

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
            last = {"failed": {"kind": "crash", "text": _ending(self._process.wait())}}
        self.end()
        self._events.put((self.stage, last))


def _ending(code: int) -> str:
    if code < 0:
        with contextlib.suppress(ValueError):
            return f"its process was ended by the system ({signal.Signals(-code).name})"
    return f"its process ended by itself with code {code}"
