"""Where what is made of sources is kept on disk, machine code and derived equations: in a folder of the user's own.

Loading machine code runs it, and the file that it is kept in is a pickle, which runs too, as does the text of derived
equations. So it is read only where nobody else could have put it: a folder of this user's that others cannot write, nor
rename or replace from above. If there is none, nothing is kept. Numba alone would fall back to the shared temporary
folder.

Numba knows code to be old by the path and time of its own file, not by the files of the functions it calls. Here the
stamp is a digest of whole folders of sources: any edit of them compiles afresh, undoing it does not, and a copy of the
sources elsewhere finds the code again.
"""

import contextlib
import hashlib
import os
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import cache
from importlib import metadata
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])
PROGRAM = "bipedstudy"
#: Folders that are kept of one name, the newest: as many edits can be undone without compiling.
KEPT = 4
#: Folders used so short a time ago are left alone [s].
IN_USE_S = 3600.0
#: Folders that hold no compiled code: what is asked and drawn may change without compiling anew.
NOT_COMPILED = ("design", "maps", "pictures", "questions")
#: Machine code that a wheel brings, made for any processor of its platform (`make wheel`); a checkout has none.
SHIPPED = Path(__file__).parent / "shipped"
_DIGITS = 24
_USER = "used-by-"
_OTHERS = stat.S_IWGRP | stat.S_IWOTH


def home() -> Path:
    """The user's folder for machine code: in NUMBA_CACHE_DIR, or where the system keeps caches. It need not exist."""
    if os.environ.get("NUMBA_CACHE_DIR"):
        return Path(os.environ["NUMBA_CACHE_DIR"]).absolute() / PROGRAM
    known = {"win32": "~/AppData/Local", "darwin": "~/Library/Caches"}.get(sys.platform, "~/.cache")
    wished = Path(os.environ.get("LOCALAPPDATA" if sys.platform == "win32" else "XDG_CACHE_HOME") or known)
    base = wished if wished.is_absolute() else Path(os.path.expanduser(known))  # noqa: PTH111 - it never raises
    return base / PROGRAM / "machine_code"


def refusal(folder: Path) -> str:
    """Why machine code in this folder could be somebody else's, or nothing. It is made, for this user only, if missing.

    On Windows a user's folders are the user's by their access lists, which are not looked at.
    """
    try:
        if not folder.is_absolute():  # a home that is not known
            return f"{folder} is no place"
        _make(folder)
        with tempfile.TemporaryFile(dir=folder):
            pass
        if os.name != "posix":
            return ""
        real = folder.resolve()
        for place in (real, *real.parents):
            found = place.stat()
            if found.st_uid not in ((os.geteuid(),) if place == real else (os.geteuid(), 0)):
                return f"{place} belongs to somebody else"
            if found.st_mode & _OTHERS and (place == real or not found.st_mode & stat.S_ISVTX) and not _is_alone(found):
                return f"others may write in {place}"
    except (OSError, RuntimeError) as error:
        return f"{folder} cannot be written ({getattr(error, 'strerror', error)})"
    return ""


def _make(folder: Path) -> None:
    for place in (*reversed(folder.parents), folder):
        if not place.exists():
            place.mkdir(mode=0o700, exist_ok=True)


def _is_alone(found: os.stat_result) -> bool:
    """Whether only the group may write, and the owner is alone in it: many systems give each user such a group."""
    import grp
    import pwd

    with contextlib.suppress(KeyError):
        group, owner = grp.getgrgid(found.st_gid), pwd.getpwuid(found.st_uid)
        return not found.st_mode & stat.S_IWOTH and group.gr_name == owner.pw_name and not group.gr_mem
    return False


@cache
def sympy_version() -> str:
    """The version of sympy; where there is none, which is said, that of the equations that came with the package."""
    try:
        return metadata.version("sympy")
    except metadata.PackageNotFoundError:
        brought = next(SHIPPED.glob("equations-*"), None)
        if brought is not None:
            print("note: sympy is not installed: the equations of motion are those that came with this package",
                  file=sys.stderr)  # fmt: skip
        return brought.name.split("-")[1] if brought else ""


class Kept:
    """What is made of the sources in some folders `by` packages of some versions, kept under `name`.

    `shipped` is a folder that only reads serve: what came with the package and is vouched for as its sources are; by
    default the one in `SHIPPED` that was made of the same sources.
    """

    def __init__(self, name: str, *sources: Path, by: str, shipped: Path | None = None) -> None:
        self.name, self.stamp = name, digest(by, *sources)
        self.folder = home() / f"{name}-{self.stamp[:_DIGITS]}"
        brought = SHIPPED / self.folder.name
        self.shipped = shipped or (brought if brought.is_dir() else None)
        self.refusal = refusal(home())
        if not self.refusal and self.folder.exists():
            self.refusal = refusal(self.folder)
            with contextlib.suppress(OSError):
                self._use()

    def places(self) -> list[Path]:
        """The folders to read from."""
        return [*([self.shipped] if self.shipped else []), *([] if self.refusal else [self.folder])]

    def text(self, file: str, make: Callable[[], str]) -> str:
        """The text in a file, which a digest at its end seals. Where it is missing or damaged it is made, and left."""
        for place in self.places():
            with contextlib.suppress(OSError, UnicodeDecodeError):
                content = (place / file).read_text(encoding="utf-8")
                if content == sealed(content.rpartition("# ")[0]):
                    return content
        content = sealed(make())
        self.leave(file, content.encode())
        return content

    def leave(self, file: str, content: bytes) -> None:
        """Leave a whole file, or none where there is no room: what was made serves all the same. Whoever leaves the
        same just now leaves as good a one.
        """
        if not self.refusal:
            with contextlib.suppress(OSError):
                self._leave(file, content)

    def _leave(self, file: str, content: bytes) -> None:
        self.begin()
        unfinished = self.folder / f"{file}.{os.getpid()}.tmp"
        try:
            unfinished.write_bytes(content)
            unfinished.replace(self.folder / file)
        finally:
            unfinished.unlink(missing_ok=True)

    def begin(self) -> None:
        """Make the folder, and remove old ones of its name but those that another checkout may be using."""
        if not self.folder.is_dir():
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._use()
            for folder in self.old(KEPT, self.name):
                with contextlib.suppress(OSError):
                    if time.time() - folder.stat().st_mtime > IN_USE_S:
                        shutil.rmtree(folder, ignore_errors=True)

    def _use(self) -> None:
        """Note in the folder who uses it, and that it is used now: the newest are those used last."""
        (self.folder / _user()).touch()
        os.utime(self.folder)

    def old(self, keep: int, name: str = "*", own: bool = False) -> list[Path]:
        """Folders of one name, or of all, but the `keep` of each that were used last; if `own`, of those that nobody
        else uses.
        """
        by_name: dict[str, list[tuple[float, Path]]] = {}
        for path in home().glob(f"{name}-{'?' * _DIGITS}"):
            if own and [each.name for each in path.glob(f"{_USER}*")] != [_user()]:
                continue
            with contextlib.suppress(OSError):
                by_name.setdefault(path.name[:-_DIGITS], []).append((path.stat().st_mtime, path))
        return [path for found in by_name.values() for _, path in sorted(found, reverse=True)[keep:]]


class MachineCode(Kept):
    """The machine code of the sources in some folders, kept under `name`, by this Python and this numba. Some derive
    equations: sympy's part in it.
    """

    def __init__(self, name: str, *sources: Path, shipped: Path | None = None) -> None:
        by = f"{sys.implementation.cache_tag} {numba.__version__} {sympy_version()}"
        super().__init__(name, *sources, by=by, shipped=shipped)

    def compiled(self, function: F, **options: Any) -> F:
        """The function as machine code that is loaded from here, and left here. `options` are numba's.

        A numba whose caches are made of other parts keeps it by itself, in this folder.
        """
        made: Any = numba.njit(**options)(function)
        try:
            from stages.biped.machine_code import numba_cache

            if self.shipped or not self.refusal:
                numba_cache.attach(made, self)
        except (ImportError, AttributeError, TypeError):
            if not self.refusal:
                self.begin()
                with _numba_keeps_in(self.folder), contextlib.suppress(RuntimeError):  # of text without a file
                    made.enable_caching()
        return cast(F, made)

    def is_cold(self) -> bool:
        """Whether nothing is compiled yet of these sources."""
        return not any(next(place.rglob("*.nbc"), None) for place in self.places())


@contextlib.contextmanager
def _numba_keeps_in(folder: Path) -> Iterator[None]:
    """What numba begins to keep by itself meanwhile lies in a folder."""
    settings: Any = numba.config
    before, settings.CACHE_DIR = settings.CACHE_DIR, str(folder)
    try:
        yield
    finally:
        settings.CACHE_DIR = before


@cache
def _user() -> str:
    """The file by which a user of machine code is known: a checkout, the branch it is on, and an environment."""
    root, head = Path(__file__).parents[3], ""
    with contextlib.suppress(OSError):
        head = (root / ".git" / "HEAD").read_text(encoding="utf-8")
    return _USER + digest(f"{root}\0{head}\0{sys.prefix}")[:_DIGITS]


def folder_of(module: ModuleType) -> Path:
    """The folder that a module's source lies in."""
    return Path(str(module.__file__)).parent


def sealed(text: str) -> str:
    """A text with its digest as the last line."""
    return f"{text}# {hashlib.sha256(text.encode()).hexdigest()}\n"


def digest(by: str, *sources: Path) -> str:
    """SHA-256 over `by` and the source files in these folders but `NOT_COMPILED`, with their names."""
    found = hashlib.sha256(by.encode())
    for folder in sources:
        for source in sorted(folder.rglob("*.py")):
            if source.parent.name in NOT_COMPILED:
                continue
            text = source.read_bytes()
            found.update(f"\0{folder.name}/{source.relative_to(folder).as_posix()}\0{len(text)}\0".encode() + text)
    return found.hexdigest()
