"""Kills the real study, many times to one run: kill -9, resume, kill again at a random moment of the stage under way.

Run: python -m benchmarks.killed_study [kills] [file for the table] [results]; the whole of it takes most of an hour.
First the study of the working folder is run undisturbed, one stage at a time, unless its results are given. Then a run
into another folder is killed until every artefact is there, and each file must be the undisturbed run's byte for byte;
one more folder takes the kills that came too late. Ends with 1 if anything was lost or wrong. `docs/faults.md` has the
table.

Each stage is killed ten times at a moment drawn evenly from its time (but for the last kill from its first four fifths,
as a stage that is done can be killed no more); the kills that are left come at moments whose logarithm is drawn evenly,
so that starts and short stages are hit often. One in five takes the worker process first, and the run when it has
noticed (it would go on with stages that do not need the lost one); the others take the run. Results
are *lost* if a stage that had finished computes again, *wrong* if a file in the results folder is ever another one than
in the undisturbed run.
"""

import contextlib
import json
import os
import queue
import random
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from pipeline.cache import disk
from pipeline.study import locate
from tests.pipeline.processes import started

_EVENLY = 10
_BEFORE_ITS_END = 0.8
_SHORTEST_S = 0.01
_MOST_FOLDERS = 4
_WORKER_SHARE = 0.2
_GONE_S = 20.0
_NOT_RESULTS = ("log", "log.jsonl", "report.html", "README.md", "sweeps", "drawn", "differences")
_WITHOUT_A_SENTENCE = re.compile("Traceback|unexpected")


@dataclass
class Count:
    """What came of the kills so far."""

    hit: Counter[str] = field(default_factory=Counter)
    survived: int = 0
    of_workers: int = 0
    lost: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)
    told: list[str] = field(default_factory=list)

    def lines(self) -> list[str]:
        """The table, and what it does not say."""
        kills = sum(self.hit.values())
        stages = ", ".join(f"{stage} {count}" for stage, count in self.hit.items())
        return ["| killed | kills | survived | lost | wrong | without a sentence |", "|---|---|---|---|---|---|",
                f"| the real study ({kills - self.of_workers} times the run, {self.of_workers} times its worker) "
                f"| {kills} | {self.survived} | {len(self.lost)} | {len(self.wrong)} | {len(self.told)} |",
                "", f"Kills by the stage that was under way: {stages}."]  # fmt: skip


class Killed:
    """A study that is killed again and again. `right` is file -> digest, `seconds` what each stage takes."""

    def __init__(self, right: Path, folder: Path, chance: random.Random) -> None:
        self.right, self.folder, self.chance = digests(right), folder, chance
        self.seconds = {}
        for line in (right / "log.jsonl").read_text(encoding="utf-8").splitlines():
            entry = json.loads(line)
            if entry["how"] == "computed":
                self.seconds[entry["stage"]] = float(entry["seconds"])
        self.count = Count()
        self.ended = 0
        self.anew()

    def anew(self) -> None:
        """Begin the study in another folder."""
        self.results = self.folder / f"results-{self.ended}"
        self.finished: set[str] = set()

    def check_end(self) -> None:
        """Hold every file of a study that came to its end against those of the undisturbed run."""
        found = digests(self.results)
        differ = [name for name in sorted({*found, *self.right}) if found.get(name) != self.right.get(name)]
        self.count.wrong += [f"{name} at the end" for name in differ]
        self.ended += 1

    def run(self, kills_of: dict[str, int]) -> bool:
        """Start a run and kill it in a stage that `kills_of` has kills left for. False if it came to its end."""
        process = start(self.results)
        events: queue.SimpleQueue[str] = queue.SimpleQueue()
        threading.Thread(target=_pass_on, args=(process, events), daemon=True).start()
        errors: list[str] = []
        listening = threading.Thread(target=lambda: errors.append(process.stderr.read() if process.stderr else ""))
        listening.start()
        under_way, began, moment, victim = "", 0.0, float("inf"), ""
        while True:
            try:
                line = events.get(timeout=max(0.0, min(moment - time.monotonic(), 1e6)))
            except queue.Empty:
                break
            words = line.split()
            if not words:
                moment = float("inf")
                break
            if words[1:2] == ["computing:"]:
                under_way = words[0]
                if under_way in self.finished:
                    self.count.lost.append(f"{under_way} computed again: {line}")
                if kills_of.get(under_way, 0) and moment == float("inf"):
                    moment = time.monotonic() + self._moment(under_way, kills_of[under_way])
                    victim = "worker" if self.chance.random() < _WORKER_SHARE else "run"
                began = time.monotonic()
            elif words[1:2] and words[1] in ("computed", "restored", "current"):
                self.finished.add(words[0])
                if words[1] == "computed":
                    self.seconds[words[0]] = time.monotonic() - began
        there = started(process.pid)
        if moment < float("inf"):
            if victim == "worker":
                _kill(there[-1:])  # the stage's, or the one that would fork it
                self._notice(under_way, events)
            _kill([process.pid])
            kills_of[under_way] = max(0, kills_of.get(under_way, 0) - 1)
        code = process.wait()
        listening.join()
        told = _WITHOUT_A_SENTENCE.search(errors[0])
        if told or (moment == float("inf") and code):
            self.count.told.append(f"{under_way}, {code}: {errors[0][-2000:]}")
        left = _still_there(there)
        wrong = [name for name, digest in digests(self.results).items() if self.right.get(name) != digest]
        self.count.wrong += [f"{name} after a kill in {under_way}" for name in wrong]
        if moment < float("inf"):
            self.count.hit[under_way] += 1
            self.count.of_workers += victim == "worker"
            self.count.survived += not (told or wrong or left)
            if left:
                self.count.told.append(f"{under_way}: processes {left} outlived the run")
        return moment < float("inf")

    def _moment(self, stage: str, left: int) -> float:
        longest = self.seconds.get(stage, 1.0) * (1.0 if left == 1 else _BEFORE_ITS_END)
        if left <= _EVENLY:
            return self.chance.uniform(0.0, longest)
        return float(_SHORTEST_S * (longest / _SHORTEST_S) ** self.chance.random())

    def _notice(self, stage: str, events: queue.SimpleQueue[str]) -> None:
        """Wait until the run tells that a stage failed, or finished just before its worker was killed."""
        with contextlib.suppress(queue.Empty):
            while words := events.get(timeout=_GONE_S).split():
                if words[0] == stage and words[1:2] != ["failed"]:
                    self.finished.add(stage)
                if words[0] == stage:
                    return


def _kill(pids: list[int]) -> None:
    for pid in pids:
        with contextlib.suppress(OSError):
            os.kill(pid, signal.SIGKILL)


def start(results: Path) -> subprocess.Popen[str]:
    """Start a run of the study of the working folder, one stage at a time."""
    words = [sys.executable, "-m", "pipeline.cli", "run-all", "-v", "-j", "1", "--results", str(results)]
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def digests(results: Path) -> dict[str, str]:
    """Digest of every file in a results folder that follows from the study alone."""
    paths = (path for path in sorted(results.rglob("*")) if path.is_file() and not path.name.endswith(".part"))
    named = ((path.relative_to(results), path) for path in paths)
    return {inner.as_posix(): disk.digest(path.read_bytes()) for inner, path in named
            if inner.parts[0] not in (".cache", *_NOT_RESULTS)}  # fmt: skip


def _still_there(pids: list[int]) -> list[int]:
    """Those of the processes that have not ended after a while."""
    end = time.monotonic() + _GONE_S
    while (left := [pid for pid in pids if Path(f"/proc/{pid}").exists()]) and time.monotonic() < end:
        time.sleep(0.05)
    return left


def _pass_on(process: subprocess.Popen[str], events: queue.SimpleQueue[str]) -> None:
    for line in process.stdout or ():
        events.put(line)
    events.put("")


def main() -> None:
    """Kill the study of the working folder and print what came of it."""
    kills = int(sys.argv[1]) if sys.argv[1:] else 200
    table = Path(sys.argv[2]) if sys.argv[2:] else None
    stages = tuple(locate(None, None, ()).graph.stages)
    with tempfile.TemporaryDirectory(prefix="bipedstudy-killed-") as folder:
        right = Path(sys.argv[3]) if sys.argv[3:] else Path(folder, "undisturbed")
        if not sys.argv[3:]:
            undisturbed = start(right)
            undisturbed.communicate()
            if undisturbed.returncode:
                sys.exit("the undisturbed run failed")
        killed = Killed(right, Path(folder), random.Random(1))
        most, more = divmod(max(0, kills - _EVENLY * len(stages)), len(stages))
        evenly = min(_EVENLY, -(-kills // len(stages)))
        kills_of = {stage: evenly + most + (index < more) for index, stage in enumerate(stages)}
        while any(kills_of.values()) and killed.ended < _MOST_FOLDERS:
            killed.anew()
            while killed.run(kills_of):
                _write(table, killed.count.lines())
            killed.check_end()
    lines = [*killed.count.lines(), f"Studies that came to their end, each with {len(killed.right)} files, all of them "
             f"held against the undisturbed run's: {killed.ended}."]  # fmt: skip
    print("\n".join(lines))
    _write(table, lines)
    problems = [*killed.count.lost, *killed.count.wrong, *killed.count.told]
    if problems:
        sys.exit("\n".join(problems))


def _write(table: Path | None, lines: list[str]) -> None:
    if table:
        table.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
