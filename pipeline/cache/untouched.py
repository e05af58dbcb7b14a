"""How all lay on the disk when a run found everything current, so that the next run need not look into any file.

While each file has the size, the times and the inode that it had, nothing was changed. A file's time of change is the
system's own and cannot be set, so an edit shows that keeps the text's time. What changed shortly before it was looked
at may change again within the same tick of the clock, and is not relied upon.
"""

import contextlib
import json
import os
import sys
import time
from collections.abc import Iterable, Iterator
from typing import Any

from pipeline.cache import bounds, disk
from pipeline.graph import FILE_NAME, REPORT
from pipeline.home import engine
from pipeline.study import Study

_NAME = "untouched.json"
_IN_DOUBT_NS = 2_000_000_000
#: Path, inode, size, and the times of its text and of its last change.
_Stamp = tuple[str, int, int, int, int]
#: Whether a file's time of change is known; on Windows that place holds the time it was made.
HERE = os.name == "posix"


#: Files that results rest on beside the study's own, and a digest of how they and those lay.
Lay = tuple[list[str], str]


def look(study: Study) -> Lay | None:
    """How all lies now; None where results are missing or rest on files from outside."""
    places = [study.results / REPORT]
    for name in study.graph.usual:
        entry = study.store.current(name)
        if entry is None or not all(path.startswith("results/") for path in entry.ingredients["inputs"]):
            return None
        places += [*study.store.vouchers(entry), *map(study.store.place, entry.outs)]
    named = [str(place) for place in places]
    found = _digest(study, named)
    return (named, found) if found else None


def recall(study: Study) -> dict[str, str]:
    """The summary of each stage if all lies as it did when it was noted to be current; else nothing."""
    noted: Any = disk.read_sealed(study.store.folder / _NAME) if HERE else None
    with contextlib.suppress(TypeError, KeyError):
        if noted["digest"] == _digest(study, noted["places"]):
            return dict(noted["summaries"])
    return {}


def note(study: Study, lay: Lay | None, summaries: dict[str, str]) -> None:
    """Note that all was current as it lay before it was looked into; where nothing can be written that costs time."""
    if HERE and lay is not None:
        with contextlib.suppress(OSError):
            disk.write_sealed(study.store.folder / _NAME,
                              {"places": lay[0], "digest": lay[1], "summaries": [*summaries.items()]})  # fmt: skip


def _digest(study: Study, places: Iterable[str]) -> str | None:
    """Of what is asked and all stamps: of the study, the program, `places` and packages; None if in doubt."""
    began = time.time_ns()
    stamps: list[_Stamp] = []
    try:
        own = (str(study.root / name) for name in (FILE_NAME, bounds.FILE_NAME))
        for place in (*own, *places, *(folder or "." for folder in sys.path)):
            stamps += [_stamp(place)] if os.path.exists(place) else [(place, 0, 0, 0, 0)]  # noqa: PTH110 - each run
        for top in (study.params, study.code_root / study.package, engine() / "pipeline"):
            stamps += _beneath(str(top))
    except OSError:
        return None
    if max(max(written, changed) for *_, written, changed in stamps) > began - _IN_DOUBT_NS:
        return None
    return disk.digest(json.dumps([sys.version, study.settings, study.requested, stamps]).encode())


def _beneath(folder: str) -> Iterator[_Stamp]:
    """Stamps of a folder and of all that lies in it."""
    yield _stamp(folder)
    with os.scandir(folder) as entries:
        found = sorted((entry.path, entry.is_dir()) for entry in entries if entry.name != "__pycache__")
    for path, is_folder in found:
        yield from _beneath(path) if is_folder else (_stamp(path),)


def _stamp(path: str) -> _Stamp:
    found = os.stat(path)  # noqa: PTH116 - a thousand times in every run
    return path, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns
