"""How many points of the analytic stage a sweep computes in a second, and what a million of them would take.

Run: python benchmarks/sweep_rate.py [points] [processes ...]. Compiled code must be there (run the study once before).
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from pipeline.display import Display
from pipeline.study import locate
from pipeline.sweep import spec as specs
from pipeline.sweep.progress import Silence, duration
from pipeline.sweep.sweep import Sweep

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


def main() -> None:
    """Print a line for each number of processes; every one computes all points anew."""
    count, *processes = [int(word) for word in sys.argv[1:]] or [100, 1, 2]
    for workers in processes or [1, 2]:
        with tempfile.TemporaryDirectory() as folder:
            spec = Path(folder, "rate.yaml")
            spec.write_text(SPEC.format(count=count))
            study = locate(results=folder)
            summary = Sweep(study, specs.read(spec), Display()).run(Path(folder, "t.h5"), workers, None, Silence)
        rate = summary.computed_now / summary.seconds
        each = summary.point_seconds / summary.computed_now
        print(
            f"{workers} processes: {rate:.3g} points/s, {1000 * each:.0f} ms a point, "
            f"{100 * (summary.busy or 0):.1f} % of the time in points; a million: {duration(1e6 / rate)}"
        )


if __name__ == "__main__":
    main()
