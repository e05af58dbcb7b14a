"""What has been computed: results/.cache/<key>/ holds every file a stage made, with a manifest that vouches for them.

Entries are never changed, so undoing an edit finds the old one. The files in the results folder are copies.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pipeline.cache import durable, fingerprint
from pipeline.cache.fingerprint import Ingredients

_MANIFEST = "manifest.json"
_MAKING = "making-"
_ASIDE = "-old"
_RESULTS = "results/"
SWEEPS = "sweeps"


@dataclass(frozen=True)
class Out:
    """One file a stage made: hash of its bytes, size, and hash of what it says (without provenance)."""

    sha256: str
    size: int
    content: str


@dataclass(frozen=True)
class Entry:
    """A stage's stored result. `outs` maps paths like results/analytic.h5 to their files."""

    stage: str
    ingredients: Ingredients
    outs: dict[str, Out]
    summary: str
    seconds: float

    @property
    def key(self) -> str:
        """The cache key."""
        return fingerprint.key(self.ingredients)

    def contents(self, path: str) -> dict[str, str]:
        """Content hash of each file that the out `path`, a file or a folder, consists of."""
        return {name: out.content for name, out in self.outs.items() if name == path or name.startswith(path + "/")}


class Store:
    """The cache of one results folder."""

    def __init__(self, results: Path) -> None:
        self.results = results
        self.folder = results / ".cache"

    def entry(self, key: str) -> Entry | None:
        """The entry of this key, or None if there is none or its manifest is damaged."""
        return _entry(durable.read(self.folder / key / _MANIFEST), key)

    def new_folder(self, key: str) -> Path:
        """An empty folder in which a worker makes the files of `key`."""
        folder = self.folder / f"{_MAKING}{key}-{os.getpid()}"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return folder

    def keep(self, folder: Path, entry: Entry) -> bool:
        """Make a filled folder the entry of its key. Whether an earlier entry held other bytes (it is replaced)."""
        durable.write(folder / _MANIFEST, _manifest(entry))
        target = self.folder / entry.key
        earlier = self.entry(entry.key)
        if target.exists():
            aside = folder.with_name(folder.name + _ASIDE)
            target.rename(aside)
            folder.rename(target)
            shutil.rmtree(aside, ignore_errors=True)
        else:
            folder.rename(target)
        durable.sync_folder(self.folder)
        return earlier is not None and earlier.outs != entry.outs

    def drop(self, key: str) -> None:
        """Forget an entry whose files turned out damaged."""
        shutil.rmtree(self.folder / key, ignore_errors=True)

    def sweep(self) -> None:
        """Remove what killed runs left behind. Only under the lock."""
        for path in self.folder.glob(_MAKING + "*"):
            entry = self.folder / path.name.removeprefix(_MAKING).partition("-")[0]
            if path.name.endswith(_ASIDE) and not entry.exists():
                path.rename(entry)  # the run ended between the two renames of `keep`
            shutil.rmtree(path, ignore_errors=True)
        folders = [self.folder, self.folder / "current", self.results]
        apart = (self.folder.name, SWEEPS)  # a sweep holds a lock of its own and may be writing
        folders += [path for path in self.results.iterdir() if path.is_dir() and path.name not in apart]
        for folder in folders:
            for path in folder.glob(".*.part"):
                if durable.is_unfinished(path):
                    with contextlib.suppress(OSError):
                        path.unlink()

    def current(self, stage: str) -> Entry | None:
        """The entry whose files were last put into the results folder, if that was completed."""
        record = self._last(stage)
        return self.entry(record["key"]) if record and record["complete"] else None

    def disturbed(self, entry: Entry) -> list[str]:
        """Files in the results folder that are not as `entry` made them: `results/fall.h5 is missing`."""
        found = []
        for path, out in entry.outs.items():
            content = durable.read(self.place(path))
            if content is None:
                found.append(f"{path} is missing")
            elif len(content) != out.size or durable.digest(content) != out.sha256:
                found.append(f"{path} was edited or damaged")
        return found

    def put_in_place(self, entry: Entry) -> bool:
        """Copy the entry's files into the results folder. False if the stored files are damaged (nothing is copied)."""
        stored = {path: durable.read(self.folder / entry.key / path) for path in entry.outs}
        fresh: dict[str, bytes] = {}
        for path, content in stored.items():
            if content is None or durable.digest(content) != entry.outs[path].sha256:
                return False
            if durable.read(self.place(path)) != content:
                fresh[path] = content
        before = self._last(entry.stage)
        earlier = sorted({*(before["files"] if before else self._left_behind(entry.stage)), *entry.outs})
        self._set_record(entry, False, earlier)
        for path, content in fresh.items():
            durable.write(self.place(path), content)
        for path in earlier:
            if path not in entry.outs:
                self.place(path).unlink(missing_ok=True)
        self._set_record(entry, True, sorted(entry.outs))
        return True

    def place(self, path: str) -> Path:
        """Where the out `results/...` lies in this results folder."""
        return self.results / path.removeprefix(_RESULTS)

    def _record(self, stage: str) -> Path:
        return self.folder / "current" / f"{stage}.json"

    def _set_record(self, entry: Entry, complete: bool, files: list[str]) -> None:
        record = {"stage": entry.stage, "key": entry.key, "complete": complete, "files": files}
        durable.write(self._record(entry.stage), json.dumps({**record, "seal": _seal(record)}).encode())

    def _last(self, stage: str) -> dict[str, Any] | None:
        """What was last put into the results folder for this stage; None if that is not known or was tampered with."""
        try:
            record = json.loads(durable.read(self._record(stage)) or b"")
            seal = record.pop("seal")
        except (ValueError, KeyError, TypeError, AttributeError):
            return None
        return record if seal == _seal(record) and record["stage"] == stage else None

    def _left_behind(self, stage: str) -> set[str]:
        """Files in the results folder that are as some stored entry of this stage made them."""
        entries = (self.entry(path.name) for path in self.folder.iterdir())
        return {
            path
            for entry in entries
            if entry is not None and entry.stage == stage
            for path, out in entry.outs.items()
            if durable.digest(durable.read(self.place(path)) or b"") == out.sha256
        }


def _manifest(entry: Entry) -> bytes:
    body = asdict(entry)
    return json.dumps({"seal": _seal(body), "entry": body}, indent=1).encode()


def _entry(content: bytes | None, key: str) -> Entry | None:
    try:
        stored = json.loads(content or b"")
        body = stored["entry"]
        if stored["seal"] != _seal(body):
            return None
        entry = Entry(**{**body, "outs": {path: Out(**out) for path, out in body["outs"].items()}})
    except (ValueError, KeyError, TypeError):
        return None
    return entry if entry.key == key else None


def _seal(body: dict[str, Any]) -> str:
    return durable.digest(json.dumps(body, sort_keys=True).encode())
