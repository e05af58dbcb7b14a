"""What a process may no longer do once it has confined itself: files, sockets, memory, processor time.

Linux has Landlock for files (5.13 on; since 6.7 also for TCP), seccomp for sockets of all kinds, and limits for memory,
files that are written, and time. Other systems have some of the limits. `confine` takes what there is and says what it
could not; nothing of it can be undone in that process or in those that it starts.

`enter` does so for a process that computes a stage, `enter_alone` for a command in a stranger's study, which loads the
stages' parameters and results itself. Here is also the one list of what every program needs, whatever it computes: what
confined processes may read, and what a stage may without its being an input.
"""

import contextlib
import ctypes
import mimetypes
import os
import platform
import struct
import sys
import sysconfig
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

from pipeline import trust
from pipeline.cache import disk
from pipeline.execution.job import TEMPORARY, Job, Task, named_files
from pipeline.execution.process import get_ready
from pipeline.graph import beneath
from pipeline.home import DISTRIBUTION, engine, face, home, home_of

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

#: Of whoever reads one file: system libraries, time zones, what shows the processor, and devices that hold nothing.
SYSTEM = (
    "/lib", "/lib64", "/usr/lib", "/usr/lib64", "/usr/local/lib", "/nix/store", "/etc/ld.so.cache", "/etc/localtime",
    "/usr/share/zoneinfo", "/proc/cpuinfo", "/proc/meminfo", "/proc/stat", "/proc/self", "/sys/devices/system",
    "/dev/null", "/dev/zero", "/dev/urandom", "/dev/random", *map(str, mimetypes.knownfiles),
)  # fmt: skip
#: Of stages as well, unless it lies in the study: programs, names of users, fonts, limits; no other process.
STAGES = (
    *SYSTEM,
    "/bin", "/sbin", "/usr", "/opt", "/nix", "/proc/sys", "/sys/fs/cgroup", "/sys/kernel/mm", "/etc/fonts",
    "/etc/passwd", "/etc/group", "/etc/nsswitch.conf", "/etc/os-release", "/etc/ld.so.conf", "/etc/ld.so.conf.d",
    "/etc/alternatives", "/var/cache/fontconfig", "~/.fonts", "~/.local/share/fonts", "~/.cache/fontconfig",
    "~/.cache/matplotlib", "~/.config/matplotlib", "~/.matplotlib", "/System",
    "/Library", "~/Library/Fonts", "~/Library/Caches",
    "~/AppData", os.environ.get("SYSTEMROOT", "/usr"),
)  # fmt: skip
#: Variables that name folders of libraries, wherever these lie.
_NAMED = ("MPLCONFIGDIR", "PYTHONPYCACHEPREFIX", "LOCALAPPDATA")
#: Where processes that are forked share locks.
SHARED = "/dev/shm"

#: What is confined.
FILES, SOCKETS, MEMORY, TIME = "files", "sockets", "memory", "time"
_LIMIT = "limit of the system"
_OF_SQLITE = ("-journal", "-wal", "-shm")
#: How each of these holds in this process, once it is confined.
held: dict[str, str] = {}


def beside(source: Path) -> list[Path]:
    """What may lie beside a file, should it be a database."""
    return [each.parent / f"{each.name}{ending}" for each in (source, source.resolve()) for ending in _OF_SQLITE]


def landlock() -> int:
    """The version of Landlock that this system has; 0 for none."""
    return max(0, _call(_CREATE, None, 0, 1)) if sys.platform == "linux" else 0


def confine(
    reads: Iterable[Path | str], writes: Iterable[Path | str], lists: Iterable[Path | str] = (), *,
    memory: int = 0, seconds: float = 0, written: int | None = None, runs: bool = False, signals: bool = False,
) -> None:  # fmt: skip
    """Let this process read and write beneath these paths alone, and see names of files beneath `lists`; it opens no
    socket, starts programs only if it `runs` them, and sends `signals` to what it starts alone. `held` shows how far it
    is kept.

    `memory` [bytes] comes on top of what it has, `written` is the largest file; 0 or None sets no limit.
    """
    held.clear()
    if sys.platform == "linux":
        _prctl(_SET_NO_NEW_PRIVILEGES, 1)
        version = landlock()
        if version and _restricted(version, runs, signals, reads, writes, lists):
            held[FILES] = f"Landlock {version}"
        if _without_sockets():
            held[SOCKETS] = "seccomp"
        elif FILES in held and version >= 4:
            held[SOCKETS] = "Landlock, TCP alone"
    if os.name == "posix":
        _limit(memory, seconds, written)


def _restricted(version: int, runs: bool, signals: bool, *allowed: Iterable[Path | str]) -> bool:
    reads, writes, lists = allowed
    files, ports, outside = ((1 << bits) - 1 for bits in _KINDS[min(version, max(_KINDS))])
    outside &= ~_SIGNALS if signals else outside
    rules = struct.pack("QQQ", files, ports, outside)[: 8 if version < 4 else 16 if version < 6 else 24]
    ruleset = _call(_CREATE, rules, len(rules), 0)
    if ruleset < 0:
        return False
    read, change = _EXECUTE * runs | _READ | _LIST, _CHANGES | _READ | _LIST
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

    On Linux only; elsewhere a stopped process waits for the signal to continue.
    """
    if sys.platform == "linux":
        with contextlib.suppress(OSError, AttributeError):
            _prctl(_SET_DEATH_SIGNAL, number)


def _prctl(*arguments: Any) -> int:
    return int(_libc().prctl(*arguments, *[0] * (5 - len(arguments))))


def _libc() -> Any:
    return ctypes.CDLL(None, use_errno=True)


def of_python() -> set[Path]:
    """Folders with Python and its packages."""
    path = {Path(part) for part in sys.path if part.endswith("-packages") or Path(part, "numpy").is_dir()}
    return {Path(sys.prefix), Path(sys.base_prefix), *path}


def of_stages(*homes: Path | str) -> list[Path]:
    """Folders with this program, packages wherever they lie but not above `homes`, and what libraries keep."""
    named = (os.environ[name] for name in _NAMED if os.environ.get(name))
    own = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache", "matplotlib").expanduser()
    packages = [Path(part) for part in (*sys.path, *sysconfig.get_paths().values()) if part
                and not any(Path(home).is_relative_to(part) for home in (engine(), *homes))]  # fmt: skip
    about = engine().glob(f"{DISTRIBUTION}*-info")  # beside this program, which who looks for plug-ins reads
    return [*of_python(), *packages, engine() / "pipeline", *about, machine_code(), own, *map(Path, named)]


def of_code(place: Path, package: str) -> list[Path]:
    """A package of stages in `place`, and the branch that this is on, which distinguishes users of machine code."""
    return [place / package, place / ".git" / "HEAD"]


def machine_code() -> Path:
    """The folder in which stages leave machine code: they say the same."""
    if os.environ.get("NUMBA_CACHE_DIR"):
        return Path(os.environ["NUMBA_CACHE_DIR"]).absolute() / DISTRIBUTION
    wished = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache")
    return (wished if wished.is_absolute() else Path("~/.cache")).expanduser() / DISTRIBUTION / "machine_code"


def enter(job: Job, folder: Path, tasks: Sequence[Task]) -> None:
    """Let this process read what dvc.yaml lists for these tasks, the stages' code and what every program needs, and
    write into `folder` and where machine code is kept. It opens no socket. It can never do more again.

    Code that is not this program's own keeps its machine code apart, as loading that runs it.
    """
    place = home_of(job.package, Path(job.code_root))
    own = _own(place, folder / TEMPORARY, any("/machine_code/" in file for file in job.code))
    reads = [*of_code(place, job.package), *_needed(place, job.root), *_inputs(job, tasks)]
    confine(reads, [folder, *own], [place, engine()], runs=True)


def enter_alone(root: Path, results: Path, package: str) -> None:
    """Keep this command, and what it starts from now on, to a stranger's study, its results and what was typed."""
    words = [word.partition("=")[2] if word.startswith("--") and "=" in word else word for word in sys.argv[1:]]
    kept = results / ".cache"
    writes = [root, results, kept, *(Path(into) for word, into in pairwise(sys.argv) if word == "--results")]
    for folder in writes:
        folder.mkdir(parents=True, exist_ok=True)
    own = _own(root, kept / TEMPORARY, True)
    get_ready()  # a process that runs none of the study's code
    program = [trust.place(), engine() / package, face(),
               *(home() / part for part in ("dvc.yaml", "params", "requirements")),
               *(engine() / ".git" / part for part in ("HEAD", "refs", "packed-refs"))]  # fmt: skip
    confine([*map(Path, words), *program, *_needed(root)], [*writes, *own], [engine()], runs=True, signals=True)
    if FILES not in held:
        print(f"note: without Landlock what lies in {root} can read and change all that you can", file=sys.stderr)


def _own(place: Path, temporary: Path, compiles: bool) -> list[Path]:
    """Folders of this program that code in `place` may write, the temporary one and that of machine code."""
    temporary.mkdir(exist_ok=True)  # a killed run's folder may be swept away by now, and is not made again
    os.environ["TMPDIR"], tempfile.tempdir = str(temporary), None
    if not compiles:
        return [temporary, Path(SHARED)]
    kept = machine_code()
    if place != engine() and not kept.parent.name.startswith("of-"):
        kept /= f"of-{disk.digest(str(place).encode())[:24]}"
        os.environ["NUMBA_CACHE_DIR"] = str(kept)
        kept /= DISTRIBUTION
    for folder in (*reversed(kept.parents), kept):
        if not folder.exists():
            folder.mkdir(mode=0o700, exist_ok=True)
    return [temporary, Path(SHARED), kept]


def _needed(*homes: Path | str) -> list[Path]:
    return [*of_stages(*homes), *(Path(each).expanduser() for each in STAGES)]


def _inputs(job: Job, tasks: Sequence[Task]) -> Iterator[Path]:
    named = set() if job.function else named_files(tasks)
    for place in {*(place for place, _ in job.files.values() if place), *named}:
        yield from (Path(place), *beside(Path(place)))
    for path in (path for stage in job.stages for path in stage.inputs if path not in job.files):
        for first in beneath(path, job.files)[:1]:
            inside = len(Path(first).parts) - len(Path(path).parts)
            yield [Path(job.files[first][0]), *Path(job.files[first][0]).parents][inside]
