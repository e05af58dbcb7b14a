"""Columns of a parquet file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stages.imu.errors import SourceRefused, printable
from stages.imu.sources.files import plain_file
from stages.imu.sources.files.optional import library, no_columns

ENDINGS = (".parquet", ".pq")


def opened(path: Path) -> Any:
    """The file, opened. Raises SourceRefused."""
    plain_file.check(path)
    reader = library("pyarrow.parquet", "files", path)
    try:
        return reader.ParquetFile(path)
    except Exception as error:  # readers of a format raise whatever a broken file makes them raise
        raise SourceRefused(f"{printable(path.name)} is no parquet file that can be read") from error


def read(path: Path, wanted: Sequence[str]) -> Mapping[str, np.ndarray]:
    """The columns `wanted` (n,) each, of numbers or moments, a row group in memory at a time. Raises SourceRefused."""
    file = opened(path)
    names = list(file.schema_arrow.names)
    for one in wanted:
        if one not in names:
            raise no_columns(path, one, names)
    parts: dict[str, list[np.ndarray]] = {one: [] for one in wanted}
    try:
        for batch in file.iter_batches(columns=list(wanted)):
            for one in wanted:
                parts[one].append(numbers(batch.column(one).to_numpy(zero_copy_only=False)))
    except Exception as error:  # as above
        raise SourceRefused(f"{printable(path.name)}: a column holds no numbers, or the file is broken") from error
    return {one: np.concatenate(parts[one]) if parts[one] else np.empty(0) for one in wanted}


def numbers(values: np.ndarray) -> np.ndarray:
    """Numbers (n,); moments as seconds since 1970, durations in seconds. Raises ValueError for anything else."""
    if values.dtype.kind in "mM":
        known = ~np.isnat(values)
        since = values[known] - np.datetime64(0, "s") if values.dtype.kind == "M" else values[known]
        seconds = np.full(len(values), np.nan)
        seconds[known] = since / np.timedelta64(1, "s")
        return seconds
    return np.asarray(values, dtype=float)
