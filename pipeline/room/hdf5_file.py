"""What an HDF5 file says of itself before anything in it is read: whether all of it lies in it, and its size."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py

from pipeline.cache import disk
from pipeline.errors import ArtefactError, StudyError


def is_signed(path: Path) -> bool:
    """Whether a file says that it is HDF5, at its beginning or behind what MATLAB writes there."""
    with open(path, "rb") as file:
        return b"\x89HDF\r\n\x1a\n" in file.read(520)


def size_of_plain(file: Any, name: str) -> int:
    """Bytes of all arrays of an open file, unpacked. Raises `ArtefactError`, before anything is read, where parts lie
    in other files: external storage, virtual datasets, links out.
    """
    links: list[tuple[bytes, int]] = []
    size = 0
    try:
        file.id.links.visit(lambda path, link: links.append((path, link.type)), info=True)
    except (OSError, RuntimeError, KeyError, ValueError):
        raise ArtefactError(f"{name} is no HDF5 file that can be read") from None
    for path, kind in links:
        if kind > h5py.h5l.TYPE_SOFT:
            raise ArtefactError(f"{name} cannot be read: {path.decode(errors='replace')!a} is a link out of it")
        with contextlib.suppress(OSError, RuntimeError, KeyError, ValueError):  # what is broken cannot be read later
            if kind != h5py.h5l.TYPE_HARD or h5py.h5o.get_info(file.id, path).type != h5py.h5o.TYPE_DATASET:
                continue
            stored = h5py.h5d.open(file.id, path)
            how = stored.get_create_plist()
            if how.get_external_count() or how.get_layout() == h5py.h5d.VIRTUAL:
                raise ArtefactError(f"{name} cannot be read: the values of {path.decode(errors='replace')!a} lie "
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
    """As `size_of_plain`; 0 for what cannot be opened, of which others say what is wrong."""
    with contextlib.suppress(OSError), h5py.File(file, "r") as opened:
        return size_of_plain(opened, name)
    return 0
