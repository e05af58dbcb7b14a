"""Files that are either whole or not there: written beside their place, flushed to disk, then renamed."""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import json
import os
from pathlib import Path

_serial = itertools.count()


def digest(content: bytes) -> str:
    """Content hash (SHA-256, hexadecimal)."""
    return hashlib.sha256(content).hexdigest()


def write(path: Path, content: bytes) -> None:
    """Put `content` at `path` so that a reader, or a crash at any moment, meets the old file or the new one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}-{next(_serial)}.part")
    try:
        with open(temporary, "xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise
    sync_folder(path.parent)


def read(path: Path) -> bytes | None:
    """The file's content, or None if there is no such file (or a folder stands there)."""
    try:
        return path.read_bytes()
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        return None


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
    """Put `body` as JSON at `path`, with a seal that tells damage."""
    text = json.dumps(body, sort_keys=True)
    write(path, json.dumps({"seal": digest(text.encode()), "body": body}, sort_keys=True).encode())


def read_sealed(path: Path) -> object:
    """What `write_sealed` wrote; None if there is no such file or it was damaged."""
    try:
        stored = json.loads(read(path) or b"")
        text = json.dumps(stored["body"], sort_keys=True)
        return stored["body"] if stored["seal"] == digest(text.encode()) else None
    except (ValueError, KeyError, TypeError, OSError):
        return None
