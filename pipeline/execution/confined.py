"""What a process that computes a stage can still read and write, where the system has Landlock; and a command in a
stranger's study, which loads the stages' parameters and results itself.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

from pipeline import trust
from pipeline.cache import disk
from pipeline.execution.job import TEMPORARY, Job, Task, named_files
from pipeline.execution.process import get_ready
from pipeline.graph import beneath
from pipeline.home import DISTRIBUTION, engine, face, home
from pipeline.room import needed
from pipeline.room.confine import FILES, confine, held
from pipeline.room.reading import beside
from pipeline.stage_modules import home_of


def enter(job: Job, folder: Path, tasks: Sequence[Task]) -> None:
    """Let this process read what dvc.yaml lists for these tasks, the stages' code and what every program needs, and
    write into `folder` and where machine code is kept. It opens no socket. It can never do more again.

    Code that is not this program's own keeps its machine code apart, as loading that runs it.
    """
    place = home_of(job.package, Path(job.code_root))
    own = _own(place, folder / TEMPORARY, any("/machine_code/" in file for file in job.code))
    reads = [*needed.of_code(place, job.package), *_needed(place, job.root), *_inputs(job, tasks)]
    confine(reads, [folder, *own], [place, engine()])


def enter_alone(root: Path, results: Path, package: str) -> None:
    """Keep this command, and what it starts from now on, to a stranger's study, its results and what was typed."""
    words = [word.partition("=")[2] if word.startswith("--") and "=" in word else word for word in sys.argv[1:]]
    kept = results / ".cache"
    writes = [root, results, kept, *(Path(into) for word, into in pairwise(sys.argv) if word == "--results")]
    for folder in writes:
        folder.mkdir(parents=True, exist_ok=True)
    own = _own(root, kept / TEMPORARY, True)
    get_ready()  # a process that runs none of the study's code
    program = [trust.place(), engine() / package, face(),
               *(home() / part for part in ("dvc.yaml", "params", "requirements")),
               *(engine() / ".git" / part for part in ("HEAD", "refs", "packed-refs"))]  # fmt: skip
    confine([*map(Path, words), *program, *_needed(root)], [*writes, *own], [engine()], signals=True)
    if FILES not in held:
        print(f"note: without Landlock what lies in {root} can read and change all that you can", file=sys.stderr)


def _own(place: Path, temporary: Path, compiles: bool) -> list[Path]:
    """Folders of this program that code in `place` may write, the temporary one and that of machine code."""
    temporary.mkdir(exist_ok=True)  # a killed run's folder may be swept away by now, and is not made again
    os.environ["TMPDIR"], tempfile.tempdir = str(temporary), None
    if not compiles:
        return [temporary, Path(needed.SHARED)]
    kept = needed.machine_code()
    if place != engine() and not kept.parent.name.startswith("of-"):
        kept /= f"of-{disk.digest(str(place).encode())[:24]}"
        os.environ["NUMBA_CACHE_DIR"] = str(kept)
        kept /= DISTRIBUTION
    for folder in (*reversed(kept.parents), kept):
        if not folder.exists():
            folder.mkdir(mode=0o700, exist_ok=True)
    return [temporary, Path(needed.SHARED), kept]


def _needed(*homes: Path | str) -> list[Path]:
    return [*needed.of_stages(*homes), *(Path(each).expanduser() for each in needed.STAGES)]


def _inputs(job: Job, tasks: Sequence[Task]) -> Iterator[Path]:
    named = named_files(tasks) if job.function is None else set()
    for place in {*(place for place, _ in job.files.values() if place), *named}:
        yield from (Path(place), *beside(Path(place)))
    for path in (path for stage in job.stages for path in stage.inputs if path not in job.files):
        for first in beneath(path, job.files)[:1]:
            inside = len(Path(first).parts) - len(Path(path).parts)
            yield [Path(job.files[first][0]), *Path(job.files[first][0]).parents][inside]
