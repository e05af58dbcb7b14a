"""A sweep from its spec to its table: what is known is taken, the rest computed, each point kept as it comes.

The table is one of HDF5: a column for each varied parameter, the outcome and its reason, and each output. Every point
is a row, in the order of the spec, also those without a result: their outputs are NaN or empty words, and their reason
says why. On one kind of processor the same sweep gives the same bytes.
"""

from __future__ import annotations

import dataclasses
import json
import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pipeline.cache import artefact, disk, fingerprint
from pipeline.cache.hdf5 import dimensions
from pipeline.cache.hdf5.tables import describe
from pipeline.cache.store import SWEEPS
from pipeline.errors import StudyError
from pipeline.execution.columns import about
from pipeline.execution.display import Display
from pipeline.execution.executor import bring_up_to_date
from pipeline.execution.job import Job, Task, task_of
from pipeline.stage_modules import result_class, study_attributes
from pipeline.study import Study, shown
from pipeline.sweep import pool
from pipeline.sweep.chain import Chain
from pipeline.sweep.journal import COMPUTED, KEPT, NOT_ALLOWED, Journal, Row
from pipeline.sweep.spec import Points, Spec

_STORAGE = {"compression": "gzip", "shuffle": True}


def table(
    chain: Chain, lines: Iterable[tuple[Mapping[str, Any], Row]], count: int, note: Callable[[str], None]
) -> bytes:
    """The HDF5 file of a sweep's points with their rows; `note` is told of an output that no result has."""
    given: dict[str, Any] = {}
    found: dict[str, Any] = {}
    outcomes, reasons = [], []
    for index, (point, row) in enumerate(lines):
        for name, value in point.items():
            _put(given, name, index, value, count)
        for name, value in row.values.items():
            if any(fnmatchcase(name, pattern) for pattern in chain.spec.outputs):
                _put(found, name, index, value, count)
        outcomes.append(row.outcome)
        reasons.append(row.reason)
    for pattern in chain.spec.outputs:
        if not any(fnmatchcase(name, pattern) for name in found):
            note(f'{chain.spec.name}: outputs: no point has a result "{pattern}"')
    with h5py.File("table", "w", driver="core", backing_store=False, libver=("v110", "v110"), track_order=True) as file:
        file.attrs["format"] = artefact.FORMAT
        for name, text in study_attributes(chain.study.package, chain.study.code_root).items():
            file.attrs[name] = text
        group = file.create_group("table", track_order=True)
        row = dimensions.rows(group, dimensions.free("row", {**given, **found}), count, **_STORAGE)
        columns = {
            name: _write(group, name, column, {"unit": chain.unit(name), "description": "varied"})
            for name, column in given.items()
        }
        columns["outcome"] = _write(group, "outcome", outcomes, {"description": "computed, or what kept it from that"})
        columns["reason"] = _write(group, "reason", reasons, {"description": "why there is no result"})
        result = result_class(chain.study.package, chain.spec.stage)
        for name in found:
            columns[name] = _write(group, name, found[name], about(result, name))
        dimensions.attach(group, columns, {}, row)
        group = file.create_group("provenance")
        for name, text in _provenance(chain).items():
            group.attrs[name] = text
        file.flush()
        return bytes(file.id.get_file_image())


def _put(columns: dict[str, Any], name: str, index: int, value: Any, count: int) -> None:
    number = isinstance(value, (int, float))
    if name not in columns:
        columns[name] = np.full(count, np.nan) if number else [""] * count
    if number and not isinstance(columns[name], np.ndarray):
        value = str(value)
    columns[name][index] = value if number or not isinstance(columns[name], np.ndarray) else np.nan


def _write(group: Any, name: str, column: Any, attributes: Mapping[str, str]) -> Any:
    if not isinstance(column, np.ndarray):  # words of one length can be compressed; to netCDF one byte is a sign
        words = np.char.encode(np.array([str(value) for value in column], dtype=np.str_), "utf-8")
        column = np.asarray(words, dtype=h5py.string_dtype("utf-8", max(2, words.dtype.itemsize)))
    item = group.create_dataset(name, data=column, track_times=False, **_STORAGE)
    describe(item, attributes)
    return item


def _provenance(chain: Chain) -> dict[str, str]:
    spec, swept = chain.spec, chain.ground[chain.spec.stage]
    base = fingerprint.compact
    fixed = {name: value for name, value in chain.fixed().items() if name not in spec.names}
    return {
        "stage": spec.stage,
        "key": fingerprint.key(swept),
        "sweep": f"{spec.kind}, {spec.size} points" + (f", seed {spec.seed}" if spec.axes and spec.seed else ""),
        "axes": "\n".join(f"{name} = {axis}" for name, axis in spec.axes.items()),
        "parameters": "\n".join(f"{name} = {base(value)}" for name, value in fixed.items()),
        "versions": "\n".join(f"{name} {version}" for name, version in swept["versions"].items()),
    }


@dataclass(frozen=True)
class Summary:
    """What a sweep came to. `busy` is the share of the workers' time that went into points."""

    points: int
    outcomes: Mapping[str, int]
    reused: int
    computed_now: int
    seconds: float
    point_seconds: float
    workers: int

    @property
    def busy(self) -> float | None:
        """Seconds in points over seconds of all workers; None where nothing was computed."""
        return self.point_seconds / (self.seconds * self.workers) if self.computed_now and self.seconds else None


class Sweep:
    """One sweep of a study."""

    def __init__(self, study: Study, spec: Spec, display: Display) -> None:
        study = dataclasses.replace(study, settings=(*spec.settings, *study.settings))
        self.study, self.spec, self.display = study, spec, display
        self.chain = Chain(study, spec)
        self.points = Points(spec)
        self.folder = study.results / SWEEPS

    def run(self, out: Path, workers: int, client: Any = None) -> Summary:
        """Compute what is missing and write the table to `out`. Call it under the lock of `folder`."""
        job = self._job()
        shared = disk.digest(json.dumps(self.chain.ground, sort_keys=True).encode())[:32]
        with Journal(self.folder / ".cache" / f"{shared}.jsonl") as journal:
            keys, refused = self._keys()
            known = sum(key in journal for key in keys if key)
            first: dict[str, int] = {}
            for index, key in enumerate(keys):
                if key and key not in journal:
                    first.setdefault(key, index)
            missing = sorted(first.values())
            if known:
                self.display.note(f"{known} of {len(keys)} points are known already")
            unkept: dict[str, Row] = {}
            began, point_seconds = time.monotonic(), 0.0
            if missing:
                meter = Meter(len(missing), self.display)
                try:
                    for index, row in pool.rows(job, missing, self._task, workers, client):
                        if keys[index] in journal or keys[index] in unkept:
                            continue  # a chunk that was given to another worker may come back twice
                        point_seconds += row.seconds
                        if row.outcome in KEPT:
                            journal.add(keys[index], row)
                        else:
                            unkept[keys[index]] = row
                        meter.one_more(row.outcome != COMPUTED)
                finally:
                    self.display.close()
            seconds = time.monotonic() - began
            lost = sum(key not in journal and key not in unkept for key in first)
            if lost:
                raise StudyError(f"{lost} points did not come back; run the sweep again to compute them")
            outcomes: Counter[str] = Counter()
            content = table(self.chain, self._lines(keys, refused, journal, unkept, outcomes), len(keys),
                                   self.display.note)  # fmt: skip
        disk.write(out, content)
        return Summary(len(keys), dict(outcomes), known, len(missing), seconds, point_seconds, workers)

    def _task(self, index: int) -> Task:
        return task_of(self.study, self.chain.parameters(self.points[index]), index)

    def _keys(self) -> tuple[list[str], dict[int, Row]]:
        """Key of each point (empty where the values are not allowed), and the rows of those."""
        keys, refused = [], {}
        for index in range(len(self.points)):
            try:
                keys.append(self.chain.key(self.chain.parameters(self.points[index])))
            except StudyError as error:
                keys.append("")
                refused[index] = Row(NOT_ALLOWED, str(error))
        return keys, refused

    def _lines(
        self, keys: list[str], refused: Mapping[int, Row], journal: Journal, unkept: Mapping[str, Row],
        outcomes: Counter[str],
    ) -> Iterator[tuple[Mapping[str, Any], Row]]:  # fmt: skip
        for index, key in enumerate(keys):
            row = refused.get(index) or (journal.row(key) if key in journal else unkept[key])
            outcomes[row.outcome] += 1
            yield self.points[index], row

    def _job(self) -> Job:
        """The job, after the stages that no point changes have been brought up to date."""
        fixed: dict[str, bytes] = {}
        contents: dict[str, str] = {}
        above = self.chain.above
        if above:
            names = self.study.graph.needed_for(above)
            values = {name: self.chain.base[name] for name in names}
            place, note = self.study.results, self.display.note
            with disk.locked(place, shown(place), "bipedstudy sweep", True, note):
                bring_up_to_date(self.study, values, self.display, jobs=os.cpu_count() or 1)
                for name in above:
                    entry = self.study.store.current(name)
                    assert entry is not None
                    for path, made in entry.outs.items():
                        fixed[path] = disk.read(self.study.store.place(path)) or b""
                        contents[path] = made.content
        return self.chain.job(fixed, contents)


class Meter:
    """Counts the points of this run, not those found in the journal, and tells a display."""

    def __init__(self, total: int, display: Display) -> None:
        self.total, self.done, self.failed, self._display = total, 0, 0, display
        self._began = time.monotonic()

    def one_more(self, failed: bool) -> None:
        """A point is done."""
        self.done += 1
        self.failed += failed
        self._display.points(self.done, self.total, self.sentence())

    def sentence(self) -> str:
        """`120 of 2000 points, 3 without result, 18.3 points/s, 1 min 43 s left`."""
        spent = time.monotonic() - self._began
        rate = self.done / spent if spent > 0 else 0.0
        left = duration((self.total - self.done) / rate) if rate else "unknown time"
        return f"{self.done} of {self.total} points, {self.failed} without result, {rate:.3g} points/s, {left} left"


def duration(seconds: float) -> str:
    """A time as people say it: `43 s`, `1 min 43 s`, `3 h 10 min`, `2 d 5 h`."""
    whole = int(seconds + 0.5)
    for large, small, size, part in (("d", "h", 86400, 3600), ("h", "min", 3600, 60), ("min", "s", 60, 1)):
        if whole >= size:
            return f"{whole // size} {large} {whole % size // part} {small}"
    return f"{whole} s"
