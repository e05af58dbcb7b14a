"""Computes the points of a job, one after another, in a process of its own: for a run one, for a sweep as many as come,
for a question the parts of its answer.

The first line on standard input is the job with a folder for files, every further line holds points. Messages go back
as lines of JSON: each point is announced before it begins, so that whoever listens knows which one a crash or a hang
belongs to, and ends with `done` or `failed`. When standard input closes, whoever asked is gone: the worker empties its
folder and ends, and what it started.

The stages' modules are imported from their source, and it is remembered which text was used. A source can be edited
while a stage runs, and a compiled file beside it can be older than an edit made within the same second. So the worker
reads the source itself and compiles that text, and checks afterwards that this is what the key says.
"""

import contextlib
import dataclasses
import importlib.abc
import importlib.machinery
import importlib.util
import json
import os
import queue
import shutil
import signal
import sys
import threading
import time
import traceback
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, NoReturn

import numpy as np

from pipeline.cache import artefact, disk
from pipeline.cache.differences import closer
from pipeline.cache.fingerprint import versions
from pipeline.cache.sources import Sources, beside
from pipeline.errors import Lacking, StudyError, is_answer
from pipeline.execution.inputs import CLOSER, check_unchanged, given
from pipeline.execution.job import File, Job, Point, engine_code
from pipeline.graph import Stage, beneath, is_inside
from pipeline.home import home_of, importable, named, stage_module
from pipeline.parameters import loading
from pipeline.room.confine import enter, of_code, when_parent_ends
from pipeline.room.watch import watched


class ObservedSources(importlib.abc.MetaPathFinder):
    """Finder for one package; `loaded` maps each file (from the code root) to the source bytes that were executed."""

    def __init__(self, code_root: Path, package: str) -> None:
        self.sources = Sources(code_root, package, beside(code_root / package))
        self.loaded: dict[str, bytes] = {}

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Spec of a module of the package, None for all others."""
        if fullname.split(".")[0] != self.sources.package:
            return None
        found = self.sources.file(fullname)
        if found is None:
            return None
        file = self.sources.code_root / found
        search = [str(file.parent)] if file.name == "__init__.py" else None
        loader = _Loader(fullname, str(file), self)
        return importlib.util.spec_from_file_location(fullname, file, loader=loader, submodule_search_locations=search)


class _Loader(importlib.machinery.SourceFileLoader):
    def __init__(self, fullname: str, path: str, observed: ObservedSources) -> None:
        super().__init__(fullname, path)
        self._observed = observed

    def get_code(self, fullname: str) -> CodeType:
        """Code of the source as it is now."""
        path = self.get_filename(fullname)
        source = self.get_data(path)
        name = Path(path).relative_to(self._observed.sources.code_root).as_posix()
        self._observed.loaded[name] = source
        code: CodeType = compile(source, path, "exec", dont_inherit=True)
        return code


_REPORT_EVERY_S = 0.1
#: Entries of an array that each have a column of their own, at most.
_MOST_ENTRIES = 16


class Unfit(StudyError):
    """Why this process can compute none of the job's points: other code, other versions. `file` is edited code."""

    def __init__(self, text: str, file: str = "") -> None:
        super().__init__(text)
        self.file = file


class Messages:
    """The way back. Standard output itself becomes standard error: libraries print what they like."""

    def __init__(self) -> None:
        self._file = os.fdopen(os.dup(1), "w", encoding="utf-8")
        if hasattr(os, "register_at_fork"):  # the end of this process must show, whatever it forked
            os.register_at_fork(after_in_child=self._file.close)
        os.dup2(2, 1)
        self._reported = 0.0

    def send(self, **message: Any) -> None:
        """Send one line."""
        self._file.write(json.dumps(message) + "\n")
        self._file.flush()

    def progress(self, fraction: float, what: str) -> None:
        """Send how far a stage is, now and then."""
        now = time.monotonic()
        if now - self._reported >= _REPORT_EVERY_S:
            self._reported = now
            self.send(progress=[min(1.0, max(0.0, float(fraction))), str(what)])


def main() -> NoReturn:
    """Entry of `python -m pipeline.execution.worker`, and of a forked worker."""
    when_parent_ends(getattr(signal, "SIGCONT", 0))  # should somebody have stopped it, it then finds its input closed
    messages = Messages()
    received, lines = _received(), queue.SimpleQueue[bytes]()
    package = ""
    try:
        folder, text = json.loads(next(received))
        job = Job.of(text)
        package = job.package
        tasks = json.loads(next(received))
        enter(job, Path(folder), tasks)  # before there is another thread, which would not be confined
        threading.Thread(target=_listen, args=(received, lines, folder), daemon=True).start()
        computing = Computing(job, Path(folder), messages)
        while True:
            for index, point in tasks:
                messages.send(began=index)
                messages.send(index=index, **computing.answer(point))
            tasks = json.loads(lines.get())
    except BaseException as error:
        messages.send(failed=failure(error, package))
    os._exit(1)  # no library's exit handler may come between


class Computing:
    """The chain of stages of one job. What an upstream stage made is kept as long as its parameters stay."""

    def __init__(self, job: Job, folder: Path, messages: Messages) -> None:
        self.job, self.folder, self.messages = job, folder, messages
        home = home_of(job.package, Path(job.code_root))
        self.observed = ObservedSources(home, job.package)
        self._check_machine()
        importable(job.package, home)  # for the processes that a stage starts
        sys.meta_path.insert(0, self.observed)
        with contextlib.suppress(OSError):  # another machine of a sweep need not have the study
            os.chdir(job.root)
        self.checked = 0
        self.files: dict[str, File] = {**job.files, **self._written(job.contents)}
        self.kept: dict[str, tuple[str, dict[str, File]]] = {}

    def answer(self, point: Any) -> dict[str, Any]:
        """What comes of one point, with the seconds it took by the clock and of all processors. Raises `Unfit`."""
        began, used = time.perf_counter(), _processor_seconds()
        try:
            outcome: dict[str, Any] = {"done": self._answer(point)}
        except Unfit:
            raise
        except BaseException as error:
            outcome = {"failed": failure(error, self.job.package)}
            self._check_code()
        return {**outcome, "seconds": round(time.perf_counter() - began, 6),
                "processor_seconds": round(_processor_seconds() - used, 3)}  # fmt: skip

    def _answer(self, point: Any) -> dict[str, Any]:
        if function := self.job.function:
            parameters = self._parameters(function["stage"], function["parameters"])
            answer = named(function["module"], function["name"])(parameters, *function["shared"], point)
            self._check_code()
            return {"answer": answer}
        *above, stage = self.job.stages
        files, token = dict(self.files), ""
        for each in above:
            token = disk.digest(token.encode() + json.dumps(point[each.name]).encode())
            if self.kept.get(each.name, ("", {}))[0] != token:
                upstream, _ = self._result(each, point, files)
                made = _files(each, upstream, artefact.encode(upstream, {}))
                for file, _ in self.kept.pop(each.name, ("", {}))[1].values():
                    Path(file).unlink()
                self.kept[each.name] = token, self._written(made)
            files.update(self.kept[each.name][1])
        if self.job.provenance is None:
            return _columns(self._result(stage, point, files)[0])
        return self._stored(stage, *self._result(stage, point, files, errors=True))

    def _result(
        self, stage: Stage, point: Point, files: dict[str, File], *, errors: bool = False
    ) -> tuple[Any, Any]:
        """A stage's result; with `errors` that of closer solvers, from what these gave above, too, or why not."""
        module = stage_module(self.job.package, stage.name, "run")
        plain, chosen = point[stage.name]
        parameters = self._parameters(stage.name, plain)
        other, near = getattr(module, "ONCE", None), closer(parameters)
        again = getattr(module, "again", None)
        errors = errors and (again is not None or not other)
        inputs, above, open_files = given(self.job.package, stage, parameters, chosen, files, errors, self.folder)
        declared = [file for file, _ in open_files.values()]
        code = of_code(self.observed.sources.code_root, self.job.package)
        with watched(self.job.root, *code, self.folder, *declared):
            result = module.run(parameters, inputs, self.messages.progress)
        if errors and (near != parameters or above is not None):
            self.messages.send(progress=[1.0, "once more, closer, for the errors of its numbers"])
            try:
                read = inputs if above is None or (again and hasattr(inputs, CLOSER)) else above
                other = again(near, read, result) if again else module.run(near, read)
            except Exception as error:  # whatever it is, the result itself stands
                other = " ".join(f"at closer settings: {error}".split())
        check_unchanged(open_files)
        self._check_code()
        return result, other

    def _parameters(self, stage: str, plain: Mapping[str, Mapping[str, Any]]) -> Any:
        return loading.from_plain(stage_module(self.job.package, stage, "parameters").Parameters, plain)

    def _stored(self, stage: Stage, result: Any, other: Any) -> dict[str, Any]:
        """Write the files of a result; what they are, and its summary. Their digest is without provenance."""
        files, summary = _files(stage, result, b""), " ".join(str(result.summary()).split())
        content = {name: disk.digest(data) for name, data in files.items() if name != stage.artefact}
        beside = "\n".join(f"{each} {len(files[name])} {name}" for name, each in sorted(content.items()))
        made = {**(self.job.provenance or {}), "summary": summary, "files": beside}
        plain, files[stage.artefact] = artefact.encoded(result, made, self.job.about, other)
        content[stage.artefact] = disk.digest(plain)
        for name, data in files.items():
            disk.write(self.folder / name, data)
        outs = {
            name: {"sha256": disk.digest(data), "size": len(data), "content": content[name]}
            for name, data in sorted(files.items())
        }
        return {"outs": outs, "summary": summary}

    def _written(self, contents: Mapping[str, bytes]) -> dict[str, File]:
        """Put files where the stages of this process find them; no one needs them after it."""
        for name, data in contents.items():
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            (self.folder / name).write_bytes(data)
        return {name: (str(self.folder / name), disk.digest(data)) for name, data in contents.items()}

    def _check_machine(self) -> None:
        here = versions([*self.job.versions])
        for name, version in self.job.versions.items():
            if here.get(name) != version:
                raise Unfit(f"this machine has {name} {here.get(name)} instead of {version}; "
                            "all machines of a sweep need the same versions")  # fmt: skip
        own = engine_code() if self.job.engine else {}
        for name in sorted(own.keys() | self.job.engine.keys()):
            if own.get(name) != self.job.engine.get(name):
                raise Unfit(f"{name} differs from what the sweep was started with")

    def _check_code(self) -> None:
        """The code that ran must be the code the results' keys were made from."""
        if len(self.observed.loaded) == self.checked:
            return
        for name, source in self.observed.loaded.items():
            if name not in self.job.code:
                raise Unfit(f"it imports {name} in a way that cannot be seen in the text; import it by name")
            if self.job.code[name] != self.observed.sources.memo.meaning(source).tree:
                raise Unfit(f"{name} was edited while it ran, so its result was not kept; run again", name)
        self.checked = len(self.observed.loaded)


def _columns(result: Any, prefix: str = "") -> dict[str, Any]:
    """Numbers and words of a result, for a row of a table, by name: mass.shell; of small arrays each: matrix.0.1."""
    found: dict[str, Any] = {}
    for item in dataclasses.fields(result):
        value, name = getattr(result, item.name), prefix + item.name
        if dataclasses.is_dataclass(value):
            found.update(_columns(value, name + "."))
        elif isinstance(value, Mapping):
            found.update({f"{name}.{key}": part for key, part in value.items() if isinstance(part, (int, float))})
        elif isinstance(value, (bool, np.bool_)):
            found[name] = bool(value)
        elif isinstance(value, (int, float, str, np.number)):
            found[name] = value.item() if isinstance(value, np.number) else value
        elif isinstance(value, np.ndarray) and value.dtype.kind in "biuf" and value.size <= _MOST_ENTRIES:
            found.update({name + "".join(f".{at}" for at in place): value[place].item()
                          for place in np.ndindex(value.shape)})  # fmt: skip
    return found


def _processor_seconds() -> float:
    """Of this process, and of those that it started and that have ended [s]."""
    return time.process_time() + sum(os.times()[2:4])


def failure(error: BaseException, package: str) -> dict[str, Any]:
    """Kind, sentence, and where: a class of the stages' own is a reasoned refusal; what has no sentence is unexpected.

    The traceback goes to standard error.
    """
    traceback.print_exception(error)
    sys.stderr.flush()
    text = " ".join(str(error).split())
    kind = "unexpected"
    if isinstance(error, StudyError):
        kind = "lacking" if isinstance(error, Lacking) else "refused"
    elif is_answer(error, package):
        kind = "answer"
    elif isinstance(error, OSError) and error.errno is not None:
        kind, text = "system", f"{f'{error.filename}: ' if error.filename else ''}{os.strerror(error.errno)}"
    elif isinstance(error, MemoryError):
        kind, text = "system", "not enough memory"
    else:
        text = f"{type(error).__name__}: {text}" if text else type(error).__name__
    last = traceback.extract_tb(error.__traceback__)[-1]
    at = f"{Path(last.filename).name}:{last.lineno}"
    return {"kind": kind, "text": text, "at": at, "file": getattr(error, "file", "")}


def _files(stage: Stage, result: Any, encoded: bytes) -> dict[str, bytes]:
    """The files of a result that is `encoded`. Those beside the artefact must be what dvc.yaml declares, no more and no
    fewer.
    """
    files = {f"results/{name}": bytes(data) for name, data in getattr(result, "files", {}).items()}
    declared = [out for out in stage.outs if out != stage.artefact]
    for name in files:
        if not is_inside(name) or not any(beneath(out, [name]) for out in declared):
            raise StudyError(f"it returned the file {name}, which dvc.yaml does not list among its outs")
    for out in declared:
        if not beneath(out, files):
            raise StudyError(f"it did not return {out}, which dvc.yaml lists among its outs")
    return {**files, stage.artefact: encoded}


def _received() -> Iterator[bytes]:
    """The lines of standard input."""
    begun = b""
    while part := os.read(0, 1 << 16):  # sys.stdin would be locked meanwhile, and a forked process closes its own
        *whole, begun = (begun + part).split(b"\n")
        yield from whole


def _listen(received: Iterator[bytes], lines: queue.SimpleQueue[bytes], folder: str) -> NoReturn:
    for line in received:
        lines.put(line)
    shutil.rmtree(folder, ignore_errors=True)
    if hasattr(os, "killpg") and os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGKILL)  # this process, and whatever it started itself
    os._exit(1)


if __name__ == "__main__":
    main()
