"""How much of earlier results stays: the newest of each stage, those of some days, those of some size.

What was last put into the results folder is current and always stays. An earlier result is as old as the time since
another took its place. A study's file cache.yaml holds bounds after each run; without it all stay until `clean`.
"""

import re
import shutil
import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from operator import attrgetter
from pathlib import Path

from pipeline.cache.store import Store
from pipeline.errors import StudyError, nearest
from pipeline.parameters import yaml_text

FILE_NAME = "cache.yaml"
SIZES = {"B": 1.0, "kB": 1e3, "MB": 1e6, "GB": 1e9, "TB": 1e12}
TIMES = {"min": 60.0, "h": 3600.0, "d": 86400.0, "w": 604800.0}


@dataclass(frozen=True)
class Bounds:
    """Results of each stage that stay, the current one among them; age [s] and size of all of them [bytes]."""

    keep: int | None = None
    older_than: float | None = None
    max_size: float | None = None

    def __bool__(self) -> bool:
        return self != Bounds()


@dataclass(frozen=True)
class Stored:
    """A result in the cache: its folder, its stage (None where it is damaged), whether it is current; age and size."""

    folder: Path
    stage: str | None
    current: bool
    seconds: float
    size: int

    @property
    def what(self) -> str:
        """What to call it."""
        return f"an earlier result of {self.stage}" if self.stage else "a damaged result"


def bounds_of(texts: Mapping[str, object]) -> Bounds:
    """Bounds from words like 3, 30d and 500MB. Raises ValueError with the key and what is allowed."""
    keep, older, size = (texts.get(field.name) for field in fields(Bounds))
    if keep is not None and (not isinstance(keep, int) or isinstance(keep, bool) or keep < 1):
        raise ValueError(f"keep = {keep} is not allowed; allowed: a whole number from 1")
    return Bounds(keep, _measured("older_than", older, TIMES), _measured("max_size", size, SIZES))


def _measured(key: str, text: object, units: Mapping[str, float]) -> float | None:
    if text is None:
        return None
    found = re.fullmatch(r"(\d+(?:\.\d*)?) ?([A-Za-z]+)", str(text))
    if found is None or found[2] not in units:
        raise ValueError(f"{key} = {text} is not allowed; allowed: a number and one of {', '.join(units)}, "
                         f"as in {30 if 'd' in units else 500}{[*units][2]}")  # fmt: skip
    return float(found[1]) * units[found[2]]


def read(root: Path) -> Bounds:
    """The bounds of a study's cache.yaml; none without it. Raises `StudyError` for what is not understood in it."""
    if not (root / FILE_NAME).exists():
        return Bounds()
    tree = yaml_text.read(root / FILE_NAME, FILE_NAME)
    keys = [field.name for field in fields(Bounds)]
    if not isinstance(tree.value, dict):
        raise StudyError(f"{FILE_NAME}: expected lines of the form key: value, with the keys {', '.join(keys)}")
    for key, node in tree.value.items():
        if key not in keys:
            raise StudyError(f'{FILE_NAME}:{node.line}: there is no key "{key}" (keys: {", ".join(keys)})'
                             f"{nearest(key, keys)}")  # fmt: skip
    try:
        return bounds_of(tree.plain())
    except ValueError as refused:
        raise StudyError(f"{FILE_NAME}: {refused}") from None


def stored(store: Store) -> list[Stored]:
    """Every result in the cache, the current ones first, then the newest; no link is followed."""
    current, now, found = store.last_keys(), time.time(), []
    for folder in sorted(store.folder.iterdir()) if store.folder.is_dir() else ():
        manifest = folder / "manifest.json"
        if manifest.exists() and not folder.is_symlink():
            entry = store.entry(folder.name)
            found.append(Stored(folder, entry.stage if entry else None, folder.name in current,
                                now - manifest.stat().st_mtime, size_of(folder)))  # fmt: skip
    newest_first = sorted(found, key=attrgetter("seconds"))
    return sorted(newest_first, key=attrgetter("current"), reverse=True)


def beyond(store: Store, bounds: Bounds) -> list[Stored]:
    """The earlier results that are beyond a bound, without any all; and what is damaged."""
    counts, size, found = Counter[str](), 0, []
    for one in stored(store):
        counts[one.stage or ""] += 1
        size += one.size
        kept = one.stage is not None and bounds and (
            (bounds.keep is None or counts[one.stage] <= bounds.keep)
            and (bounds.older_than is None or one.seconds <= bounds.older_than)
            and (bounds.max_size is None or size <= bounds.max_size))  # fmt: skip
        if not (one.current or kept):
            found.append(one)
    return found


def hold(store: Store, bounds: Bounds, say: Callable[[str], None]) -> None:
    """Remove what is beyond the bounds of cache.yaml, and say so. Call it under the lock of the results folder."""
    if not bounds:
        return
    gone = beyond(store, bounds)
    for one in gone:
        shutil.rmtree(one.folder, ignore_errors=True)
    if gone:
        say(f"earlier results of {in_units(sum(one.size for one in gone))} are gone, as {FILE_NAME} has it")
    if bounds.max_size is not None and (left := sum(one.size for one in stored(store))) > bounds.max_size:
        say(f"the current results stay, though they take {in_units(left)}, more than max_size in {FILE_NAME}")


def size_of(place: Path) -> int:
    """Bytes of a file, or of all files in a folder; links are not followed."""
    paths = place.rglob("*") if place.is_dir() else (place,)
    return sum(path.lstat().st_size for path in paths if not path.is_dir())


def in_units(number: float) -> str:
    """A size in words: 0.4 MB, 2.1 GB."""
    return f"{number / 1e9:.1f} GB" if number >= 1e9 else f"{number / 1e6:.1f} MB"
