"""Kills scheduler, workers and client of a small sweep on a dask cluster with certificates, and counts the outcomes.

Run: python -m benchmarks.killed_cluster [kills]. Needs the extra cluster and openssl. `docs/faults.md` has the table.
"""

import random
import sys
import tempfile
from pathlib import Path

from tests.pipeline.cluster_kills import VICTIMS, killed
from tests.pipeline.dask_processes import Cluster, certificates
from tests.pipeline.toy import with_commands


def main() -> None:
    """Print the table; ends with 1 if anything was lost, wrong or unexplained."""
    kills = int(sys.argv[1]) if sys.argv[1:] else 100
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in ("study", "cluster"):
            (folder / part).mkdir()
        cluster = Cluster(folder / "cluster", secured=certificates(folder / "secured"))
        try:
            count = killed(with_commands(folder / "study"), cluster, kills, random.Random(2))
        finally:
            cluster.close()
    shares = ", ".join(f"{count.hit[victim]} times the {victim}" for victim in VICTIMS)
    print("| killed | kills | sweeps that came to their end | lost | wrong | without a sentence |")
    print("|---|---|---|---|---|---|")
    print(f"| a sweep on a cluster ({shares}) | {sum(count.hit.values())} | {count.survived} | {len(count.lost)} | "
          f"{len(count.wrong)} | {len(count.told)} |")  # fmt: skip
    problems = count.problems
    if problems:
        sys.exit("\n".join(problems))


if __name__ == "__main__":
    main()
