"""What a process that computes a stage can still read and write, where the system has Landlock."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from pipeline.cache import disk
from pipeline.execution.job import TEMPORARY, Job, Task, named_files
from pipeline.graph import beneath
from pipeline.home import engine
from pipeline.room import needed
from pipeline.room.confine import confine
from pipeline.room.reading import beside
from pipeline.stage_modules import home_of


def enter(job: Job, folder: Path, tasks: Sequence[Task]) -> None:
    """Let this process read what dvc.yaml lists for these tasks, the stages' code and what every program needs, and
    write into `folder` and where machine code is kept. It opens no socket. It can never do more again.

    Code that is not this program's own keeps its machine code apart, as loading that runs it.
    """
    home = home_of(job.package, Path(job.code_root))
    temporary = folder / TEMPORARY
    temporary.mkdir(parents=True, exist_ok=True)
    os.environ["TMPDIR"], tempfile.tempdir = str(temporary), None
    writes = [folder, Path(needed.SHARED)]
    if any("/machine_code/" in file for file in job.code):
        kept = needed.machine_code()
        if home != engine():
            kept /= f"of-{disk.digest(str(home).encode())[:24]}"
            os.environ["NUMBA_CACHE_DIR"] = str(kept)
        for place in (*reversed(kept.parents), kept):
            if not place.exists():
                place.mkdir(mode=0o700, exist_ok=True)
        writes.append(kept)
    branch = home / ".git" / "HEAD"  # which tells who uses machine code
    system = [Path(each).expanduser() for each in needed.STAGES]
    reads = [home / job.package, branch, *needed.of_stages(home, job.root), *system, *_inputs(job, tasks)]
    confine(reads, writes, [home, engine()])


def _inputs(job: Job, tasks: Sequence[Task]) -> Iterator[Path]:
    named = named_files(tasks) if job.function is None else set()
    for place in {*(place for place, _ in job.files.values() if place), *named}:
        yield from (Path(place), *beside(Path(place)))
    for path in (path for stage in job.stages for path in stage.inputs if path not in job.files):
        for first in beneath(path, job.files)[:1]:
            inside = len(Path(first).parts) - len(Path(path).parts)
            yield [Path(job.files[first][0]), *Path(job.files[first][0]).parents][inside]
