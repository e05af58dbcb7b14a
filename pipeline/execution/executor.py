"""Brings stages up to date: what is current stays, what was computed before is restored, the rest runs.

`survey` shows which stage needs what, and why. Every stage runs in a process of its own, so that a crash in compiled
code ends that stage and nothing else. Whatever ends the run, the results computed before stay valid: files change only
by whole-file renames.
"""

import contextlib
import functools
import json
import queue
import shutil
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.cache import disk, fingerprint
from pipeline.cache.fingerprint import Ingredients
from pipeline.cache.store import Entry, Out
from pipeline.errors import ANSWER, FAILED, StageFailed
from pipeline.execution.display import Display
from pipeline.execution.job import TEMPORARY, job_of, task_of
from pipeline.execution.process import Message, Worker
from pipeline.parameters import loading
from pipeline.study import Study, shown

#: What a stage needs.
CURRENT, RESTORABLE, STALE, WAITING = "current", "restorable", "stale", "waiting"


@dataclass(frozen=True)
class Assessment:
    """State of one stage, its reasons, and, once its inputs are known, what its result would follow from.

    `own` is what else changed about a stage that waits.
    """

    name: str
    state: str
    reasons: tuple[str, ...]
    ingredients: Ingredients | None = None
    entry: Entry | None = None
    own: tuple[str, ...] = ()


def assess(study: Study, values: Mapping[str, Any], name: str, upstream: Mapping[str, Entry]) -> Assessment:
    """State of stage `name` with its parameters among `values`, given the entries of the stages it reads."""
    stage, store = study.graph.stages[name], study.store
    inputs: dict[str, str] = {}
    for path in stage.inputs:
        inputs.update(upstream[study.graph.maker(path)].contents(path))
    inputs.update({key: sha256 for key, (_, sha256) in study.named_files(values[name]).items()})
    parts = fingerprint.ingredients(stage, study.sources, loading.as_plain(values[name]), inputs)
    key, last = fingerprint.key(parts), store.current(name)
    entry = last if last is not None and last.key == key else store.entry(key)
    if entry is None and (arrived := store.arrived(name, key)) is not None and arrived.key == key:
        last = entry = arrived
    if last is None:
        present = [out for out in stage.outs if store.place(out).exists()]
        reasons = [f"{present[0]} is there, but nothing says how it was made"] if present else ["never run"]
    else:
        reasons = list(fingerprint.changes(last.ingredients, parts)) or store.disturbed(last)
    if entry is None:
        return Assessment(name, STALE, tuple(reasons) or ("its stored result is gone",), parts)
    return Assessment(name, RESTORABLE if reasons else CURRENT, tuple(reasons), parts, entry)


def survey(study: Study, values: Mapping[str, Any]) -> list[Assessment]:
    """State of all stages in `values` (parameters by name, in order, with everything upstream), which runs nothing."""
    entries: dict[str, Entry] = {}
    found = []
    for name in values:
        if waits_for := [above for above in study.graph.upstream(name) if above not in entries]:
            reasons = tuple(f"input {above} will be computed first" for above in waits_for)
            found.append(Assessment(name, WAITING, reasons, own=_own_changes(study, values, name)))
            continue
        found.append(assess(study, values, name, entries))
        if (entry := found[-1].entry) is not None:
            entries[name] = entry
    return found


def _own_changes(study: Study, values: Mapping[str, Any], name: str) -> tuple[str, ...]:
    """What changed about a stage but its inputs since its result was computed."""
    last = study.store.current(name)
    if last is None:
        return ()
    plain, before = loading.as_plain(values[name]), last.ingredients["inputs"]
    parts = fingerprint.ingredients(study.graph.stages[name], study.sources, plain, before)
    return tuple(fingerprint.changes(last.ingredients, parts))


_LOG = "stage.log"
REFUSED, FAILING = "refused", "failed"


@dataclass(frozen=True)
class Outcome:
    """How a stage came to be up to date: current, restored or computed; its summary; seconds spent now, by the clock
    and of all processors. Or refused or failed, with the reason in place of the summary.
    """

    stage: str
    how: str
    summary: str
    seconds: float
    reasons: tuple[str, ...]
    key: str
    processor_seconds: float = 0.0


def bring_up_to_date(
    study: Study, values: Mapping[str, Any], display: Display, *, force: Iterable[str] = (), jobs: int = 1
) -> list[Outcome]:
    """Make the results of the stages in `values` current; those in `force` are computed anew.

    `values` maps each stage, in order and with everything upstream, to its checked parameters. Call it under the
    results folder's lock. Raises `StageFailed` after everything that could be done was done. A stage that says no is
    kept as a result without files; what can do without it goes on, as it does where a stage fails.
    """
    run = _Run(study, values, display, frozenset(force), max(1, jobs))
    try:
        run.all([*values])
    finally:
        run.close()
    outcomes = [run.outcomes[name] for name in values]
    if run.failures:
        failed = StageFailed([sentence for _, sentence in run.failures], outcomes)
        failed.exit_code = ANSWER if {code for code, _ in run.failures} == {ANSWER} else FAILED
        raise failed
    return outcomes


#: A stage that is being computed: its worker, the folder it writes to, what it was started for, and when.
_Running = tuple[Worker, Path, Assessment, float]


class _Run:
    """The state of one run: what is done, what is running, what failed."""

    def __init__(
        self, study: Study, values: Mapping[str, Any], display: Display, force: frozenset[str], jobs: int
    ) -> None:
        self.study, self.values, self.display, self.force, self.jobs = study, values, display, force, jobs
        self.entries: dict[str, Entry] = {}
        self.outcomes: dict[str, Outcome] = {}
        self.running: dict[str, _Running] = {}
        self.failures: list[tuple[int, str]] = []
        self.lacking: list[str] = []
        self.broken = set[str]()
        self.events: queue.SimpleQueue[tuple[str, Message]] = queue.SimpleQueue()
        self.log = functools.partial(_add_to_log, study.results / "log.jsonl")

    def all(self, pending: list[str]) -> None:
        """Go through the graph: start what is ready, in the order given, and take in what has finished."""
        self._begin_ready(pending)
        while self.running:
            self._take_event()
            self._begin_ready(pending)
        if self.lacking:
            self.display.note(f"not computed, as they stand on what failed: {', '.join(self.lacking)}")

    def _begin_ready(self, pending: list[str]) -> None:
        """Begin with every stage that waits for nothing; what is current makes more of them ready."""
        while len(self.running) < self.jobs:
            ready = [name for name in pending if self.entries.keys() >= {*self.study.graph.upstream(name)}]
            if not ready:
                return
            pending.remove(ready[0])
            self._guarded(ready[0], self._begin)

    def close(self) -> None:
        """End what still runs and forget its unfinished files."""
        for worker, folder, *_ in self.running.values():
            worker.end()
            shutil.rmtree(folder, ignore_errors=True)
        self.study.sources.memo.save()
        self.display.close()

    def _guarded(self, name: str, action: Any, *arguments: Any) -> None:
        """Carry out one step of a stage; a failing disk ends the stage with a sentence."""
        try:
            action(name, *arguments)
        except OSError as error:
            what = f"{error.strerror or error} ({shown(self.study.results)})"
            self._fail(name, f"its result could not be stored: {what}; earlier results are unchanged")

    def _begin(self, name: str) -> None:
        assessment = assess(self.study, self.values, name, self.entries)
        entry = assessment.entry
        if entry is not None and name not in self.force:
            current = assessment.state == CURRENT
            if current:
                self.study.store.take_in(entry)
            if current or self.study.store.put_in_place(entry):
                self._finish(assessment, entry, CURRENT if current else "restored", 0.0)
                return
            self.study.store.drop(entry.key)
        self._start(assessment)

    def _start(self, assessment: Assessment) -> None:
        name, parts, store = assessment.name, assessment.ingredients, self.study.store
        assert parts is not None
        stage = self.study.graph.stages[name]
        inputs = {
            file: ("", above.summary) if above.refused else (str(store.place(file)), above.outs[file].sha256)
            for path in stage.inputs
            for above in [self.entries[self.study.graph.maker(path)]]
            for file in above.contents(path)
        }
        folder = store.new_folder(fingerprint.key(parts))
        self.study.sources.memo.save()  # so that the worker need not parse them again
        above = [self.entries[each].ingredients for each in self.study.graph.needed_for((name,))
                 if each != name and each in self.entries]  # fmt: skip
        job, task = job_of(self.study, parts, inputs, above), task_of(self.study, {name: self.values[name]})
        reasons = ("requested by --force",) if name in self.force else assessment.reasons
        self.display.started(name, reasons)
        worker = Worker(job, folder, lambda message: self.events.put((name, message)), folder / _LOG)
        self.running[name] = worker, folder, assessment, time.monotonic()
        worker.compute([task])

    def _take_event(self) -> None:
        try:
            name, message = self.events.get(timeout=1.0)
        except queue.Empty:
            return
        if "progress" in message and name in self.running:
            self.display.progress(name, *message["progress"])
        if "began" in message or "progress" in message or name not in self.running:
            return
        worker, folder, assessment, began = self.running.pop(name)
        worker.end()
        seconds = time.monotonic() - began
        failure = message.get("failed", {"kind": "none"})
        if failure["kind"] not in ("none", "answer", "lacking"):
            self._explain(name, folder, failure, seconds)
        elif "failed" in message and self.broken.intersection(self.study.graph.upstream(name)):
            self.lacking.append(name)  # what follows from a failure may be another's next, and is not kept
            self._go_on_without(name, failure["text"])
        else:  # where a stage says no, that is kept in place of a result
            result = message.get("done") or {"outs": {}, "summary": failure["text"]}
            used = 0.0 if "failed" in message else message["processor_seconds"]
            self._guarded(name, self._keep, folder, assessment, result, seconds, used)
        shutil.rmtree(folder, ignore_errors=True)

    def _go_on_without(self, name: str, reason: str) -> None:
        """Let what can do without this stage's result be computed; nothing of this is kept."""
        self.broken.add(name)
        self.entries[name] = Entry(name, {"stage": name, "parameters": {}}, {}, reason, 0.0)
        self.outcomes[name] = Outcome(name, FAILING, reason, 0.0, (), "")

    def _keep(
        self, name: str, folder: Path, assessment: Assessment, done: Message, seconds: float, used: float
    ) -> None:
        assert assessment.ingredients is not None
        outs = {path: Out(**out) for path, out in done["outs"].items()}
        entry = Entry(name, assessment.ingredients, outs, done["summary"], round(seconds, 3))
        (folder / _LOG).unlink(missing_ok=True)
        shutil.rmtree(folder / TEMPORARY, ignore_errors=True)
        store = self.study.store
        if store.keep(folder, entry):
            self.display.note(
                f"{name}: computing it again gave another result than before; the stage is not deterministic"
            )
        if not store.put_in_place(entry):
            store.drop(entry.key)
            self._fail(name, "its result was damaged on its way to the disk; run again")
            return
        self._finish(assessment, entry, "computed", seconds, used)

    def _finish(
        self, assessment: Assessment, entry: Entry, how: str, seconds: float, processor_seconds: float = 0.0
    ) -> None:
        name = assessment.name
        self.entries[name] = entry
        if entry.refused:
            how = REFUSED
            above = [self.entries[each] for each in self.study.graph.upstream(name)]
            if any(each.refused and entry.summary.endswith(each.summary) for each in above):
                self.lacking.append(name)
            else:
                self.failures.append((ANSWER, f"stage {name}: {entry.summary}"))
        if accounts := [shown(self.study.store.place(path)) for path in entry.outs if path.endswith(".log")]:
            sentence = f"stage {name}: {entry.summary}; the full account is in {', '.join(accounts)}"
            self.failures.append((FAILED, sentence))  # some of it went wrong in a way that it did not foresee
        outcome = Outcome(name, how, entry.summary, seconds, assessment.reasons, entry.key, processor_seconds)
        self.outcomes[name] = outcome
        self.display.finished(name, how, seconds, entry.summary)
        if how != CURRENT:
            self.log(stage=name, how=how, seconds=round(seconds, 3), processor_seconds=processor_seconds,
                         key=entry.key, reasons=assessment.reasons)  # fmt: skip

    def _explain(self, name: str, folder: Path, failure: Message, seconds: float) -> None:
        kind, text = failure["kind"], failure["text"]
        said = {"refused": text, "system": f"it did not finish: {text}; earlier results are unchanged"}.get(kind)
        if said is None:
            log = self.study.results / "log" / f"{name}.log"
            said = f"{text}; no log could be kept"
            with contextlib.suppress(OSError):
                disk.write(log, disk.blocks(folder / _LOG))
                said = f"{text}; the full account is in {shown(log)}"
        self._fail(name, said)
        self.log(stage=name, how=FAILING, seconds=round(seconds, 3), text=text)

    def _fail(self, name: str, why: str) -> None:
        self.failures.append((FAILED, f"stage {name}: {why}"))
        self.display.failed(name)
        self._go_on_without(name, why)


def _add_to_log(path: Path, **what: Any) -> None:
    """Append to the side log a line of JSON, with the time. A log that cannot be written never stops a run.

    It says when each stage ran and how long it took. Artefacts carry no times, so that their bytes repeat.
    """
    line = json.dumps({"time": time.strftime("%Y-%m-%dT%H:%M:%S%z"), **what})
    with contextlib.suppress(OSError), disk.opened_at_end(path) as file:
        file.write(line.encode() + b"\n")
