"""Processes that a run has started, as the system knows them (`/proc`)."""

import contextlib
from pathlib import Path

SERVER = b"pipeline.execution.fork_server"


def workers(pid: int) -> list[int]:
    """Processes of stages that process `pid` has, itself or below the server and what waits for each."""
    found = []
    for child in children(pid):
        found += [pid for keeper in children(child) for pid in children(keeper)] if _is_server(child) else [child]
    return found


def started(pid: int) -> list[int]:
    """The servers and the workers of process `pid`."""
    return [child for child in children(pid) if _is_server(child)] + workers(pid)


def children(pid: int) -> list[int]:
    """Processes that the threads of process `pid` started and that are not waited for."""
    found = []
    with contextlib.suppress(OSError):
        for task in Path(f"/proc/{pid}/task").iterdir():
            found += [int(word) for word in (task / "children").read_text().split()]
    return found


def _is_server(pid: int) -> bool:
    with contextlib.suppress(OSError):
        return SERVER in Path(f"/proc/{pid}/cmdline").read_bytes()
    return False
