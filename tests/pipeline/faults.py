"""What can happen to a study while it runs or lies there, done to the toy study, and what is counted of it.

A *run* is one fault. It *survived* if the run after it ends well, with the right results, and neither of the two met
an error that the program has no sentence for. *Lost* are results that were stored and whole before the fault, were not
what it damaged, and were not there any more or were computed again. *Wrong* are files that were called current, or
stored under a key, and are not what an undisturbed run makes.
"""

import contextlib
import json
import os
import random
import re
import shutil
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

from pipeline.cache import artefact, disk
from tests.pipeline.counts import Count
from tests.pipeline.toy import HOME, with_commands

FAULTY = Path(__file__).with_name("faulty")
VARIANTS = ((), ("--set", "ground.gravity=5"), ("--set", "picture.extra=true"))
LONGEST_S = 300
_OLD, _NEW = "0.5 * gravity", "0.6 * gravity"


class NoMore(Exception):
    """The fault has no further moments: it went through all of them."""


class Scene:
    """A toy study whose right results are known for each of `VARIANTS`, all of them stored."""

    def __init__(self, root: Path) -> None:
        self.toy = with_commands(root)
        self.results = root / "results"
        self.right: dict[tuple[str, ...], dict[str, bytes]] = {}
        for variant in (*VARIANTS, ()):
            self.toy.says(" ".join(["run-all", *variant]))
            assert self.right.setdefault(variant, self.toy.results()) == self.toy.results()
        self.stored_right = self.stored()
        self.damaged: set[str] = set()
        self.errors = ""

    def stored(self) -> dict[str, dict[str, str]]:
        """Of each entry in the store that is whole: key -> file -> digest of what it says, whatever code made it."""
        store = self.toy.study().store
        entries = [store.entry(path.name) for path in store.folder.iterdir() if path.is_dir()]
        found = {entry.key: entry.outs for entry in entries if entry}
        return {
            key: {name: out.content for name, out in outs.items()}
            for key, outs in found.items()
            if all(disk.digest(disk.read(store.folder / key / name) or b"") == out.sha256 for name, out in outs.items())
        }

    def start(self, *arguments: str, **fault: object) -> subprocess.Popen[str]:
        """Start `bipedstudy`, with a fault of `faulty/sitecustomize.py` where one is given."""
        if not fault:
            return self.toy.start(*arguments)
        fault |= {"below": str(self.results), "mark": str(self.mark)}
        path = os.pathsep.join([str(FAULTY), str(HOME)])
        return self.toy.start(*arguments, environment={"FAULT": json.dumps(fault), "PYTHONPATH": path})

    @property
    def mark(self) -> Path:
        """A file that is there once the fault happened."""
        return self.toy.root / "fault-happened"

    def end(self, process: subprocess.Popen[str]) -> int:
        """Wait for a run, keep what it said, and return its exit code."""
        _, errors = process.communicate(timeout=LONGEST_S)
        self.errors += errors
        return process.returncode

    def current(self, variant: tuple[str, ...]) -> list[str]:
        """Stages that the study calls current for this variant."""
        code, out, errors = self.toy.command("status", "--json", *variant)
        self.errors += errors
        return [item["stage"] for item in json.loads(out) if item["state"] == "current"] if code == 0 else []


Fault = Callable[[Scene, random.Random, int], "tuple[str, ...]"]


def suffer(scene: Scene, fault: Fault, chance: random.Random, number: int, count: Count) -> None:
    """Let one fault happen and count what comes of it. Raises `NoMore` where there is nothing left to do."""
    scene.errors, scene.damaged = "", set()
    before = scene.stored()
    variant = fault(scene, chance, number)
    wanted = _said(scene.right[variant])
    wrong = [
        f"{name} is called current and is not right"
        for name in _files_of(scene.current(variant))
        if _said(scene.toy.results()).get(name) != wanted.get(name)
    ]
    code, out, errors = scene.toy.command("run-all", "--json", "--wait", *variant)
    scene.errors += errors
    hows = json.loads(out)["stages"] if code == 0 else []
    right = _said(scene.toy.results()) == wanted
    if code == 0 and not right:
        wrong.append("a run that ended well left something else than the right results")
    after = scene.stored()
    wrong += [f"{key} is stored with other bytes" for key in after.keys() & scene.stored_right.keys()
              if after[key] != scene.stored_right[key]]  # fmt: skip
    lost = {key for key in before if key not in after and key not in scene.damaged}
    lost |= {item["key"] for item in hows if item["how"] == "computed" and item["key"] in before}
    lost -= scene.damaged
    survived = code == 0 and right and not re.search("Traceback|unexpected", scene.errors)
    count.tried += 1
    count.survived += survived
    count.wrong += [f"number {number}: {text}" for text in wrong]
    count.lost += [f"number {number}: {key} was lost" for key in lost]
    if not survived:
        count.told.append(f"number {number}: not survived ({code}, right: {right}): {scene.errors[-2000:]}")


def _said(files: dict[str, bytes]) -> dict[str, object]:
    """What results say, by name: all but what made them, as an edit elsewhere in the code changes its digest alone."""
    whole = {name for name in files if name.endswith(".h5") and artefact.sealed(files[name]) == files[name]}
    return {name: artefact.provenance(content, name)[artefact.CONTENT] if name in whole else content
            for name, content in files.items()}  # fmt: skip


def _files_of(stages: list[str]) -> list[str]:
    extra = {"side": ["side.bin"], "picture": ["claims.yaml", "figures/one.svg", "figures/two.svg"]}
    return [name for stage in stages for name in (f"{stage}.h5", *extra.get(stage, ()))]


def killed_at_random(scene: Scene, chance: random.Random, number: int) -> tuple[str, ...]:
    """kill -9 at a random moment of a run."""
    variant = chance.choice(VARIANTS)
    process = scene.start("run-all", "--force", *variant)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(chance.uniform(0.05, 2.0))
    process.kill()
    scene.end(process)
    return variant


def broken(scene: Scene, number: int, kind: str, worker: bool) -> tuple[str, ...]:
    """A run, or every stage's process, of which the file operation of this number is broken."""
    variant = () if worker else VARIANTS[number % len(VARIANTS)]
    alone = () if worker else ("--jobs", "1")
    scene.end(scene.start("run-all", "--force", *alone, *variant, kind=kind, at=number + 1, worker=worker))
    if not scene.mark.exists():
        raise NoMore
    scene.mark.unlink()
    return variant


def killed_before_each_operation(scene: Scene, chance: random.Random, number: int) -> tuple[str, ...]:
    """kill -9 of the run before its first, second, ... change of a file."""
    return broken(scene, number, "kill", False)


def worker_killed_before_each_operation(scene: Scene, chance: random.Random, number: int) -> tuple[str, ...]:
    """kill -9 of every stage's process before its first, second, ... change of a file."""
    return broken(scene, number, "kill", True)


def full_from_each_operation(scene: Scene, chance: random.Random, number: int) -> tuple[str, ...]:
    """No room for new files, from the run's first, second, ... change of a file on."""
    return broken(scene, number, "full", False)


def worker_full_from_each_operation(scene: Scene, chance: random.Random, number: int) -> tuple[str, ...]:
    """No room for new files in the stages' processes."""
    return broken(scene, number, "full", True)


def full_disk(scene: Scene, chance: random.Random, number: int) -> tuple[str, ...]:
    """A disk that is really full, with some room left; the study must lie on a small disk of its own."""
    variant, filler = chance.choice(VARIANTS), scene.toy.root / "filler"
    free = shutil.disk_usage(scene.toy.root).free
    filler.write_bytes(bytes(max(0, free - 4096 * chance.randrange(100))))
    scene.end(scene.start("run-all", "--force", *variant))
    filler.unlink()
    return variant


def read_only(scene: Scene, chance: random.Random, number: int) -> tuple[str, ...]:
    """A disk that can only be read; the study must lie on a small disk of its own."""
    variant = chance.choice(VARIANTS)
    subprocess.run(["mount", "-o", "remount,ro", scene.toy.root], check=True)
    try:
        code = scene.end(scene.start("run-all", *variant, *(["--force"] if number % 2 else [])))
    finally:
        subprocess.run(["mount", "-o", "remount,rw", scene.toy.root], check=True)
    if code == 0 and scene.toy.results() != scene.right[variant]:
        raise AssertionError("a run that could not write said that all is well")
    return variant


def clock_set_back(scene: Scene, chance: random.Random, number: int) -> tuple[str, ...]:
    """Every file was written at a time of its own, years ago or years ahead."""
    now = time.time()
    for path in [*scene.results.rglob("*"), *scene.toy.root.glob("params/*"), *scene.toy.path("PACKAGE").rglob("*.py")]:
        moment = now + chance.uniform(-1e9, 1e9)
        os.utime(path, (moment, moment))
    scene.toy.command("--trust", "status")  # what has another time than its place may have been unpacked
    return chance.choice(VARIANTS)


def edited_result(scene: Scene, chance: random.Random, number: int) -> tuple[str, ...]:
    """A result is truncated, changed, emptied, lengthened, deleted, or another design's, by hand."""
    name = chance.choice(sorted(scene.right[()]))
    _spoil(scene.results / name, chance, scene.right[VARIANTS[1]][name])
    return ()


def edited_store(scene: Scene, chance: random.Random, number: int) -> tuple[str, ...]:
    """The same done to a file of the cache, and then another variant asked for."""
    files = sorted(path for path in (scene.results / ".cache").rglob("*") if path.is_file() and path.name != "lock")
    path = chance.choice(files)
    before = scene.stored()
    _spoil(path, chance, chance.choice(files).read_bytes())
    scene.damaged = before.keys() - scene.stored().keys()
    return chance.choice(VARIANTS)


def edited_code(scene: Scene, chance: random.Random, number: int) -> tuple[str, ...]:
    """The physics is edited at a random moment of a run, and edited back at another."""
    process = scene.start("run-all", "--force")
    for old, new in ((_OLD, _NEW), (_NEW, _OLD)):
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(chance.uniform(0.0, 1.5))
        scene.toy.edit("PACKAGE/body/motion.py", old, new)
    scene.end(process)
    return ()


def two_at_once(scene: Scene, chance: random.Random, number: int) -> tuple[str, ...]:
    """Two runs of two designs in one folder; every other time the second waits for the first."""
    variants = chance.sample(VARIANTS, 2)
    wait = ["--wait"] if number % 2 else []
    processes = [scene.start("run-all", "--force", *wait, *variant) for variant in variants]
    codes = [scene.end(process) for process in processes]
    if codes != [0, 0] and (wait or sorted(codes) != [0, 2]):
        raise AssertionError(f"two runs at once ended with {codes}: {scene.errors}")
    return chance.choice(variants)


def _spoil(path: Path, chance: random.Random, other: bytes) -> None:
    content = bytearray(path.read_bytes())
    way = chance.choice(("truncated", "changed", "emptied", "lengthened", "deleted", "another's"))
    if way == "changed" and content:
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    if way == "deleted":
        path.unlink()
        return
    spoilt = {"truncated": content[: chance.randrange(len(content) + 1)], "emptied": b"", "another's": other}
    path.write_bytes(bytes(spoilt.get(way, content + b"x" if way == "lengthened" else content)))


#: Fault, its name, runs in the table (None: until there are no more moments), and whether it needs a small disk.
FAULTS: tuple[tuple[Fault, str, int | None, bool], ...] = (
    (killed_at_random, "run killed (kill -9) at a random moment", 200, False),
    (killed_before_each_operation, "run killed before each of its file operations", None, False),
    (worker_killed_before_each_operation, "stages killed before each of their file operations", None, False),
    (full_from_each_operation, "no room for new files, from each file operation on", None, False),
    (worker_full_from_each_operation, "the same in the stages' processes", None, False),
    (full_disk, "disk full, with 0 to 400 kB left", 40, True),
    (read_only, "disk that can only be read", 20, True),
    (clock_set_back, "clock set back or ahead by up to 30 years", 20, False),
    (edited_result, "result truncated, edited, deleted or swapped by hand", 60, False),
    (edited_store, "file of the cache truncated, edited, deleted or swapped", 100, False),
    (edited_code, "code edited during a run", 20, False),
    (two_at_once, "two runs at once", 20, False),
)


def counted(scene: Scene, fault: Fault, runs: int | None, seed: int = 1) -> Count:
    """Let a fault happen `runs` times, or at all its moments."""
    count, chance, number = Count(), random.Random(seed), 0
    with contextlib.suppress(NoMore):
        while runs is None or number < runs:
            suffer(scene, fault, chance, number, count)
            number += 1
    return count


@contextlib.contextmanager
def small_disk(folder: Path, size: str = "16m"):
    """A disk of its own in memory at `folder`. Raises OSError where this account may not mount one."""
    folder.mkdir(exist_ok=True)
    command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "none", folder]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise OSError(done.stderr.strip())
    try:
        yield folder
    finally:
        subprocess.run(["umount", "--lazy", folder], check=True)
