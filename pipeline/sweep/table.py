"""A sweep as one table in HDF5: a column for each varied parameter, the outcome and its reason, and each output.

Every point is a row, in the order of the spec, also those without a result: their outputs are NaN or empty words, and
their reason says why. On one kind of processor the same sweep gives the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from fnmatch import fnmatchcase
from typing import Any

import h5py
import numpy as np

from pipeline.cache import artefact, fingerprint
from pipeline.cache.hdf5 import dimensions
from pipeline.cache.hdf5.tables import describe
from pipeline.execution.columns import about
from pipeline.stage_modules import result_class, study_attributes
from pipeline.sweep.chain import Chain
from pipeline.sweep.journal import Row

_STORAGE = {"compression": "gzip", "shuffle": True}


def encode(
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
