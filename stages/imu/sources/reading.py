"""A lab's files as runs of numbers and words, which another process can read and hand over."""

import dataclasses
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, closing, nullcontext
from pathlib import Path
from typing import Any

from stages.imu.sources.column_map import CsvSource
from stages.imu.sources.databases import SqliteSource, TableSource
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.schema import DatabaseWriter, Device, Experiment, Recording, Rows

Run = tuple[Experiment, tuple[Recording, ...]]
_ROWS = tuple(field.name for field in dataclasses.fields(Rows))


def runs(source: Path, column_map: Mapping[str, Any] | None = None, store: str | None = None) -> Iterator[Any]:
    """Each run of an SQLite file, or of a folder with its map, as `run_of` takes it; all raw rows go into `store`.

    Raises SourceRefused.
    """
    opened: AbstractContextManager[Any] = (
        SqliteSource(source) if column_map is None else nullcontext(CsvSource(column_map, source)))
    with opened as files:
        for experiment, recordings in kept(files, store):
            yield dataclasses.asdict(experiment), [
                (dataclasses.asdict(one.device), {name: getattr(one, name) for name in _ROWS}) for one in recordings]


def run_of(plain: Any) -> Run:
    """A run that `runs` gave."""
    experiment = Experiment(**plain[0])
    return experiment, tuple(Recording(**rows, experiment=experiment, device=Device(**device))
                             for device, rows in plain[1])  # fmt: skip


def kept(source: Any, store: str | None) -> Iterator[Run]:
    """Pass runs of a source on, and keep its rows in the new file `store`: a table's as they stand there, after all.

    Raises SourceRefused, also where they cannot be kept.
    """
    tabled = isinstance(source, TableSource)
    try:
        with ExitStack() as until_read:
            writer = store and until_read.enter_context(DatabaseWriter(Path(store), keys=not tabled))
            for experiment, recordings in until_read.enter_context(closing(source.runs())):
                if writer and not tabled:
                    writer.recordings(experiment, recordings)
                yield experiment, recordings
            if writer and tabled:
                for table, rows in source.raw():
                    writer.copy(table, rows)
    except sqlite3.Error as error:  # of the writer: those of a source are refusals already
        raise SourceRefused(f"--store: the rows cannot be written ({error})") from None
