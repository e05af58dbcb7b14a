"""What is read and written safely: files that are whole or not there, files from outside, and one run at a time.

A file is written beside its place, flushed to disk, then renamed. From outside only regular files of a sensible size
are read, and large ones in blocks: a pipe never ends, a device has no size, and a sparse file of terabytes takes a byte
on disk. A lock of the system ends with the process that holds it.
"""

import contextlib
import errno
import hashlib
import itertools
import json
import math
import os
import shutil
import stat
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import IO

from pipeline.errors import StudyError

#: Largest size of a file in which the cache notes something [bytes].
MEMO = 100_000_000
_serial = itertools.count()


def digest(content: bytes) -> str:
    """Content hash (SHA-256, hexadecimal)."""
    return hashlib.sha256(content).hexdigest()


def write(path: Path, content: bytes | Iterable[bytes]) -> None:
    """Put `content`, or its parts, at `path`: a reader, or a crash at any moment, meets the old file or the new one.

    A link, pipe or device at `path` is replaced; what a link names is not touched. A path that a user named is first
    `replaceable`.
    """
    with whole(path) as unfinished, open(unfinished, "xb") as file:
        file.writelines([content] if isinstance(content, bytes) else content)
        file.flush()
        os.fsync(file.fileno())


@contextlib.contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A path to write a file or folder to, which appears as `path` at the end, whole or not at all.

    Errors name it, which the system leaves out of those of an open file.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_name(f".{path.name}.{os.getpid()}-{next(_serial)}.part")
    try:
        yield unfinished
        unfinished.replace(path)
    except BaseException as error:
        with contextlib.suppress(OSError):
            remove(unfinished)
        if isinstance(error, OSError):
            error.filename = str(error.filename or path).replace(str(unfinished), str(path))
        raise
    sync_folder(path.parent)


def remove(path: Path) -> None:
    """Remove a folder with all that is in it, or a file; of a link, the link."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def read(path: Path, largest: float = math.inf) -> bytes | None:
    """The file's content; None if there is none, or a folder, pipe or device, or one of more than `largest` bytes."""
    try:
        found = path.stat()
        return b"".join(blocks(path)) if stat.S_ISREG(found.st_mode) and found.st_size <= largest else None
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


def write_sealed(path: Path, body: object) -> None:
    """Put `body` as JSON at `path`, behind a line with a seal that shows damage."""
    text = json.dumps(body, sort_keys=True).encode()
    write(path, (f"{digest(text)}\n".encode(), text))


def read_sealed(path: Path) -> object:
    """What `write_sealed` wrote; None if there is no such file or it was damaged."""
    with contextlib.suppress(ValueError, OSError, RecursionError):
        seal, _, text = (read(path, MEMO) or b"").partition(b"\n")
        if seal == digest(text).encode():
            return json.loads(text)
    return None


#: Largest size of a text that people write [bytes].
TEXT = 16_000_000
#: Largest size of an artefact, which is read whole [bytes].
ARTEFACT = 1_000_000_000
_BLOCK = 1 << 20


@contextlib.contextmanager
def readable(where: str) -> Iterator[None]:
    """Errors of reading a file become `StudyError`, a sentence on it as messages call it."""
    try:
        yield
    except FileNotFoundError:
        raise StudyError(f"{where}: there is no such file") from None
    except UnicodeDecodeError:
        raise StudyError(f"{where}: not a text file in UTF-8") from None
    except ValueError:
        raise StudyError(f"{where}: no file can have this name") from None
    except OSError as error:
        raise StudyError(f"{where}: cannot be read: {error.strerror}") from None


def check(path: Path, where: str, largest: int | None = None) -> os.stat_result:
    """The file's status. Raises `StudyError` unless it is a regular file of at most `largest` bytes."""
    with readable(where):
        found = path.stat()
    if no_file := _no_file(found):
        raise StudyError(f"{where}: is {no_file}, not a file")
    if largest is not None and found.st_size > largest:
        raise StudyError(f"{where}: has {found.st_size} bytes; at most {largest} are read")
    return found


def replaceable(path: Path) -> Path:
    """`path`, to be written. Raises `StudyError` where a folder, pipe, device or socket stands, or a link to one, and
    where what should be its folder is none.

    A rename puts a file in place of any of them, and a device that is gone is missed by the whole machine.
    """
    if path.exists() and (no_file := _no_file(path.stat())):
        raise StudyError(f"{path}: is {no_file}, and no file is put in its place")
    if path.parent.exists() and not path.parent.is_dir():
        raise StudyError(f"{path.parent}: is not a folder, so no file is written there")
    return path


def _no_file(found: os.stat_result) -> str:
    """What is there instead of a regular file; nothing where it is one."""
    if stat.S_ISREG(found.st_mode):
        return ""
    return "a folder" if stat.S_ISDIR(found.st_mode) else "a pipe, device or socket"


def content(path: Path, where: str) -> bytes:
    """The bytes of an artefact. Raises `StudyError` unless it is a regular file of sensible size that can be read."""
    check(path, where, ARTEFACT)
    with readable(where):
        return path.read_bytes()


@contextlib.contextmanager
def naming(path: Path) -> Iterator[None]:
    """Errors name the file, which the system leaves out of those of an open one."""
    try:
        yield
    except OSError as error:
        error.filename = error.filename or str(path)
        raise


def blocks(path: Path) -> Iterator[bytes]:
    """The content of a file, part by part."""
    with naming(path), open(path, "rb") as file:
        while block := file.read(_BLOCK):
            yield block


def file_digest(path: Path) -> str:
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


def checked_digest(path: Path, where: str) -> str:
    """SHA-256 of a file from outside. Raises `StudyError` if it is no regular file or cannot be read."""
    check(path, where)
    with readable(where):
        return file_digest(path)


_FAR = 1 << 30  # Windows locks bytes: one far behind the text, so that the holder's name stays readable


class NotWritable(StudyError):
    """The results folder can only be read."""


@contextlib.contextmanager
def locked(folder: Path, name: str, command: str, wait: bool, waiting: Callable[[str], None]) -> Iterator[None]:
    """Hold the lock of a results folder, called `name` in messages, while the block runs.

    Raises `StudyError` naming the holder if another run has it and `wait` is false; otherwise calls `waiting` once
    with a sentence and waits. Raises it too where the system gives no lock, and `NotWritable` if the folder can only be
    read. A killed holder needs no clearing up: the system drops its lock with the process.
    """
    path = folder / ".cache" / "lock"
    try:
        file = opened_at_end(path)
    except OSError as error:
        raise NotWritable(
            f"{name}: cannot be written ({error.strerror}); choose another folder with --results"
        ) from None
    with file:
        if not free(file, name):
            sentence = f"{name} is in use by {_holder(path)}"
            if not wait:
                raise StudyError(f"{sentence}; wait for it with --wait, or choose another folder with --results")
            waiting(f"{sentence}; waiting")
            while not free(file, name):
                time.sleep(0.1)
        with contextlib.suppress(OSError):
            holder = {"pid": os.getpid(), "command": command, "since": time.strftime("%Y-%m-%d %H:%M:%S")}
            file.truncate(0)
            os.write(file.fileno(), json.dumps(holder).encode())  # what stays in a buffer fails once more at the end
        try:
            yield
        finally:
            with contextlib.suppress(OSError):
                file.truncate(0)
            _release(file)


def free(file: IO[bytes], name: str) -> bool:
    """Take the lock of an open file, if nobody else has it. Raises `StudyError` where the system gives none."""
    try:
        _try(file)
    except OSError as error:
        if error.errno in _BUSY:
            return False
        raise StudyError(f"{name}: the system gives no lock there ({error.strerror}); choose a folder on another disk "
                         "with --results") from None  # fmt: skip
    return True


def _holder(path: Path) -> str:
    try:
        holder = json.loads(path.read_bytes())
        return f"process {holder['pid']} ({holder['command']}, since {holder['since']})"
    except (OSError, ValueError, KeyError, TypeError):
        return "another run"


if sys.platform == "win32":
    import msvcrt

    _BUSY: tuple[int, ...] = (errno.EACCES, errno.EDEADLK)

    def _try(file: IO[bytes]) -> None:
        file.seek(_FAR)
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)

    def _release(file: IO[bytes]) -> None:
        file.seek(_FAR)
        msvcrt.locking(file.fileno(), msvcrt.LK_UNLCK, 1)

else:
    import fcntl

    _BUSY = (errno.EWOULDBLOCK,)

    def _try(file: IO[bytes]) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _release(file: IO[bytes]) -> None:
        fcntl.flock(file, fcntl.LOCK_UN)
