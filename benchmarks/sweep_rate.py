"""How many points of the analytic stage a sweep computes in a second, and what a million of them would take.

Run: python benchmarks/sweep_rate.py [points] [processes ...], where dask:2 means two workers of a dask cluster on this
machine (extra cluster). Compiled code must be there (run the study once before). What other programs took of the
processors meanwhile is printed too (Linux): only where that is little do two lines compare.
"""

import contextlib
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pipeline.execution.display import Display
from pipeline.study import locate
from pipeline.sweep import spec as specs
from pipeline.sweep.sweep import Sweep, duration

SPEC = """
stage: analytic
kind: latin_hypercube
count: {count}
seed: 1
set: {{analytic.steps: 1}}
vary:
  biped.hip_mass: {{low: 0.2, high: 0.5}}
  biped.foot_com: {{low: 0.08, high: 0.12}}
  ground.slope_deg: {{low: 1, high: 4}}
"""


def machine_seconds() -> float:
    """Processor time that all programs have used since the machine started; NaN where the system does not tell."""
    try:
        user, nice, system = (int(word) for word in Path("/proc/stat").read_text().split()[1:4])
    except OSError:
        return float("nan")
    return (user + nice + system) / os.sysconf("SC_CLK_TCK")


def own_seconds() -> float:
    """Processor time of this process and of the processes it has waited for."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


@contextlib.contextmanager
def cluster(workers: int) -> Iterator[Any]:
    """A dask client of so many workers on this machine; None for none."""
    if not workers:
        yield None
        return
    from distributed import Client, LocalCluster

    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as here, Client(here) as client:
        yield client


def main() -> None:
    """Print a line for each number of processes; every one computes all points anew."""
    count, *ways = sys.argv[1:] or ["100"]
    first = 0.0
    for way in ways or ["1", "2"]:
        workers = int(way.removeprefix("dask:"))
        began, busy, own = time.monotonic(), machine_seconds(), own_seconds()
        with tempfile.TemporaryDirectory() as folder, cluster(workers if "dask" in way else 0) as client:
            spec = Path(folder, "rate.yaml")
            spec.write_text(SPEC.format(count=count))
            study = locate(results=folder)
            summary = Sweep(study, specs.read(spec), Display()).run(Path(folder, "t.h5"), workers, client)
        used = own_seconds() - own
        others = (machine_seconds() - busy - used) / ((time.monotonic() - began) * (os.cpu_count() or 1))
        rate = summary["computed_now"] / summary["seconds"]
        first = first or rate
        each = summary["point_seconds"] / summary["computed_now"]
        print(
            f"{way} processes: {rate:.3g} points/s, {1000 * each:.0f} ms a point "
            f"({1000 * used / summary['computed_now']:.0f} ms of processor time with all else), "
            f"{100 * (summary['busy'] or 0):.1f} % of the time in points; a million: {duration(1e6 / rate)}; "
            f"{rate / first:.2f} times the first line; others used {100 * max(others, 0.0):.0f} % of the machine",
            flush=True,
        )


if __name__ == "__main__":
    main()
