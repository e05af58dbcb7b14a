"""Breaks the file operations of the process it is loaded into, as the variable FAULT says; loaded through PYTHONPATH.

FAULT is JSON: `kind` "kill" (the process is killed just before its operation number `at`) or "full" (from that number
on there is no room for a new file), `worker` whether a stage's process is meant or the run, `below` the folder whose
files count, `mark` a file that is made when the fault happens.
"""

import errno
import json
import os
import signal
import sys

CHANGES = {"open", "os.rename", "os.remove", "os.mkdir", "os.rmdir"}


def install(kind: str, at: int, worker: bool, below: str, mark: str) -> None:
    """Count the operations of this process from now on, and break the chosen one."""
    if worker != any(name.startswith("pipeline.execution.") for name in sys.orig_argv):
        return
    count = 0

    def changes(event: str, arguments: tuple) -> bool:
        if event not in CHANGES:
            return False
        path = arguments[0]
        if not isinstance(path, (str, bytes, os.PathLike)):
            return False
        if event == "open" and not (arguments[2] or 0) & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            return False
        name = os.fsdecode(path)  # a bare name is one inside a folder that is being removed
        return os.sep not in name or name.startswith(below)

    def hook(event: str, arguments: tuple) -> None:
        nonlocal count
        if not changes(event, arguments):
            return
        count += 1
        if count == at:
            os.close(os.open(mark, os.O_CREAT | os.O_RDONLY))
        if kind == "kill" and count == at:
            os.kill(os.getpid(), signal.SIGKILL)
        if kind == "full" and count >= at and event in ("open", "os.mkdir"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), os.fsdecode(arguments[0]))

    sys.addaudithook(hook)


if "FAULT" in os.environ:
    install(**json.loads(os.environ["FAULT"]))
