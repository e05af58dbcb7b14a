"""Ingest of 72,000 rows (30 runs, two sensors, 12 s), and of many times that: time and memory.

    python -m benchmarks.imu_ingest [TIMES]

The runs are made up (tests/imu/stand_in.py) and copied with names of their own up to TIMES (default 10) times. Time is
processor time of reading, clock repair, frames, heel strikes and registration of every run; memory is the process's
peak, each size in a process of its own. Runs are handed on one at a time, as `bipedstudy ingest` does; what the study
keeps of a run comes on top.
"""

from __future__ import annotations

import multiprocessing
import resource
import sqlite3
import sys
import tempfile
import time
from pathlib import Path

from stages.imu.run import trials
from stages.imu.sources.databases import SqliteSource
from tests.imu.stand_in import PARAMETERS, make_database, make_run

RUNS, STEPS, REST_S = 30, 18, 3.0


def copies(path: Path, base: bytes, times: int) -> int:
    """A database with the runs of `base` many times over; returns the number of its rows."""
    path.write_bytes(base)
    connection = sqlite3.connect(path)
    columns = [row[1] for row in connection.execute("PRAGMA table_info(sample)")][2:]
    for copy in range(1, times):
        shift = copy * RUNS
        connection.execute(
            f"INSERT INTO sample (experiment_id, {', '.join(columns)}) "
            f"SELECT experiment_id + {shift}, {', '.join(columns)} FROM sample WHERE experiment_id <= {RUNS}"
        )
    connection.commit()
    (rows,) = connection.execute("SELECT count(*) FROM sample").fetchone()
    connection.close()
    return int(rows)


def measure(path: Path) -> tuple[int, float, float]:
    """Runs accepted, processor time [s] and peak memory [MB]."""
    start = time.process_time()
    with SqliteSource(path) as source:
        accepted = sum(trial.accepted for trial in trials(source.runs(), PARAMETERS))
    return accepted, time.process_time() - start, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main() -> None:
    most = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    base = make_database([make_run(seed, steps=STEPS, rest_s=REST_S) for seed in range(RUNS)])
    print(f"{'rows':>10}{'runs':>8}{'time s':>10}{'us a row':>10}{'peak MB':>10}")
    with tempfile.TemporaryDirectory() as folder:
        for times in sorted({1, max(1, most // 3), most}):
            path = Path(folder) / "log.sqlite"
            rows = copies(path, base, times)
            with multiprocessing.get_context("spawn").Pool(1) as pool:
                accepted, seconds, memory = pool.apply(measure, (path,))
            print(f"{rows:10}{accepted:8}{seconds:10.2f}{1e6 * seconds / rows:10.1f}{memory:10.0f}")
            path.unlink()


if __name__ == "__main__":
    main()
