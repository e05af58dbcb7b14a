"""Reading a CSV log of many rows, beside pandas: time and memory.

    python -m benchmarks.imu_reading [ROWS ...] [--rounds 3]

The file has a packet number, a stamp in seconds since 1970 and six values a row. pandas reads it and drops rows in
which anything is missing or beyond what a sensor gives; the ingest reads it into one recording by a column map. Each
round is a process of its own, in turns; processor time is the least of the rounds, memory the peak of the process less
what it had before.
"""

import argparse
import multiprocessing
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

VALUES = ("ax", "ay", "az", "gx", "gy", "gz")
NAMES = ("packet", "position", "phone_stamp", *VALUES)


def write(path: Path, rows: int) -> None:
    rng = np.random.default_rng(0)
    with path.open("w") as file:
        file.write(",".join(NAMES) + "\n")
        for first in range(0, rows, 100_000):
            index = np.arange(first, min(first + 100_000, rows))
            columns = (index // 3, index % 3, 1.6e9 + 0.01 * index, rng.normal(scale=5.0, size=(len(index), 6)))
            np.savetxt(file, np.column_stack(columns), fmt=["%d", "%d", "%.3f"] + ["%.6f"] * 6, delimiter=",")


def with_pandas(path: Path) -> int:
    import pandas

    table = pandas.read_csv(path, usecols=list(NAMES))
    return int((np.abs(table) < 1e15).all(axis=1).sum())


def with_the_ingest(path: Path) -> int:
    from stages.imu.sources.column_map import CsvSource

    device = {"place": "hip", "rate_hz": 100, "accelerometer_unit": "m/s^2", "gyroscope_unit": "rad/s"}
    described = {"files": [{"file": path.name, "device": device, "columns": dict(zip(NAMES, NAMES))}]}
    ((_, (recording,)),) = CsvSource(described, path.parent).runs()
    return recording.rows


def measured(read: Callable[[Path], int], path: Path) -> tuple[int, float, float]:
    """Rows, processor time [s] and memory [MB], imports left out."""
    small = path.with_name("small.csv")
    read(small)
    before, start = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
    rows = read(path)
    taken = time.process_time() - start
    return rows, taken, (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", type=float, nargs="*", default=[1e6])
    parser.add_argument("--rounds", type=int, default=3)
    chosen = parser.parse_args()
    print("| rows | reader | s | MB |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder) / "small.csv", 100)
        for rows in map(int, chosen.rows):
            path = Path(folder) / "log.csv"
            write(path, rows)
            found: dict[str, list[tuple[int, float, float]]] = {}
            for _ in range(chosen.rounds):
                for read in (with_pandas, with_the_ingest):
                    with multiprocessing.get_context("spawn").Pool(1) as pool:
                        found.setdefault(read.__name__, []).append(pool.apply(measured, (read, path)))
            for name, every in found.items():
                kept, seconds, memory = (column for column in zip(*every, strict=True))
                assert set(kept) == {rows}
                print(f"| {rows:g} | {name.replace('_', ' ')} | {min(seconds):.2f} | {max(memory):.0f} |", flush=True)


if __name__ == "__main__":
    main()
