"""The room in which every file from outside is read: a process that can read that file and Python, and little else.

What a reader yields comes back through a pipe as JSON, with the bytes of arrays behind it. Nothing is unpickled, so
that a reader that a file has taken over can answer with wrong numbers alone. On Linux the process is forked, elsewhere
it is begun afresh. Processor time, memory, and what is unpacked have limits, which grow with the size of the source.
What an HDF5 file says of itself is looked at before anything in it is read: its size, and whether all of it is there.
"""

import contextlib
import io
import json
import math
import os
import re
import signal
import stat
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, NoReturn

import h5py
import numpy as np

from pipeline.cache import disk
from pipeline.errors import STOPPING, StudyError, is_answer
from pipeline.execution.process import FORKED
from pipeline.home import engine, named
from pipeline.room.confine import beside, confine, when_parent_ends

Reader = Callable[..., Iterable[Any]]
_ARRAY, _HEAD = "array", struct.Struct("<Q")
_NUMBERS = re.compile(r"[<>|][fiub]\d{1,2}$")
_LONGEST_HEAD = 1 << 28
_PATIENCE = 30.0  # by the clock, which a busy machine shares among as many; waiting for a disk counts as well


@dataclass(frozen=True)
class Limits:
    """What reading a source of `size` [bytes] may take: processor time [s], memory and answers [bytes], rows."""

    size: int

    @property
    def seconds(self) -> float:
        """Of processor time; a sheet takes the most, 1.5 s for each of its megabytes."""
        return max(4.0 + 1.2e-6 * self.size, 2.5e-6 * self.size)

    @property
    def memory(self) -> int:
        """Beside that of the program; a database's rows take the most."""
        return 768_000_000 + 12 * self.size

    @property
    def rows(self) -> int:
        """Of a table: what was measured has noise, and takes a byte a row at least, however it is packed."""
        return 1_000_000 + self.size

    def over(self, what: str) -> str:
        """The clause that says which limit was met."""
        words = {
            "time": f"takes more than {self.seconds:.1f} s of processor time to read",
            "clock": f"takes more than {_PATIENCE * self.seconds:.3g} s by the clock to read",
            "memory": f"takes more than {self.memory / 1e6:.0f} MB of memory to read",
            "unpacked": f"unpacks to more than {self.memory / 1e6:.0f} MB",
            "rows": f"has a table of more than {self.rows} rows",
        }
        return f"{words[what]}, the limit for {self.size / 1e6:.3g} MB"


def read(reader: Reader, source: Path, *given: Any, writes: Path | None = None) -> Iterator[Any]:
    """What `reader(source, *given)`, a function of a module, yields when it runs in the room.

    All are numbers, words, arrays of numbers, and lists and mappings of these. A folder is read with what lies in it, a
    file with what a database has beside it; `writes` is a file that the reader fills. Raises `StudyError`, in one
    sentence that names the source.
    """
    source = source.absolute()  # . has no name
    name = ascii(source.name)
    size = _size(source, name)
    limits = Limits(size)
    if writes is not None:
        writes.touch()
    process = _Process(reader, source, given, writes, limits)
    try:
        left = limits.memory
        while (head := process.take(_HEAD.size)) and (length := _HEAD.unpack(head)[0]) <= _LONGEST_HEAD:
            said = json.loads(process.take(length))
            if "ended" in said:
                if said["ended"] is None:
                    return
                what = said["ended"]
                raise StudyError(f"{name} {limits.over(what)}" if what in ("memory", "rows", "unpacked") else what)
            parts = []
            for kind, shape in said["arrays"]:
                if not _NUMBERS.match(kind) or min(shape, default=0) < 0:
                    raise StudyError(f"{name}: its reader gave no answer that can be read")
                left -= (count := math.prod(shape) * np.dtype(kind).itemsize)
                if left < 0:
                    raise StudyError(f"{name} {limits.over('unpacked')}")
                parts.append(np.frombuffer(process.take(count), dtype=kind).reshape(shape) if count else
                             np.empty(shape, kind))  # fmt: skip
            yield _whole(said["item"], parts)
        code, late = process.ended()
        what = "clock" if late else "time" if code == -getattr(signal, "SIGXCPU", 0) else ""
        raise StudyError(f"{name} {limits.over(what)}" if what else
                      f"{name} cannot be read: its reader ended by itself ({_how(code)})")  # fmt: skip
    finally:
        process.kill()


def vetted(path: Path, where: str) -> bytes:
    """The bytes of an artefact, which was read whole in the room. Raises `StudyError` where that is refused."""
    content = disk.content(path, where)
    if [*read(vet, path)] != [disk.digest(content)]:
        raise StudyError(f"{where} was changed by someone else meanwhile; try again")
    return content


def check(source: Path, name: str) -> os.stat_result:
    """What is there. Raises `StudyError` unless it is a plain file or a folder, and all above it folders."""
    for each in (*reversed(source.absolute().parents), source):
        try:
            found = each.stat()
        except (OSError, ValueError) as error:
            raise StudyError(f"{name} cannot be read ({getattr(error, 'strerror', error)})") from None
        if not stat.S_ISDIR(found.st_mode) and not stat.S_ISREG(found.st_mode):
            which = "it" if each == source else ascii(each.name)
            raise StudyError(f"{name} cannot be read: {which} is a pipe, device or socket, not a file")
    return found


def _size(source: Path, name: str) -> int:
    """Bytes of a source; a file with holes has less than its length."""
    found = [check(source, name)]
    if source.is_dir():
        with contextlib.suppress(OSError):
            found = [each.stat() for each in source.rglob("*") if each.is_file()]
    return sum(min(each.st_size, 512 * getattr(each, "st_blocks", each.st_size)) for each in found)


class _Process:
    """The process of one reading."""

    def __init__(self, reader: Reader, source: Path, given: Any, writes: Path | None, limits: Limits) -> None:
        self._late, self._limits, self._child, self._popen = False, limits, 0, None
        if FORKED:
            listen, send = os.pipe()
            self._child = os.fork()
            if not self._child:
                _begin(send, reader, source, given, writes, limits)
            os.close(send)
            self._answer: IO[bytes] = os.fdopen(listen, "rb")
        else:
            requested = [sys.path, reader.__module__, reader.__qualname__, str(source), given, writes and str(writes)]
            self._popen = subprocess.Popen([sys.executable, "-m", __name__, json.dumps(requested)], cwd=engine(),
                                           stdin=subprocess.DEVNULL, stdout=subprocess.PIPE)  # fmt: skip
            assert self._popen.stdout is not None
            self._answer = self._popen.stdout
        self._asked, self._over = math.inf, threading.Event()
        threading.Thread(target=self._watch, daemon=True).start()

    def take(self, count: int) -> bytearray:
        """The next bytes of the answer, fewer at its end. Whoever lets this wait for too long is ended."""
        found, self._asked = bytearray(count), time.monotonic()
        try:
            got = self._answer.readinto(found)  # type: ignore[attr-defined]
        finally:
            self._asked = math.inf
        return found[:got] if got < count else found

    def ended(self) -> tuple[int, bool]:
        """Its exit code, and whether it was ended for its slowness."""
        code = self._popen.wait() if self._popen else os.waitstatus_to_exitcode(os.waitpid(self._child, 0)[1])
        self._child, self._popen = 0, None
        return code, self._late

    def kill(self) -> None:
        """End it, where that has not been done."""
        self._over.set()
        self._answer.close()
        if self._popen:
            self._popen.kill()
        elif self._child:
            os.kill(self._child, signal.SIGKILL)
        if self._popen or self._child:
            self.ended()

    def _watch(self) -> None:
        patience = _PATIENCE * self._limits.seconds
        while not self._over.wait(patience / 50):
            if time.monotonic() - self._asked > patience:
                self._late = True
                with contextlib.suppress(OSError):
                    self._popen.kill() if self._popen else os.kill(self._child, signal.SIGKILL)
                return


def _begin(send: int, *requested: Any) -> NoReturn:
    """Be the forked process of a reading: without what its parent has open, and without its ways to end."""
    with contextlib.suppress(BaseException):
        for ending in STOPPING:
            signal.signal(ending, signal.SIG_DFL)
        nothing = os.open(os.devnull, os.O_RDWR)
        for number in (0, 1, 2):
            os.dup2(nothing, number)
        os.dup2(send, 3)
        os.closerange(4, os.sysconf("SC_OPEN_MAX"))
        _answer(3, *requested)
    os._exit(1)


def _begun_afresh(path: list[str], module: str, name: str, source: str, given: list[Any], writes: str | None) -> None:
    """The same in a process of its own, whose standard output is the answer; what a reader prints goes nowhere."""
    sys.path[:] = path
    send = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    file = Path(source)
    _answer(send, named(module, name), file, given, Path(writes) if writes else None, Limits(_size(file, file.name)))


def _answer(send: int, reader: Reader, source: Path, given: Any, writes: Path | None, limits: Limits) -> None:
    """Confine this process, read, and send what is yielded."""
    when_parent_ends(getattr(signal, "SIGKILL", 0))
    code = [Path(sys.modules[reader.__module__.partition(".")[0]].__path__[0]), Path(__file__).parents[1]]
    confine([source, *beside(source), *code], [writes] if writes else [], memory=limits.memory, seconds=limits.seconds,
            written=limits.memory if writes else 0)  # fmt: skip
    with os.fdopen(send, "wb") as out:
        try:
            _check_unpacked(source, limits)
            for item in reader(source, *given):
                _hand_over(out, item, limits)
            _send(out, {"ended": None})
        except BrokenPipeError:
            pass
        except BaseException as error:
            _send(out, {"ended": _sentence(error, source, reader.__module__.partition(".")[0])})


def _check_unpacked(source: Path, limits: Limits) -> None:
    """Raise `StudyError`, the limit's name, where HDF5, also in a folder, would fill more memory than is allowed."""
    files = [each for each in ([source] if source.is_file() else source.rglob("*")) if each.is_file()]
    for each in filter(is_signed, files):
        if check_plain(each, ascii(each.name)) > limits.memory:
            raise StudyError("unpacked")


def _hand_over(out: IO[bytes], item: Any, limits: Limits) -> None:
    """Send what a reader yielded, its arrays behind the rest."""
    arrays: list[np.ndarray] = []
    plain = _parted(item, arrays)
    if any(each.ndim and len(each) > limits.rows for each in arrays):
        raise StudyError("rows")
    _send(out, {"item": plain, "arrays": [[each.dtype.str, each.shape] for each in arrays]})
    for array in filter(np.size, arrays):
        out.write(np.ascontiguousarray(array).data.cast("B"))
    out.flush()


def _sentence(error: BaseException, source: Path, package: str) -> str:
    """The sentence of an error, or the name of the limit that it met, perhaps beneath another error."""
    beneath: BaseException | None = error
    while beneath is not None:
        if isinstance(beneath, MemoryError):
            return "memory"
        beneath = beneath.__cause__ or beneath.__context__
    text = " ".join(str(error).split())
    own = isinstance(error, StudyError) or is_answer(error, package)
    return text if own else f"{source.name!a} cannot be read ({type(error).__name__}: {text[:200]})"


def _send(out: IO[bytes], said: Any) -> None:
    text = json.dumps(said).encode()
    out.write(_HEAD.pack(len(text)) + text)


def _parted(item: Any, arrays: list[np.ndarray]) -> Any:
    """The item with a place in `arrays` for each of its arrays."""
    if isinstance(item, np.ndarray):
        arrays.append(item)
        return {_ARRAY: len(arrays) - 1}
    if isinstance(item, dict):
        return {key: _parted(value, arrays) for key, value in item.items()}
    return [_parted(value, arrays) for value in item] if isinstance(item, (list, tuple)) else item


def _whole(item: Any, arrays: list[np.ndarray]) -> Any:
    if isinstance(item, dict):
        found = item.get(_ARRAY)
        return arrays[found] if len(item) == 1 and isinstance(found, int) else {
            key: _whole(value, arrays) for key, value in item.items()}  # fmt: skip
    return [_whole(value, arrays) for value in item] if isinstance(item, list) else item


def _how(code: int) -> str:
    with contextlib.suppress(ValueError):
        return signal.Signals(-code).name
    return f"code {code}"



def is_signed(path: Path) -> bool:
    """Whether a file says that it is HDF5, at its beginning or behind what MATLAB writes there."""
    with open(path, "rb") as file:
        return b"\x89HDF\r\n\x1a\n" in file.read(520)


def _size_of_plain(file: Any, name: str) -> int:
    links: list[tuple[bytes, int]] = []
    size = 0
    try:
        file.id.links.visit(lambda path, link: links.append((path, link.type)), info=True)
    except (OSError, RuntimeError, KeyError, ValueError):
        raise StudyError(f"{name} is no HDF5 file that can be read") from None
    for path, kind in links:
        if kind > h5py.h5l.TYPE_SOFT:
            raise StudyError(f"{name} cannot be read: {path.decode(errors='replace')!a} is a link out of it")
        with contextlib.suppress(OSError, RuntimeError, KeyError, ValueError):  # what is broken cannot be read later
            if kind != h5py.h5l.TYPE_HARD or h5py.h5o.get_info(file.id, path).type != h5py.h5o.TYPE_DATASET:
                continue
            stored = h5py.h5d.open(file.id, path)
            how = stored.get_create_plist()
            if how.get_external_count() or how.get_layout() == h5py.h5d.VIRTUAL:
                raise StudyError(f"{name} cannot be read: the values of {path.decode(errors='replace')!a} lie "
                                 "in other files")
            size += stored.get_space().get_simple_extent_npoints() * stored.get_type().get_size()
    return size


def vet(source: Path) -> Iterator[str]:
    """The digest of an artefact all of which was read, or which is damaged so that it cannot be: a reader."""
    content = source.read_bytes()
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            file.visititems(_read)
    except (MemoryError, StudyError):
        raise
    except Exception:  # whoever reads it here says what is wrong
        pass
    yield disk.digest(content)


def _read(path: str, item: Any) -> None:
    """Read what lies at a path."""
    dict(item.attrs)
    if isinstance(item, h5py.Dataset):
        item[()]


def check_plain(file: Path | io.BytesIO, name: str) -> int:
    """Bytes of all arrays of a file, unpacked; 0 for what cannot be opened, of which others say what is wrong.

    Raises `StudyError`, before anything is read, where parts lie in other files: external storage, virtual datasets,
    links out.
    """
    with contextlib.suppress(OSError), h5py.File(file, "r") as opened:
        return _size_of_plain(opened, name)
    return 0


if __name__ == "__main__":
    _begun_afresh(*json.loads(sys.argv[1]))
