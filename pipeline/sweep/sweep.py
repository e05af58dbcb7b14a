"""A sweep from its spec to its table: what is known is taken, the rest computed, each point kept as it comes.

The table is one of HDF5: a column for each varied parameter, the outcome and its reason, and each output. Every point
is a row, in the order of the spec, also those without a result: their outputs are NaN or empty words, and their reason
says why. On one kind of processor the same sweep gives the same bytes.
"""

import contextlib
import dataclasses
import json
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, get_args

import h5py
import numpy as np

from pipeline.cache import artefact, disk, fingerprint, hdf5
from pipeline.cache.hdf5 import describe
from pipeline.cache.store import SWEEPS
from pipeline.errors import StudyError
from pipeline.execution.display import Display
from pipeline.execution.job import Task, task_of
from pipeline.home import result_class
from pipeline.study import Study
from pipeline.sweep import pool
from pipeline.sweep.chain import Chain
from pipeline.sweep.pool import COMPUTED, NOT_ALLOWED, Journal, Row
from pipeline.sweep.spec import Spec

_STORAGE = {"compression": "gzip", "shuffle": True}


def table(
    chain: Chain, rows: Iterable[Row], note: Callable[[str], None]
) -> tuple[bytes, dict[str, int]]:
    """The HDF5 file of a sweep's points with their rows, and how many have each outcome; `note` gets an output
    that no result has.
    """
    count, usual = chain.spec.size, chain.usual()
    given, found = dict[str, Any](), dict[str, Any]()
    ended, reasons = list[str](), list[str]()
    for index, row in enumerate(rows):
        for name, value in {**usual, **chain.spec.point(index)}.items():
            _put(given, name, index, value, count)
        for name, value in row.values.items():
            if any(fnmatchcase(name, pattern) for pattern in chain.spec.outputs):
                _put(found, name, index, value, count)
        ended.append(row.outcome)
        reasons.append(row.reason)
    for pattern in chain.spec.outputs:
        if not any(fnmatchcase(name, pattern) for name in found):
            note(f'{chain.spec.file}: outputs: no point has a result "{pattern}"')
    with artefact.in_memory() as file:
        for name, text in chain.study.about.items():
            file.attrs[name] = text
        group = file.create_group("table", track_order=True)
        row = hdf5.row_scale(group, hdf5.free_row_name({**given, **found}), count, **_STORAGE)
        columns = {
            name: _write(group, name, column, {"unit": chain.unit(name), "description": "varied"})
            for name, column in given.items()
        }
        columns["outcome"] = _write(group, "outcome", ended, {"description": "computed, or what kept it from that"})
        columns["reason"] = _write(group, "reason", reasons, {"description": "why there is no result"})
        result = result_class(chain.study.package, chain.spec.stage)
        for name, column in found.items():
            own = f"{chain.spec.stage}.{name}" if name in columns else name  # a stage may have an outcome of its own
            columns[own] = _write(group, own, column, about(result, name))
        hdf5.attach(group, columns, {}, row)
        group = file.create_group("provenance")
        for name, text in _provenance(chain).items():
            group.attrs[name] = text
        return artefact.image(file), dict(Counter(ended))


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


def about(cls: type, column: str) -> Mapping[str, str]:
    """Unit, symbol and description of a column of a result class; empty where it has none."""
    first, _, rest = column.partition(".")
    said, kind = hdf5.declared(cls).get(first, ({}, None))
    inner = next((each for each in (kind, *get_args(kind)) if dataclasses.is_dataclass(each)), None)
    if rest and isinstance(inner, type):
        return about(inner, rest)
    return {key: str(said[key]) for key in ("unit", "symbol", "description") if said.get(key)}


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


class Sweep:
    """One sweep of a study."""

    def __init__(self, study: Study, spec: Spec, display: Display) -> None:
        study = dataclasses.replace(study, settings=(*spec.settings, *study.settings))
        self.study, self.spec, self.display = study, spec, display
        self.chain = Chain(study, spec)
        self.folder = study.results / SWEEPS

    def run(self, out: Path, workers: int, client: Any = None) -> dict[str, Any]:
        """Compute what is missing and write the table to `out`. Call it under the lock of `folder`.

        Gives what the sweep came to, by name; `busy` is the share of the workers' time that went into points, None
        where nothing was computed.
        """
        job = self.chain.job(self.display)
        shared = disk.digest(json.dumps(self.chain.ground, sort_keys=True).encode())[:32]
        with contextlib.closing(Journal(self.folder / ".cache" / f"{shared}.jsonl")) as journal:
            keys = [self._key(index, journal) for index in range(self.spec.size)]
            first = {key: index for index, key in reversed([*enumerate(keys)]) if key not in journal}
            known = sum(key in journal and key != str(index) for index, key in enumerate(keys))
            if known:
                self.display.note(f"{known} of {len(keys)} points are known already")
            missing, began, done, failed, inside = sorted(first.values()), time.monotonic(), 0, 0, 0.0
            with contextlib.closing(self.display):
                for index, row in pool.rows(job, missing, self._task, workers, client) if missing else ():
                    if keys[index] not in journal:  # a chunk that was given to another worker may come back twice
                        journal.add(keys[index], row)
                        done, failed, inside = done + 1, failed + (row.outcome != COMPUTED), inside + row.seconds
                        far = how_far(done, len(missing), failed, time.monotonic() - began)
                        self.display.points(done, len(missing), far)
            seconds, lost = time.monotonic() - began, sum(key not in journal for key in first)
            if lost:
                raise StudyError(f"{lost} points did not come back; run the sweep again to compute them")
            content, outcomes = table(self.chain, map(journal.row, keys), self.display.note)
        disk.write(out, content)
        busy = inside / (seconds * workers) if missing and seconds else None
        return {"points": len(keys), "outcomes": outcomes, "reused": known, "computed_now": len(missing),
                "seconds": seconds, "point_seconds": inside, "workers": workers, "busy": busy}  # fmt: skip

    def _task(self, index: int) -> Task:
        return task_of(self.study, self.chain.parameters(self.spec.point(index)), index)

    def _key(self, index: int, journal: Journal) -> str:
        """Key of a point; its number, with a row in the journal, where its values are not allowed."""
        try:
            return self.chain.key(self.chain.parameters(self.spec.point(index)))
        except StudyError as error:
            journal.add(str(index), Row(NOT_ALLOWED, str(error)))
            return str(index)


def how_far(done: int, total: int, failed: int, spent: float) -> str:
    """`120 of 2000 points, 3 without result, 18.3 points/s, 1 min 43 s left`, after `spent` seconds of this run."""
    rate = done / spent if spent > 0 else 0.0
    left = duration((total - done) / rate) if rate else "unknown time"
    return f"{done} of {total} points, {failed} without result, {rate:.3g} points/s, {left} left"


def duration(seconds: float) -> str:
    """A time as people say it: `43 s`, `1 min 43 s`, `3 h 10 min`, `2 d 5 h`."""
    whole = int(seconds + 0.5)
    for large, small, size, part in (("d", "h", 86400, 3600), ("h", "min", 3600, 60), ("min", "s", 60, 1)):
        if whole >= size:
            return f"{whole // size} {large} {whole % size // part} {small}"
    return f"{whole} s"
