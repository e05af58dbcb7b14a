"""Files from outside are read only if they are regular files of a sensible size, and large ones in blocks.

A pipe never ends, a device has no size, and a sparse file of terabytes takes a byte on disk: each is refused before it
is opened. The digest of a large file is remembered with its size, time and inode, and taken anew when in doubt.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import stat
import time
from collections.abc import Iterator
from pathlib import Path

from pipeline.cache import durable
from pipeline.errors import StudyError

#: Largest size of a text that people write [bytes].
TEXT = 16_000_000
#: Largest size of an artefact, which is read whole [bytes].
ARTEFACT = 1_000_000_000
_BLOCK = 1 << 20
#: Smaller files are hashed faster than their digest is looked up.
_WORTH_REMEMBERING = 32_000_000
#: A file changed so short a time before it was hashed may change again without another time [s].
_IN_DOUBT_S = 2.0


def check(path: Path, where: str, largest: int | None = None) -> os.stat_result:
    """The file's status. Raises `StudyError` unless it is a regular file of at most `largest` bytes."""
    try:
        found = path.stat()
    except FileNotFoundError:
        raise StudyError(f"{where}: there is no such file") from None
    except ValueError:
        raise StudyError(f"{where}: no file can have this name") from None
    except OSError as error:
        raise StudyError(f"{where}: cannot be read: {error.strerror}") from None
    if not stat.S_ISREG(found.st_mode):
        what = "a folder" if stat.S_ISDIR(found.st_mode) else "a pipe, device or socket"
        raise StudyError(f"{where}: is {what}, not a file")
    if largest is not None and found.st_size > largest:
        raise StudyError(f"{where}: has {found.st_size} bytes; at most {largest} are read")
    return found


def content(path: Path, where: str) -> bytes:
    """The bytes of an artefact. Raises `StudyError` unless it is a regular file of sensible size that can be read."""
    check(path, where, ARTEFACT)
    try:
        return path.read_bytes()
    except OSError as error:
        raise StudyError(f"{where}: cannot be read: {error.strerror}") from None


def blocks(path: Path) -> Iterator[bytes]:
    """The content of a file, part by part."""
    with open(path, "rb") as file:
        while block := file.read(_BLOCK):
            yield block


def digest(path: Path) -> str:
    """SHA-256 of a file, read in blocks."""
    found = hashlib.sha256()
    for block in blocks(path):
        found.update(block)
    return found.hexdigest()


def inside(folder: Path, path: Path, where: str) -> Path:
    """`path`, to be written or removed. Raises `StudyError` if a link on the way to it leads out of `folder`."""
    if not path.parent.resolve().is_relative_to(folder.resolve()):
        raise StudyError(f"{where}: a link leads out of {folder.name} there, so nothing is written or removed")
    return path


class Digests:
    """Digests of files from outside; those of large files are kept in `memo`, which vouches for itself."""

    def __init__(self, memo: Path) -> None:
        self._memo = memo

    def digest(self, path: Path, where: str) -> str:
        """SHA-256 of the file. Raises `StudyError` if it is no regular file or cannot be read."""
        found = check(path, where)
        try:
            if found.st_size < _WORTH_REMEMBERING:
                return digest(path)
            name, mark = str(path.resolve()), [found.st_size, found.st_mtime_ns, found.st_ino]
            known = self._read()
            if known.get(name, [None])[0] == mark:
                return str(known[name][1])
            value = digest(path)
        except OSError as error:
            raise StudyError(f"{where}: cannot be read: {error.strerror}") from None
        if time.time() - found.st_mtime > _IN_DOUBT_S and path.stat().st_mtime_ns == found.st_mtime_ns:
            with contextlib.suppress(OSError):
                durable.write_sealed(self._memo, {**known, name: [mark, value]})
        return value

    def _read(self) -> dict[str, list[object]]:
        known = durable.read_sealed(self._memo)
        return known if isinstance(known, dict) else {}
