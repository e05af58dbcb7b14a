"""What has been computed: results/.cache/<key>/ holds every file a stage made, with a manifest that vouches for them.

Entries are never changed, so undoing an edit finds the old one. The files in the results folder are copies. Where they
came without the cache, as from another machine, each stage's artefact shows what it and the files beside it hold.

A seal shows damage, not forgery: whoever sends a results folder can write any manifest. So only outs of dvc.yaml are
written and removed, whatever manifests and records say, and never through a link that leads out of the folder.
"""

import contextlib
import errno
import hashlib
import io
import json
import os
import shutil
import stat
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

from pipeline.cache import disk, fingerprint
from pipeline.cache.fingerprint import INGREDIENTS, Ingredients
from pipeline.errors import StudyError
from pipeline.graph import OWN, beneath, is_inside

MANIFEST = "manifest.json"
_MAKING = "making-"
_ASIDE = "-old"
_RESULTS = "results/"
#: What is raised by words that have not the form they should have.
_ILL_FORMED = (ValueError, KeyError, TypeError, AttributeError, RecursionError)
_SHAPE = {"code": dict, "parameters": dict, "inputs": dict, "versions": dict, "outs": list}
CURRENT, QUESTIONS, SWEEPS = "current", "questions", "sweeps"


@dataclass(frozen=True)
class Out:
    """One file a stage made: hash of its bytes, size, and hash of what it says (without provenance)."""

    sha256: str
    size: int
    content: str


@dataclass(frozen=True)
class Entry:
    """A stage's stored result. `outs` maps paths like results/analytic.h5 to their files.

    A stage that said no for a reason of its own has none of them, and its `summary` is the reason.
    """

    stage: str
    ingredients: Ingredients
    outs: dict[str, Out]
    summary: str
    seconds: float

    @cached_property
    def key(self) -> str:
        """The cache key."""
        return fingerprint.key(self.ingredients)

    @property
    def refused(self) -> bool:
        """Whether the stage said no."""
        return not self.outs

    def contents(self, path: str) -> dict[str, str]:
        """Content hash of each file that the out `path`, a file or a folder, consists of; of none, the reason."""
        if self.refused:
            return {path: f"none: {self.summary}"}
        return {name: self.outs[name].content for name in beneath(path, self.outs)}


class Store:
    """The cache of one results folder. `outs` maps each stage to the paths that dvc.yaml lists as its outs.

    What it lacks is taken from the cache `shared`, if there is one, in which nothing is written. Raises `StudyError`
    if a link stands in place of a folder that this program writes to.
    """

    def __init__(self, results: Path, outs: Mapping[str, tuple[str, ...]], shared: Path | None) -> None:
        self.results, self.outs, self.shared = results, outs, shared
        self.folder = results / ".cache"
        for path in (self.folder, self.folder / CURRENT, self.folder / QUESTIONS, results / SWEEPS / ".cache",
                     *(results / name for name in OWN)):  # fmt: skip
            if path.is_symlink():
                name = path.relative_to(results).as_posix()
                raise StudyError(f"{results.name}/{name}: is a link, and nothing is written through one; remove it")

    def entry(self, key: str) -> Entry | None:
        """The entry of this key, or None if there is none, its manifest is damaged, or names what is no out."""
        return self._found(key)[1]

    def _found(self, key: str) -> tuple[Path, Entry | None]:
        """The folder with an entry's files, and the entry."""
        for cache in (self.folder, *([self.shared] if self.shared else [])):
            entry = _entry(disk.read(cache / key / MANIFEST, disk.MEMO), key)
            if entry is not None:
                return cache / key, entry
        return self.folder / key, None

    def new_folder(self, key: str) -> Path:
        """An empty folder in which a worker makes the files of `key`."""
        folder = self.folder / f"{_MAKING}{key}-{os.getpid()}"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return folder

    def keep(self, folder: Path, entry: Entry) -> bool:
        """Make a filled folder the entry of its key. Whether an earlier one (it is replaced) said something else."""
        body = asdict(entry)
        disk.write(folder / MANIFEST, json.dumps({"seal": _seal(body), "entry": body}, indent=1).encode())
        target = self.folder / entry.key
        earlier = self.entry(entry.key)
        if target.exists() or target.is_symlink():
            aside = folder.with_name(folder.name + _ASIDE)
            target.rename(aside)
            folder.rename(target)
            disk.remove(aside)
        else:
            folder.rename(target)
        disk.sync_folder(self.folder)
        return earlier is not None and _said(earlier) != _said(entry)

    def drop(self, key: str) -> None:
        """Forget an entry whose files turned out damaged."""
        disk.remove(self.folder / key)

    def sweep(self) -> None:
        """Remove what killed runs left behind. Only under the lock."""
        for path in self.folder.glob(_MAKING + "*"):
            entry = self.folder / path.name.removeprefix(_MAKING).partition("-")[0]
            if path.name.endswith(_ASIDE) and not entry.exists():
                path.rename(entry)  # the run ended between the two renames of `keep`
            disk.remove(path)
        folders = [self.folder, self.folder / CURRENT, self.results]
        apart = (self.folder.name, SWEEPS)  # a sweep holds a lock of its own and may be writing
        folders += [path for path in self.results.iterdir()
                    if _is_folder(path) and path.name not in apart]  # fmt: skip
        for folder in folders:
            for path in folder.glob(".*.part"):
                with contextlib.suppress(OSError):
                    path.unlink()

    def current(self, stage: str) -> Entry | None:
        """The entry whose files were last put into the results folder, if that was completed; else the arrived one."""
        record = self._last(stage)
        found = self.entry(record["key"]) if record and record["complete"] else None
        return self.arrived(stage) if found is None else found

    def arrived(self, stage: str, key: str = "") -> Entry | None:
        """The entry (of a `key`) that a stage's artefact in the results folder names, if all its files hold what it
        says, and it is not known that they were half replaced. Its time is not known, and 0.
        """
        record = self._last(stage)
        if record and not record["complete"]:
            return None
        own = f"{_RESULTS}{stage}.h5"
        with contextlib.suppress(OSError, StudyError, *_ILL_FORMED):
            content = disk.read(self.place(own), disk.ARTEFACT)
            if content is None or key.encode() not in content:
                return None
            from pipeline.cache import artefact  # with h5py, which takes its time
            from pipeline.room import reading

            if artefact.sealed(content) != content:
                return None
            reading.check_plain(io.BytesIO(content), own)
            about = artefact.provenance(content, own)
            beside = (line.split(" ", 2) for line in about["files"].splitlines())
            outs = {path: asdict(Out(digest, int(size), digest)) for digest, size, path in beside}
            outs[own] = asdict(Out(disk.digest(content), len(content), about[artefact.CONTENT]))
            body = {"stage": stage, "ingredients": json.loads(about[INGREDIENTS]), "outs": outs,
                    "summary": about["summary"], "seconds": 0.0}  # fmt: skip
            entry = _checked_entry(body, about["key"])
            return entry if entry is not None and not self.disturbed(entry) else None
        return None

    def take_in(self, entry: Entry) -> None:
        """Keep an entry that arrived as one that was computed here; where nothing can be written it stays as it is."""
        record, stored = self._last(entry.stage), self.entry(entry.key) is not None
        if stored and record and record["complete"] and record["key"] == entry.key:
            return
        with contextlib.suppress(OSError):
            if not stored:
                folder = self.new_folder(entry.key)
                for path, out in entry.outs.items():
                    disk.write(folder / path, _checked(self.place(path), out))
                self.keep(folder, entry)
            self.put_in_place(entry)

    def last_keys(self) -> set[str]:
        """Keys of the entries whose files were last put into the results folder, completed or not.

        Also of stages that another branch's dvc.yaml has.
        """
        stages = (path.stem for path in (self.folder / CURRENT).glob("*.json"))
        return {record["key"] for stage in stages if (record := self._last(stage)) is not None}

    def disturbed(self, entry: Entry) -> list[str]:
        """Files in the results folder that are not as `entry` made them: `results/fall.h5 is missing`."""
        states = {path: _is_as_made(self.place(path), out) for path, out in entry.outs.items()}
        return [f"{path} {'is missing' if state is None else 'was edited or damaged'}"
                for path, state in states.items() if not state]  # fmt: skip

    def put_in_place(self, entry: Entry) -> bool:
        """Copy the entry's files into the results folder. False if the stored files are damaged (nothing is copied).

        Files of the stage's earlier results that the entry has not are removed. Raises `StudyError` if a link on the
        way to one of these files leads out of the folder (nothing is copied).
        """
        folder, _ = self._found(entry.key)
        stored = {path: folder / path for path in entry.outs}
        if not all(_is_as_made(stored[path], out) for path, out in entry.outs.items()):
            return False
        fresh = [path for path, out in entry.outs.items() if not _is_as_made(self.place(path), out)]
        before = self._last(entry.stage)
        earlier = {*(before["files"] if before else self._left_behind(entry.stage)), *entry.outs}
        own = sorted(path for path in earlier if _beneath(path, self.outs[entry.stage]))
        gone = [path for path in own if path not in entry.outs and not _is_folder(self.place(path))]
        places = {path: disk.inside(self.results, self.place(path), path) for path in (*fresh, *gone)}
        self._set_record(entry, False, own)
        for path in fresh:
            disk.write(places[path], _checked(stored[path], entry.outs[path]))
        for path in gone:
            places[path].unlink(missing_ok=True)
        self._set_record(entry, True, sorted(entry.outs))
        if before is not None and before["key"] != entry.key:
            with contextlib.suppress(OSError):  # an earlier result is as old as the time since it was current
                os.utime(self.folder / before["key"] / MANIFEST)
        return True

    def place(self, path: str) -> Path:
        """Where the out `results/...` lies in this results folder."""
        return self.results / path.removeprefix(_RESULTS)

    def vouchers(self, entry: Entry) -> tuple[Path, Path]:
        """The files that say of an entry what was made and that it was put in place."""
        return self.folder / entry.key / MANIFEST, self._record(entry.stage)

    def _record(self, stage: str) -> Path:
        return self.folder / CURRENT / f"{stage}.json"

    def _set_record(self, entry: Entry, complete: bool, files: list[str]) -> None:
        record = {"stage": entry.stage, "key": entry.key, "complete": complete, "files": files}
        disk.write(self._record(entry.stage), json.dumps({**record, "seal": _seal(record)}).encode())

    def _last(self, stage: str) -> dict[str, Any] | None:
        """What was last put into the results folder for this stage; None if that is not known or was tampered with."""
        try:
            record = json.loads(disk.read(self._record(stage), disk.MEMO) or b"")
            seal = record.pop("seal")
            whole = seal == _seal(record) and record["stage"] == stage and isinstance(record["key"], str)
            return record if whole and all(is_inside(path) for path in record["files"]) else None
        except _ILL_FORMED:
            return None

    def _left_behind(self, stage: str) -> set[str]:
        """Files in the results folder that are as some stored entry of this stage made them."""
        entries = (self.entry(path.name) for path in self.folder.iterdir())
        return {
            path
            for entry in entries
            if entry is not None and entry.stage == stage
            for path, out in entry.outs.items()
            if _is_as_made(self.place(path), out)
        }


@lru_cache(maxsize=64)
def _entry(content: bytes | None, key: str) -> Entry | None:
    """What a manifest says of an entry: looked at once, as a run asks several times for the same ones."""
    try:
        stored = json.loads(content or b"")
        return _checked_entry(stored["entry"], key) if stored["seal"] == _seal(stored["entry"]) else None
    except _ILL_FORMED:
        return None


def _checked_entry(body: dict[str, Any], key: str) -> Entry | None:
    """The entry of a manifest's `body`; None unless it is that of `key`. Raises `_ILL_FORMED` for another form."""
    outs = {path: Out(**out) for path, out in body["outs"].items()}
    entry = Entry(**{**body, "outs": outs})
    parts = entry.ingredients
    fits = all(isinstance(parts[name], kind) for name, kind in _SHAPE.items()) and parts["stage"] == entry.stage
    return entry if fits and entry.key == key and all(_beneath(path, parts["outs"]) for path in outs) else None


def _said(entry: Entry) -> dict[str, str]:
    """What each file says, by path; which program made it, and so its bytes, may differ."""
    return {path: out.content for path, out in entry.outs.items()}


def _beneath(path: str, outs: Iterable[str]) -> bool:
    """Whether a path is one of the outs, or lies in one that is a folder."""
    return is_inside(path) and any(beneath(out, [path]) for out in outs)


def _is_as_made(path: Path, out: Out) -> bool | None:
    """Whether the file at `path` holds what was made; None if there is none."""
    try:
        found = path.stat()
    except OSError:
        return None
    return stat.S_ISREG(found.st_mode) and found.st_size == out.size and disk.file_digest(path) == out.sha256


def _checked(path: Path, out: Out) -> Iterator[bytes]:
    """The content of a stored file, part by part. Raises OSError at its end if it is not what was made."""
    found = hashlib.sha256()
    for block in disk.blocks(path):
        found.update(block)
        yield block
    if found.hexdigest() != out.sha256:
        raise OSError(errno.EIO, "the stored file changed while it was copied", str(path))


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()


def _seal(body: dict[str, Any]) -> str:
    return disk.digest(json.dumps(body, sort_keys=True).encode())
