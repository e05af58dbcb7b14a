"""What a question is handed while it is asked: progress, a pool whose answers are kept, new files."""

from __future__ import annotations

import contextlib
import json
import multiprocessing
import os
import pickle
import shutil
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from pipeline.cache import durable
from pipeline.cache.distributions import versions
from pipeline.cache.store import QUESTIONS
from pipeline.errors import StageFailed, Stopped, StudyError
from pipeline.execution.process import continue_when_parent_ends
from pipeline.parameters import loading
from pipeline.parameters.rewriting import rewritten
from pipeline.questions.block_table import BlockTable
from pipeline.study import Study, shown
from pipeline.sweep.journal import Journal
from pipeline.sweep.row import COMPUTED, Row

#: A terminal has a bar after so long at the latest; elsewhere there is a line this often.
_BAR_AFTER_S, _LINE_EVERY_S = 1.0, 10.0


class Asked:
    """One question while it is asked of a stage with its parameters; use as a context manager."""

    def __init__(self, study: Study, stage: str, question: Any, parameters: Any, jobs: int | None) -> None:
        self.jobs = jobs or os.cpu_count() or 1
        self._study, self._stage, self._question, self._parameters = study, stage, question, parameters
        self._done, self._of = 0, 0
        self._bar: Any = None
        self._said = time.monotonic()
        self._terminal = threading.RLock()
        self._soon = threading.Timer(_BAR_AFTER_S, self._still_at_it)
        self._soon.daemon = True

    def __enter__(self) -> Asked:
        if sys.stderr.isatty():
            self._soon.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *ending: object) -> None:
        self.close()
        if kind is KeyboardInterrupt:
            done = f"{self._done} of {self._of} parts are done and kept: asked again, it goes on from there"
            raise Stopped(f"stopped; {done if self._of else 'nothing of this answer is kept'}") from None

    def close(self) -> None:
        """Give the terminal back."""
        self._soon.cancel()
        with self._terminal:
            if self._bar is not None:
                self._bar.stop()
                self._bar = None

    def _still_at_it(self) -> None:
        """Open a bar without an end: the question has not yet said how far it is."""
        with self._terminal:
            if self._bar is None and not self._soon.finished.is_set():
                self._show(None, "computing")

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
            with self._terminal:
                self._show(min(1.0, max(0.0, fraction)), what)
        elif time.monotonic() - self._said >= _LINE_EVERY_S:
            self._said = time.monotonic()
            print(f"{100 * fraction:.0f} %: {what}", file=sys.stderr, flush=True)

    def _show(self, fraction: float | None, what: str) -> None:
        if self._bar is None:
            from rich.console import Console
            from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

            columns = BarColumn(), TimeElapsedColumn(), TextColumn("{task.description}", markup=False)
            self._bar = Progress(*columns, transient=True, console=Console(stderr=True))
            self._bar.add_task("", total=None)
            self._bar.start()
        total = None if fraction is None else 1.0
        self._bar.update(self._bar.task_ids[0], total=total, completed=fraction or 0.0, description=what)

    def say_if_cold(self) -> None:
        """Say so if the stage compiles its code at this use, as its module `compiled` knows."""
        compiled = self._study.module(self._stage, "compiled")
        if compiled is not None and compiled.CODE.is_cold():
            self.note(f"note: stage {self._stage}: {compiled.COMPILING}")

    def each(self, function: Callable[[Any], Any], arguments: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        """Number of an argument and the function's answer: first those kept from before, then as they get ready."""
        if self._study.borrowed:
            raise StudyError("the parts of this answer are kept in a study's results: ask inside a study, or say with "
                             "--results where they go")  # fmt: skip
        path = self._study.store.folder / QUESTIONS / f"{self._key(function)}.jsonl"
        keys = [durable.digest(pickle.dumps(argument)) for argument in arguments]
        try:
            journal = Journal(path)
        except OSError as error:
            raise StudyError(f"{shown(path.parent)}: cannot be written ({error.strerror}); choose another folder with "
                             "--results") from None  # fmt: skip
        with journal:
            waiting = {number: arguments[number] for number, key in enumerate(keys) if key not in journal}
            self._done, self._of = len(arguments) - len(waiting), len(arguments)
            for number, key in enumerate(keys):
                if number not in waiting:
                    yield number, journal.row(key).values["answer"]
            for number, answer in side_by_side(function, waiting, self.jobs):
                journal.add(keys[number], Row(COMPUTED, "", {"answer": answer}))
                self._done += 1
                self.progress(self._done / self._of, f"{self._done} of {self._of}")
                yield number, journal.row(keys[number]).values["answer"]

    @contextlib.contextmanager
    def new_file(self, path: Path) -> Iterator[Path]:
        """A path to write a file or folder to, which appears as `path` at the end, whole or not at all.

        Raises `StudyError` if something stands there already.
        """
        if path.exists():
            raise StudyError(f"{shown(path)}: is there already, and is not replaced")
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_name(f".{path.name}.{os.getpid()}.part")
        try:
            yield unfinished
            unfinished.replace(path)
            durable.sync_folder(path.parent)
        finally:
            if unfinished.is_dir():
                shutil.rmtree(unfinished)
            unfinished.unlink(missing_ok=True)

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
            yield until_filled.enter_context(contextlib.closing(BlockTable(unfinished, columns, size, about)))

    def leave(self, answer: Any, folder: Path) -> None:
        """Write what an answer leaves into a new folder: its files, and the parameter files with its values."""
        files = dict(answer.files)
        if answer.parameters:
            source = " ".join(["bipedstudy", *sys.argv[1:]])
            files |= rewritten(self._study.params, answer.parameters, self._study.settings, source)
        folder.mkdir()
        for name, content in files.items():
            durable.write(folder / name, content)

    def _key(self, function: Callable[[Any], Any]) -> str:
        """What the function's answers follow from beside its arguments: question, code, parameters, packages."""
        package = self._study.package
        own = (f"{package}.{self._stage}.parameters", type(self._parameters).__module__, function.__module__)
        closure = self._study.sources.closure(own)
        parts = {
            "question": [self._stage, self._question.name, function.__qualname__],
            "code": closure.files,
            "versions": versions(closure.foreign),
            "parameters": loading.as_plain(self._parameters),
        }
        return durable.digest(json.dumps(parts, sort_keys=True).encode())[:32]


def side_by_side(
    function: Callable[[Any], Any], arguments: Mapping[int, Any], jobs: int
) -> Iterator[tuple[int, Any]]:
    """Number and answer of each argument as they get ready, from `jobs` processes; an error of a call is raised here.

    One process is this one. The others end with this one, however it ends.
    """
    jobs = min(jobs, len(arguments))
    if jobs <= 1:
        yield from ((number, function(argument)) for number, argument in arguments.items())
        return
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_end_with_parent)
    try:
        waiting = {pool.submit(function, argument): number for number, argument in arguments.items()}
        for done in as_completed(waiting):
            yield waiting.pop(done), done.result()  # not kept: a question may have more answers than memory
        pool.shutdown()
    except BrokenProcessPool:
        raise StageFailed("a process of this question was ended by the system; asked again, it goes on from there"
                          ) from None  # fmt: skip
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for child in multiprocessing.active_children():
            child.terminate()


def _end_with_parent() -> None:
    continue_when_parent_ends()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # an interrupt is the parent's to tell
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
