"""One run at a time for each results folder, by a lock that ends with the process that holds it."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO

from pipeline.cache import durable
from pipeline.errors import StudyError

_FAR = 1 << 30  # Windows locks bytes: one far behind the text, so that the holder's name stays readable


class NotWritable(StudyError):
    """The results folder can only be read."""


@contextlib.contextmanager
def held(folder: Path, name: str, command: str, wait: bool, waiting: Callable[[str], None]) -> Iterator[None]:
    """Hold the lock of a results folder, called `name` in messages, while the block runs.

    Raises `StudyError` naming the holder if another run has it and `wait` is false; otherwise calls `waiting` once
    with a sentence and waits. Raises `NotWritable` if the folder can only be read. A killed holder
    needs no clearing up: the system drops its lock with the process.
    """
    path = folder / ".cache" / "lock"
    try:
        file = durable.opened_at_end(path)
    except OSError as error:
        raise NotWritable(
            f"{name}: cannot be written ({error.strerror}); choose another folder with --results"
        ) from None
    with file:
        told = False
        while not _try(file):
            sentence = f"{name} is in use by {_holder(path)}"
            if not wait:
                raise StudyError(f"{sentence}; wait for it with --wait, or choose another folder with --results")
            if not told:
                waiting(f"{sentence}; waiting")
                told = True
            time.sleep(0.1)
        with contextlib.suppress(OSError):
            _name_holder(file, command)
        try:
            yield
        finally:
            with contextlib.suppress(OSError):
                file.truncate(0)
            _release(file)


def _name_holder(file: IO[bytes], command: str) -> None:
    holder = {"pid": os.getpid(), "command": command, "since": time.strftime("%Y-%m-%d %H:%M:%S")}
    file.truncate(0)
    file.write(json.dumps(holder).encode())
    file.flush()


def _holder(path: Path) -> str:
    try:
        holder = json.loads(path.read_bytes())
        return f"process {holder['pid']} ({holder['command']}, since {holder['since']})"
    except (OSError, ValueError, KeyError, TypeError):
        return "another run"


if sys.platform == "win32":
    import msvcrt

    def _try(file: IO[bytes]) -> bool:
        file.seek(_FAR)
        try:
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

    def _release(file: IO[bytes]) -> None:
        file.seek(_FAR)
        msvcrt.locking(file.fileno(), msvcrt.LK_UNLCK, 1)

else:
    import fcntl

    def _try(file: IO[bytes]) -> bool:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True

    def _release(file: IO[bytes]) -> None:
        fcntl.flock(file, fcntl.LOCK_UN)
