"""What a process may no longer do once it has confined itself: files, sockets, memory, processor time.

Linux has Landlock for files (5.13 on; since 6.7 also for TCP), seccomp for sockets of all kinds, and limits for memory,
files that are written, and time. Other systems have some of the limits. `confine` takes what there is and says what it
could not; nothing of it can be undone in that process or in those that it starts.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import platform
import struct
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

from pipeline.room.needed import SYSTEM, of_python

_CREATE, _ADD, _RESTRICT = 444, 445, 446  # Landlock's system calls, the same on every processor
_EXECUTE, _WRITE, _READ, _LIST = 1, 2, 4, 8
_TRUNCATE = 1 << 14
_OF_FILES = _EXECUTE | _WRITE | _READ | _TRUNCATE
_CHANGES = sum(1 << bit for bit in (1, 4, 5, 7, 8, 12, 13, 14))  # write, remove, folders, files, links, move, truncate
#: By version: kinds of access to files, to TCP ports, and of signals and sockets outside that are handled.
_KINDS = {1: (13, 0, 0), 2: (14, 0, 0), 3: (15, 0, 0), 4: (15, 2, 0), 5: (16, 2, 0), 6: (16, 2, 2)}
_SIGNALS = 2
_SET_DEATH_SIGNAL, _SET_SECCOMP, _SET_NO_NEW_PRIVILEGES = 1, 22, 38
_FILTER, _ALLOW = 2, 0x7FFF0000
_IGNORE = 0x00050000  # the call says that it has been done
_REFUSE = _IGNORE | 13  # EACCES
#: Of each kind of processor its number in filters, then what opens sockets or reaches into another process: socket,
#: io_uring_setup, ptrace, process_vm_readv, process_vm_writev; then what changes owners, rights and attributes of any
#: file, of which Landlock knows nothing: programs that copy a file do it too, and are none the worse without.
_CALLS = {
    "x86_64": (0xC000003E, (41, 425, 101, 310, 311), (*range(90, 95), *range(188, 191), *range(197, 200), 260, 268, 452,
                                                      463, 466)),
    "aarch64": (0xC00000B7, (198, 425, 117, 270, 271), (*range(5, 8), *range(14, 17), *range(52, 56), 452, 463, 466)),
}  # fmt: skip
_X32 = 0x40000000

#: What is confined.
FILES, SOCKETS, MEMORY, TIME = "files", "sockets", "memory", "time"
_LIMIT = "limit of the system"
#: How each of these holds in this process, once it is confined.
held: dict[str, str] = {}


def landlock() -> int:
    """The version of Landlock that this system has; 0 for none."""
    return max(0, _call(_CREATE, None, 0, 1)) if sys.platform == "linux" else 0


def confine(
    reads: Iterable[Path | str], writes: Iterable[Path | str] = (), lists: Iterable[Path | str] = (), *,
    memory: int = 0, seconds: float = 0, written: int | None = None, signals: bool = False,
) -> None:  # fmt: skip
    """Let this process read and write beneath these paths alone, and see names of files beneath `lists`; it opens no
    socket, and sends `signals` to what it starts alone. `held` tells how far it is kept.

    `memory` [bytes] comes on top of what it has, `written` is the largest file; 0 or None sets no limit.
    """
    held.clear()
    if sys.platform == "linux":
        _prctl(_SET_NO_NEW_PRIVILEGES, 1)
        version = landlock()
        if version and _restricted(version, signals, reads, writes, lists):
            held[FILES] = f"Landlock {version}"
        if _without_sockets():
            held[SOCKETS] = "seccomp"
        elif FILES in held and version >= 4:
            held[SOCKETS] = "Landlock, TCP alone"
    if os.name == "posix":
        _limit(memory, seconds, written)


def _restricted(version: int, signals: bool, *allowed: Iterable[Path | str]) -> bool:
    reads, writes, lists = allowed
    files, ports, outside = ((1 << bits) - 1 for bits in _KINDS[min(version, max(_KINDS))])
    outside &= ~_SIGNALS if signals else outside
    rules = struct.pack("QQQ", files, ports, outside)[: 8 if version < 4 else 16 if version < 6 else 24]
    ruleset = _call(_CREATE, rules, len(rules), 0)
    if ruleset < 0:
        return False
    read, change = _EXECUTE | _READ | _LIST, _CHANGES | _READ | _LIST
    for may, paths in ((read, (*SYSTEM, *of_python(), *reads)), (change, (*writes, os.devnull)), (_LIST, lists)):
        for path in {Path(each) for each in paths}:
            with contextlib.suppress(OSError):  # what is not there cannot be read either
                place = os.open(path, os.O_PATH | os.O_CLOEXEC)
                kinds = may if path.is_dir() else may & _OF_FILES
                _call(_ADD, ruleset, 1, struct.pack("=Qi", kinds & files, place), 0)
                os.close(place)
    done = _call(_RESTRICT, ruleset, 0)
    os.close(ruleset)
    return done == 0


def _without_sockets() -> bool:
    number, refused, ignored = _CALLS.get(platform.machine(), (0, (), ()))
    if not number or sys.maxsize < 2**32:
        return False
    # Each step: code, how many steps to leap where it holds and where it does not, value.
    steps = [(0x20, 0, 0, 4), (0x15, 1, 0, number), (0x06, 0, 0, _REFUSE), (0x20, 0, 0, 0), (0x35, 0, 1, _X32),
             (0x06, 0, 0, _REFUSE)]  # fmt: skip
    steps += [step for calls, how in ((refused, _REFUSE), (ignored, _IGNORE)) for call in calls
              for step in ((0x15, 0, 1, call), (0x06, 0, 0, how))]  # fmt: skip
    steps += [(0x06, 0, 0, _ALLOW)]
    code = ctypes.create_string_buffer(b"".join(struct.pack("HBBI", *step) for step in steps))
    program = struct.pack("HxxxxxxP", len(steps), ctypes.addressof(code))
    return _prctl(_SET_SECCOMP, _FILTER, program) == 0


def _limit(memory: int, seconds: float, written: int | None) -> None:
    """Set limits; on macOS that of memory does nothing."""
    import resource

    def limit(what: str, least: int, beyond: int = 0) -> bool:
        with contextlib.suppress(OSError, ValueError, AttributeError):
            number = getattr(resource, what)
            hard = resource.getrlimit(number)[1]
            most = min(least, hard) if hard != resource.RLIM_INFINITY else least
            resource.setrlimit(number, (most, most + beyond if hard == resource.RLIM_INFINITY else hard))
            return True
        return False

    if written is not None:
        limit("RLIMIT_FSIZE", written)
    limit("RLIMIT_CORE", 0)
    if memory and sys.platform == "linux" and limit("RLIMIT_DATA", _data() + memory):
        held[MEMORY] = _LIMIT
    if seconds and limit("RLIMIT_CPU", max(1, round(seconds)), 1):
        held[TIME] = _LIMIT


def _data() -> int:
    """Bytes of this process's own memory, or that it has had, where it is confined already."""
    import resource

    with contextlib.suppress(PermissionError), open("/proc/self/statm", "rb") as file:
        return int(file.read().split()[5]) * os.sysconf("SC_PAGE_SIZE")
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def tried(source: Path) -> Iterator[dict[str, str]]:
    """What is `held`, files and sockets only if this process is indeed kept from them: a reader.

    Beside `source` there must be a file "beside".
    """
    import socket

    attempts: dict[str, Callable[[], Any]] = {
        FILES: partial(open, source.with_name("beside"), "rb"), SOCKETS: socket.socket}
    for what, attempt in attempts.items():
        with contextlib.suppress(PermissionError):
            attempt().close()
            held.pop(what, None)
    yield held


def _call(*arguments: Any) -> int:
    return int(_libc().syscall(*arguments))


def when_parent_ends(number: int) -> None:
    """Let this process be sent a signal when its parent ends, should somebody have stopped one of them.

    On Linux only; elsewhere a stopped process waits until it is told to go on.
    """
    if sys.platform == "linux":
        with contextlib.suppress(OSError, AttributeError):
            _prctl(_SET_DEATH_SIGNAL, number)


def _prctl(*arguments: Any) -> int:
    return int(_libc().prctl(*arguments, *[0] * (5 - len(arguments))))


def _libc() -> Any:
    return ctypes.CDLL(None, use_errno=True)
