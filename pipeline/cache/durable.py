"""Files that are either whole or not there: written beside their place, flushed to disk, then renamed."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import itertools
import json
import math
import os
import stat
from collections.abc import Iterable
from pathlib import Path
from typing import IO

#: Largest size of a file in which the cache notes something [bytes].
MEMO = 100_000_000
_serial = itertools.count()


def digest(content: bytes) -> str:
    """Content hash (SHA-256, hexadecimal)."""
    return hashlib.sha256(content).hexdigest()


def write(path: Path, content: bytes | Iterable[bytes]) -> None:
    """Put `content`, or its parts, at `path`: a reader, or a crash at any moment, meets the old file or the new one.

    A link at `path` is replaced; what it names is not touched.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}-{next(_serial)}.part")
    try:
        with open(temporary, "xb") as file:
            file.writelines([content] if isinstance(content, bytes) else content)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise
    sync_folder(path.parent)


def read(path: Path, largest: float = math.inf) -> bytes | None:
    """The file's content; None if there is none, or a folder, pipe or device, or one of more than `largest` bytes."""
    try:
        found = path.stat()
        return path.read_bytes() if stat.S_ISREG(found.st_mode) and found.st_size <= largest else None
    except (FileNotFoundError, NotADirectoryError):
        return None


def opened_at_end(path: Path) -> IO[bytes]:
    """The file opened to read it and to write at its end; made if it is missing.

    Raises OSError also for a link, whose target may be anybody's, and for a pipe or device. A file that has a second
    name elsewhere is copied first, so that what that name stands for stays as it is.
    """
    if path.is_symlink() or (path.exists() and not path.is_file()):
        raise OSError(errno.EINVAL, "a link or no plain file stands there", str(path))
    path.parent.mkdir(parents=True, exist_ok=True)
    file = open(path, "a+b")  # noqa: SIM115 - the caller closes it
    if os.fstat(file.fileno()).st_nlink <= 1:
        return file
    with file:
        file.seek(0)
        write(path, file.read())
    return open(path, "a+b")


def sync_folder(folder: Path) -> None:
    """Make a rename inside `folder` survive a power cut, where the system can do so."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def is_unfinished(path: Path) -> bool:
    """Whether the file was left behind by a `write` that was killed."""
    return path.name.startswith(".") and path.suffix == ".part"


def write_sealed(path: Path, body: object) -> None:
    """Put `body` as JSON at `path`, behind a line with a seal that tells damage."""
    text = json.dumps(body, sort_keys=True).encode()
    write(path, (f"{digest(text)}\n".encode(), text))


def read_sealed(path: Path) -> object:
    """What `write_sealed` wrote; None if there is no such file or it was damaged."""
    with contextlib.suppress(ValueError, OSError, RecursionError):
        seal, _, text = (read(path, MEMO) or b"").partition(b"\n")
        if seal == digest(text).encode():
            return json.loads(text)
    return None
