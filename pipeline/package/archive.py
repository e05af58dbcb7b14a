"""A package as one ZIP: the same files give the same bytes, and a stranger's is unpacked within bounds."""

from __future__ import annotations

import contextlib
import hashlib
import stat
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from pipeline.cache import disk
from pipeline.errors import StudyError
from pipeline.graph import is_inside
from pipeline.package.crate import File
from pipeline.study import shown

#: What a stranger's package may unpack to at most [bytes, files].
_LARGEST, _MOST = 8_000_000_000, 100_000
_FIRST_DAY = (1980, 1, 1, 0, 0, 0)


def write(path: Path, texts: Mapping[str, bytes], places: Mapping[str, Path], files: Mapping[str, File]) -> None:
    """Put texts and then files, by their names in it, into a ZIP that appears at `path`, whole or not at all.

    Without compression, so that its bytes depend on no library. Raises `StudyError` for a file that has changed.
    """
    with disk.whole(path) as unfinished, zipfile.ZipFile(unfinished, "x", zipfile.ZIP_STORED) as out:
        for name, content in texts.items():
            out.writestr(_entry(name, len(content)), content)
        for name, file in files.items():
            with out.open(_entry(name, file.size), "w") as target:
                found = hashlib.sha256()
                for block in disk.blocks(places[name]):
                    found.update(block)
                    target.write(block)
            if found.hexdigest() != file.sha256:
                raise StudyError(f"{shown(places[name])}: changed while it was packed; try again")


def _entry(name: str, size: int) -> zipfile.ZipInfo:
    found = zipfile.ZipInfo(name, _FIRST_DAY)
    found.create_system, found.external_attr, found.file_size = 3, (stat.S_IFREG | 0o644) << 16, size
    return found


@contextlib.contextmanager
def opened(path: Path) -> Iterator[Path]:
    """A folder, or a temporary one to which the package in a file is unpacked. Raises `StudyError`."""
    if path.is_dir():
        yield path
        return
    disk.check(path, shown(path))
    with tempfile.TemporaryDirectory(prefix="bipedstudy-") as place:
        try:
            with zipfile.ZipFile(path) as package:
                entries = [entry for entry in package.infolist() if not entry.is_dir()]
                if len(entries) > _MOST or sum(entry.file_size for entry in entries) > _LARGEST:
                    raise StudyError(f"{shown(path)}: unpacks to more than {_MOST} files or {_LARGEST} bytes")
                for entry in entries:
                    if not is_inside(entry.filename):
                        raise StudyError(f"{shown(path)}: holds {entry.filename!a}, which would lie outside")
                    package.extract(entry, place)
        except (zipfile.BadZipFile, RuntimeError, NotImplementedError, EOFError, ValueError, OSError) as error:
            raise StudyError(f"{shown(path)}: is no package that can be read ({error})") from None
        yield Path(place)
