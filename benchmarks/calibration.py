"""Blind campaigns of the constraint model: which 95 % intervals hold the truth, how wide they are, and what it takes.

python -m benchmarks.calibration --first 1000 --campaigns 200 --runs 1
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

from pipeline.study import Study
from stages.calibration.blind.score import score, summary

ROOT = Path(__file__).resolve().parent.parent


def main() -> None:
    """Print the summary as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1000, help="seed of the first campaign")
    parser.add_argument("--campaigns", type=int, default=20)
    parser.add_argument("--runs", type=int, default=1, help="runs of a campaign")
    asked = parser.parse_args()
    settings = ("biped.leg_inertia=8.576e-4",)
    parameters = Study(ROOT, ROOT / "params", ROOT / "results", settings).parameters(["calibration"])["calibration"]
    begun = time.monotonic()
    found = score(range(asked.first, asked.first + asked.campaigns), asked.runs, parameters,
                  lambda share, what: print(what, file=sys.stderr))
    print(json.dumps({**summary(found), "seconds": time.monotonic() - begun}, indent=1))


if __name__ == "__main__":
    main()
