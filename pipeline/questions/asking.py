"""What a question is handed while it is asked: progress, a pool whose answers are kept, new files."""

from __future__ import annotations

import contextlib
import glob
import io
import json
import os
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pipeline.cache import artefact, disk, hdf5
from pipeline.cache.fingerprint import parameter_text, versions
from pipeline.cache.hdf5 import describe
from pipeline.cache.sources import Closure
from pipeline.cache.store import QUESTIONS
from pipeline.commands.claims import keep_proof
from pipeline.commands.options import finite
from pipeline.errors import Declined, StageFailed, Stopped, StudyError
from pipeline.execution.job import Job, engine_code
from pipeline.parameters import loading
from pipeline.parameters.overrides import rewritten
from pipeline.study import Study, shown
from pipeline.sweep import pool
from pipeline.sweep.pool import COMPUTED, NO_ANSWER, Journal, Row

#: Rows of a table that are compressed together.
_CHUNK = 8192
#: Bytes of a row of standard input, and of what never becomes one.
_LONGEST_LINE, _ENDLESS_LINE = 4096, 1_000_000
#: A terminal has a bar after so long at the latest; elsewhere there is a line this often.
_BAR_AFTER_S, _LINE_EVERY_S = 1.0, 10.0


class Asked:
    """One question while it is asked of a stage with its parameters; use as a context manager."""

    def __init__(
        self, study: Study, stage: str, question: Any, parameters: Any, jobs: int | None, client: Any = None
    ) -> None:
        self.jobs, self._client = jobs or os.cpu_count() or 1, client
        self._study, self._stage, self._question, self._parameters = study, stage, question, parameters
        self._done, self._of, self._written = 0, 0, 0
        self._bar: Any = None
        self._said = time.monotonic()
        self._terminal = threading.RLock()
        self._soon = threading.Timer(_BAR_AFTER_S, self._show, (None, "computing"))
        self._soon.daemon = True

    def __enter__(self) -> Asked:
        if sys.stderr.isatty():
            self._soon.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *ending: object) -> None:
        self.close()
        if kind is KeyboardInterrupt:
            done = f"{self._done} of {self._of} parts are done and kept: asked again, it goes on from there"
            said = f"lines written until then: {self._written}" if self._written else "nothing of this answer is kept"
            raise Stopped(f"stopped; {done if self._of else said}") from None

    def close(self) -> None:
        """Give the terminal back."""
        self._soon.cancel()
        with self._terminal:
            if self._bar is not None:
                self._bar.stop()
                self._bar = None

    def note(self, text: str) -> None:
        """A line on standard error."""
        if self._bar is None:
            print(text, file=sys.stderr, flush=True)
        else:
            self._bar.console.print(text, highlight=False, markup=False, soft_wrap=True)

    def progress(self, fraction: float, what: str) -> None:
        """Move a bar on standard error, if that is a terminal; if not, a line there now and then."""
        if sys.stderr.isatty():
            self._soon.cancel()
            self._show(min(1.0, max(0.0, fraction)), what)
        elif time.monotonic() - self._said >= _LINE_EVERY_S:
            self._said = time.monotonic()
            print(f"{100 * fraction:.0f} %: {what}", file=sys.stderr, flush=True)

    def _show(self, fraction: float | None, what: str) -> None:
        """Move the bar; one without a fraction has no end, and is there until the question says how far it is."""
        with self._terminal:
            if fraction is None and (self._bar is not None or self._soon.finished.is_set()):
                return
            if self._bar is None:
                from rich.console import Console
                from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

                columns = BarColumn(), TimeElapsedColumn(), TextColumn("{task.description}", markup=False)
                self._bar = Progress(*columns, transient=True, console=Console(stderr=True))
                self._bar.add_task("", total=None)
                self._bar.start()
            self._bar.update(self._bar.task_ids[0], total=None if fraction is None else 1.0,
                             completed=fraction or 0.0, description=what)  # fmt: skip

    def say_if_cold(self) -> None:
        """Say so if the stage compiles its code at this use, as its module `compiled` knows."""
        compiled = self._study.module(self._stage, "compiled")
        if compiled is not None and compiled.CODE.is_cold():
            self.note(f"note: stage {self._stage}: {compiled.COMPILING}")

    def each(self, function: Callable[..., Any], arguments: Sequence[Any], *shared: Any) -> Iterator[Any]:
        """What the function answers to each argument, in their order, once all are known.

        The function is given the stage's parameters, what is `shared`, and an argument, all as JSON gives them back.
        """
        if self._study.borrowed:
            raise StudyError("the parts of this answer are kept in a study's results: ask inside a study, or say with "
                             "--results where they go")  # fmt: skip
        closure = self._study.sources.closure((f"{self._study.package}.{self._stage}.parameters",
                                               type(self._parameters).__module__, function.__module__))  # fmt: skip
        said = [json.dumps(each) for each in (shared, *arguments)]
        path = self._study.store.folder / QUESTIONS / f"{self._key(function, closure, said[0])}.jsonl"
        keys = [disk.digest(text.encode()) for text in said[1:]]
        try:
            journal = Journal(path)
        except OSError as error:
            raise StudyError(f"{shown(path.parent)}: cannot be written ({error.strerror}); choose another folder with "
                             "--results") from None  # fmt: skip
        with contextlib.closing(journal):
            waiting = {number: json.loads(said[number + 1]) for number, key in enumerate(keys) if key not in journal}
            self._done, self._of = len(keys) - len(waiting), len(keys)
            for number, row in self._rows(function, closure, waiting, json.loads(said[0])):
                if keys[number] in journal:
                    continue  # a cluster may compute one twice
                journal.add(keys[number], answered(row))
                self._done += 1
                self.progress(self._done / self._of, f"{self._done} of {self._of}")
            yield from (journal.row(key).values["answer"] for key in keys)

    def _rows(
        self, function: Callable[..., Any], closure: Closure, waiting: Mapping[int, Any], shared: Sequence[Any]
    ) -> Iterator[tuple[int, Row]]:
        """Row of each argument as it gets ready: from this process if it shall be one, from others, from a cluster."""
        jobs = min(self.jobs, len(waiting))
        if self._client is None and jobs <= 1:
            for number, argument in waiting.items():
                yield number, Row(COMPUTED, "", {"answer": function(self._parameters, *shared, argument)})
            return
        study, plain = self._study, loading.as_plain(self._parameters)
        job = Job(study.package, str(study.code_root), str(study.root), (), closure.files,
                  versions=versions(closure.foreign), engine=engine_code(),
                  function={"stage": self._stage, "module": function.__module__, "name": function.__qualname__,
                            "parameters": plain, "shared": shared})  # fmt: skip
        yield from pool.rows(job, [*waiting], lambda number: (number, waiting[number]),
                             jobs if self._client is None else self.jobs, self._client)  # fmt: skip

    def reading(
        self, reader: Callable[..., Iterator[Any]], source: Path, *given: Any, writes: Path | None = None
    ) -> Iterator[Any]:
        """What a reader yields of a file from outside, in a process that can do nothing else."""
        from pipeline.room import reading

        try:
            yield from reading.read(reader, source, *given, writes=writes)
        except StudyError as refused:
            raise self._question.wrong(str(refused)) from None

    def lines(self) -> Iterator[str]:
        """Lines of standard input as they come; one that is too long for a row is empty.

        Raises `StudyError` if one has no end.
        """
        size = 0
        while text := sys.stdin.buffer.readline(_LONGEST_LINE):
            size += len(text)
            if text.endswith(b"\n") or len(text) < _LONGEST_LINE:
                yield text.decode(errors="replace").strip() if size == len(text) else ""
                size = 0
            elif size > _ENDLESS_LINE:
                raise StudyError(f"standard input: no line ends within {_ENDLESS_LINE} bytes; allowed: rows of text")

    def say(self, row: Mapping[str, Any]) -> None:
        """Print a row at once, a line of JSON. Raises BrokenPipeError where nobody reads it any longer."""
        print(json.dumps(finite(row), allow_nan=False), flush=True)
        self._written += 1

    def result(self, stage: str = "") -> tuple[Any, str]:
        """A stage's result, or its own, as it lies among the study's, and its file; None, and a clause why not.

        Whatever made it: who asks says which parameters it must have been made with.
        """
        name = stage or self._stage
        out = f"results/{name}.h5"
        if name not in self._study.graph.stages or out not in self._study.graph.stages[name].outs:
            return None, f"{out} is no result of this study"
        file = self._study.store.place(out)
        if not file.exists():
            return None, f"{shown(file)} is not there"
        try:
            return self._study.result(name), shown(file)
        except StudyError as unfit:
            return None, str(unfit)

    def keep(self, content: bytes) -> None:
        """Keep a proof, made or checked here, beside the study's results."""
        if not self._study.borrowed:
            keep_proof(self._study, content)

    @contextlib.contextmanager
    def new_file(self, path: Path) -> Iterator[Path]:
        """A path to write a file or folder to, which appears as `path` at the end, whole or not at all.

        Raises `StudyError` if something stands there already.
        """
        vacant(path)
        for left in path.parent.glob(f".{glob.escape(path.name)}.*.part"):
            self.note(f"note: {shown(left)} was left by a command that was killed, unless one writes {path.name} now")
        with disk.whole(path) as unfinished:
            yield unfinished

    @contextlib.contextmanager
    def new_table(
        self, path: Path | None, columns: Sequence[Any], size: int, about: Mapping[str, str]
    ) -> Iterator[BlockTable]:
        """A table to fill block by block, in a new file as `new_file` gives; without a path in a temporary one."""
        with contextlib.ExitStack() as until_filled:
            if path is None:
                unfinished = Path(until_filled.enter_context(tempfile.TemporaryDirectory()), "table.h5")
            else:
                unfinished = until_filled.enter_context(self.new_file(path))
            table = BlockTable(unfinished, columns, size, self.heads(columns, about))
            yield until_filled.enter_context(contextlib.closing(table))

    def leave(self, answer: Any, into: Path) -> None:
        """Write what an answer leaves into a new folder: its files, and the parameter files with its values."""
        if not answer.files and not answer.parameters:
            self.note(f"note: this answer leaves nothing; {shown(into)} was not made")
            return
        files = dict(answer.files)
        if answer.parameters:
            source = " ".join(["bipedstudy", *sys.argv[1:]])
            files |= rewritten(self._study.params, answer.parameters, self._study.settings, source)
        with self.new_file(into) as folder:
            folder.mkdir()
            for name, content in files.items():
                disk.write(folder / name, content)

    def heads(self, columns: Sequence[Any], about: Mapping[str, str]) -> dict[str, Mapping[str, str]]:
        """Attributes of a table's groups, as artefacts have: program, stage, question, parameters but the columns."""
        named = {column.name for column in columns}
        fixed = {file: {key: value for key, value in values.items() if f"{file}.{key}" not in named}
                 for file, values in loading.as_plain(self._parameters).items()}  # fmt: skip
        made = {"stage": self._stage, "question": self._question.name, "parameters": parameter_text(fixed)}
        return {"/": self._study.about, artefact.PROVENANCE: made, "table": about}

    def _key(self, function: Callable[..., Any], closure: Closure, shared: str) -> str:
        """What the function's answers follow from beside its arguments: question, code, parameters, packages."""
        parts = {
            "question": [self._stage, self._question.name, function.__qualname__, shared],
            "code": closure.files,
            "versions": versions(closure.foreign),
            "parameters": loading.as_plain(self._parameters),
        }
        return disk.digest(json.dumps(parts, sort_keys=True).encode())[:32]


def vacant(path: Path) -> None:
    """Raise `StudyError` if something stands at `path` already."""
    if path.exists():
        raise StudyError(f"{shown(path)}: is there already, and is not replaced")


def answered(row: Row) -> Row:
    """The row, if it holds an answer. Raises `Declined` for a stage's own refusal, `StageFailed` for any other."""
    if row.outcome == COMPUTED:
        return row
    if row.outcome == NO_ANSWER:
        raise Declined(row.reason)
    how = f"a process of this question failed: {row.reason}"
    raise StageFailed(f"{how}; what is done is kept: asked again, it goes on from there")


class _Kept(io.FileIO):
    """A file whose first error is kept: HDF5 would meet it again in all that it closes, and may end the process."""

    failed: OSError | None = None

    def write(self, content: Any) -> int:
        left = memoryview(content)
        try:
            while left:
                left = left[super().write(left):]
        except OSError as error:
            self.failed = self.failed or error
        return len(content)

    def truncate(self, size: int | None = None) -> int:
        try:
            return super().truncate(size)
        except OSError as error:
            self.failed = self.failed or error
            return size or 0


class BlockTable:
    """A table in HDF5 that is filled block by block, so that it may be larger than memory.

    A column for each declared one (name, unit, description, words), `size` rows. A column with words holds their
    places among the words, and HDF5 knows the words. The same blocks in the same order give the same bytes: a
    compressed chunk that is filled a second time moves in the file.
    """

    def __init__(
        self, path: Path, columns: Sequence[Any], size: int, heads: Mapping[str, Mapping[str, str]]
    ) -> None:
        self._path, self._kept = path, _Kept(path, "w+")
        self._file = h5py.File(self._kept, "w", libver=("v110", "v110"), track_order=True)
        self._file.attrs["format"] = artefact.FORMAT
        self._table = self._file.create_group("table", track_order=True)
        for group, said in heads.items():
            self._file.require_group(group).attrs.update(said)
        storage = {"chunks": (min(_CHUNK, size),), "compression": "gzip", "shuffle": True}
        row = hdf5.row_scale(self._table, "row", size, **storage)
        self._columns: dict[str, Any] = {}  # kept open: one that is closed compresses what is there of its chunk
        for column in columns:
            words = {word: place for place, word in enumerate(column.words)}
            stored = self._table.create_dataset(
                column.name, size, h5py.enum_dtype(words, np.int8) if words else np.dtype(float), track_times=False,
                **storage)  # fmt: skip
            describe(stored, {"unit": column.unit, "description": column.description})
            if words:  # as the CF conventions have it
                stored.attrs["flag_values"] = np.array([*words.values()], dtype=np.int8)
                stored.attrs["flag_meanings"] = " ".join(word.replace(" ", "_") for word in words)
            stored.dims[0].attach_scale(row)
            self._columns[column.name] = stored

    def write(self, first: int, values: Mapping[str, np.ndarray]) -> None:
        """Values of columns, in the rows from `first` on. Raises OSError where there is no room for them."""
        for name, part in values.items():
            column = self._columns[name]
            column[first : first + len(part)] = np.asarray(part).astype(column.dtype)
        self._check()

    def read(self, name: str, every: int = 1) -> np.ndarray:
        """A column, or each so manyth row of it."""
        return np.asarray(self._columns[name][::every])

    def close(self) -> None:
        """Write what is left, and close the file. Raises OSError as `write` does."""
        self._file.close()
        self._kept.close()
        self._check()

    def _check(self) -> None:
        if error := self._kept.failed:
            error.filename = str(self._path)
            raise error
