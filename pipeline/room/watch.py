"""Which files a stage reads while it runs, held against what it may: an input that dvc.yaml does not list is reported.

Python reports what `open` and `sqlite3` open, in this process and in those that it forks, and `h5py.File` is made to.
What a library opens by itself, and what a program or process begun afresh opens, is not seen. A stage that asks the
network is reported as well.
"""

from __future__ import annotations

import contextlib
import os
import socket
import sys
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import h5py

from pipeline.errors import StudyError
from pipeline.room.confine import STAGES, of_stages

_SHOWN = 3
_NETWORK = b"network:"  # no path
_ASKING = ("socket.getaddrinfo", "socket.gethostbyname", "socket.connect", "socket.sendto")
_watched: Watch | None = None


class Watch:
    """What a stage reads, beneath `root` or elsewhere, that is not beneath `allowed`."""

    def __init__(self, root: str, allowed: Iterable[Path | str]) -> None:
        self._allowed = _places([*of_stages(root), *(Path(each) for each in allowed)])
        self._root, self._of_all = _places([root])[0], _places([*STAGES, "/proc"])
        self._log = tempfile.TemporaryFile("a+b")  # noqa: SIM115 - `seen` closes it; forked processes write to it too
        self._known = set[str]()
        self.wished = False  # a socket for the network, which may have been refused

    def see(self, opened: Any) -> None:
        """Keep the path of a file that is opened, unless it may be, or is not there."""
        with contextlib.suppress(OSError, TypeError, ValueError):
            path = os.path.realpath(os.fsdecode(opened))
            if path in self._known:
                return
            self._known.add(path)
            if path.startswith(self._allowed) or (path.startswith(self._of_all) and not path.startswith(self._root)):
                return
            if Path(path).is_file():
                os.write(self._log.fileno(), path.encode(errors="surrogateescape") + b"\0")

    def ask(self) -> None:
        """Keep that the network was asked."""
        os.write(self._log.fileno(), _NETWORK + b"\0")

    def seen(self) -> list[str]:
        """The files, from the study's folder where they lie in it."""
        with self._log as log:
            log.seek(0)
            found = log.read().decode(errors="surrogateescape").split("\0")[:-1]
        return [path.removeprefix(self._root) for path in dict.fromkeys(found)]


@contextlib.contextmanager
def watched(root: str, *allowed: Path | str) -> Iterator[None]:
    """Within it a stage runs. Raises `StudyError` if it read a file that it may not or asked the network, however it
    ended.
    """
    global _watched
    _hear()
    _watched = watch = Watch(root, allowed)
    try:
        yield
    except PermissionError:
        if watch.wished:
            watch.ask()
        raise
    finally:
        _watched = None
        seen = watch.seen()
        if _NETWORK.decode() in seen:
            raise StudyError("it asked the network, which no stage may: dvc.yaml lists nothing that comes from there")
        if seen:
            more = f" and {len(seen) - _SHOWN} more" if len(seen) > _SHOWN else ""
            raise StudyError(f"it read {', '.join(seen[:_SHOWN])}{more}, which dvc.yaml does not list among "
                             "its deps, so that after an edit of it the result would stay as it is")  # fmt: skip


def _places(paths: Iterable[Path | str]) -> tuple[str, ...]:
    """Beginnings of what lies beneath these paths, and the paths themselves where they are files."""
    real = [os.path.realpath(Path(path).expanduser()) for path in paths]
    return tuple(path if Path(path).is_file() else path.rstrip(os.sep) + os.sep for path in real)


def _hear() -> None:
    """Let this process report what it opens, once; a hook cannot be taken away."""
    if getattr(h5py.File, "tells", False):
        return
    begin = h5py.File.__init__

    def log(self: Any, name: Any, *arguments: Any, **keywords: Any) -> None:
        if _watched is not None:
            _watched.see(name)
        begin(self, name, *arguments, **keywords)

    h5py.File.__init__, h5py.File.tells = log, True
    sys.addaudithook(_audited)


def _audited(event: str, arguments: tuple[Any, ...]) -> None:
    if _watched is None or event not in ("open", "sqlite3.connect", "socket.__new__", *_ASKING):
        return
    if event == "socket.__new__":
        _watched.wished |= arguments[1] in (socket.AF_INET, socket.AF_INET6)
        return
    if event in _ASKING:
        if not isinstance(arguments[-1], (str, bytes)) or event == "socket.gethostbyname":  # else a local one's path
            _watched.ask()
        return
    name, written = arguments[0], event == "open" and arguments[2] & (os.O_WRONLY | os.O_RDWR) == os.O_WRONLY
    name = os.fsdecode(name) if isinstance(name, bytes) else name  # as Python 3.10 hands on what sqlite3 opens
    if isinstance(name, str) and name.startswith("file:"):
        import urllib.parse

        name = urllib.parse.unquote(name.removeprefix("file:").partition("?")[0])
    if isinstance(name, (str, bytes, os.PathLike)) and not written:
        _watched.see(name)
