"""Kills of a sweep on a dask cluster: of scheduler, workers or client, at random moments, until all points are in.

*Lost* are rows that were in the journal and are not there any more, *wrong* are rows whose values changed, and tables
that are not those of an undisturbed sweep on this machine. *Without a sentence* are ends of the client that has none.
"""

import contextlib
import random
import subprocess
import time
from typing import Any

from pipeline.sweep.pool import Journal
from tests.pipeline.counts import Count
from tests.pipeline.dask_processes import Cluster
from tests.pipeline.toy import Toy

VICTIMS = ("scheduler", "worker", "client")
WORKERS = 2
_LONGEST_PAUSE_S = 3.0
_POINTS = 60
_SWEEP = f"stage: side\nkind: grid\nset: {{side.wait: 0.1}}\nvary: {{side.seed: {list(range(_POINTS))}}}\n"


class Sweeping:
    """A sweep of a toy study that is started again until it came to its end."""

    def __init__(self, toy: Toy, cluster: Cluster) -> None:
        self.toy, self.cluster, self.count = toy, cluster, Count()
        (toy.root / "kills.yaml").write_text(_SWEEP)
        toy.says("sweep kills.yaml --out right.h5")
        self.right = (toy.root / "right.h5").read_bytes()
        self.known: dict[str, Any] = {}
        self.anew()

    def anew(self) -> None:
        """Forget every row."""
        for journal in self.toy.root.glob("results/sweeps/.cache/*.jsonl"):
            journal.unlink()
        self.known = {}

    def client(self) -> subprocess.Popen[str]:
        """Start the sweep on the cluster."""
        secured = self.cluster.secured.options() if self.cluster.secured else []
        words = ("sweep", "kills.yaml", "--out", "table.h5", "--cluster", self.cluster.address, *secured)
        return self.toy.start(*words)

    def revive(self) -> None:
        """Have a scheduler and all workers."""
        if self.cluster.scheduler is None or self.cluster.scheduler.poll() is not None:
            self.cluster.start_scheduler()
        self.cluster.start_workers(WORKERS)

    def kill(self, victim: str, client: subprocess.Popen[str], chance: random.Random) -> None:
        """kill -9. Workers end by themselves soon after their scheduler, so there may be none."""
        self.cluster.start_workers(WORKERS)
        workers = [worker for worker in self.cluster.workers if worker.poll() is None]
        chosen: Any = {"scheduler": self.cluster.scheduler, "client": client}.get(victim) or chance.choice(workers)
        chosen.kill()
        chosen.wait()
        self.count.hit[victim] += 1

    def check(self, client: subprocess.Popen[str]) -> bool:
        """Look at what a client left that has ended; whether it came to its end."""
        _, errors = client.communicate(timeout=120)
        if "Traceback" in errors or "unexpected" in errors or (client.returncode > 0 and "error: " not in errors):
            self.count.told.append(f"{client.returncode}: {errors[-2000:]}")
        rows = {}
        for path in self.toy.root.glob("results/sweeps/.cache/*.jsonl"):
            with contextlib.closing(Journal(path)) as journal:
                rows = {key: journal.row(key) for key in list(journal._places)}
        self.count.lost += [key for key in self.known if key not in rows]
        self.count.wrong += [key for key, row in self.known.items() if rows.get(key, row) != row]
        self.known = rows
        if client.returncode:
            return False
        self.count.survived += 1
        if (self.toy.root / "table.h5").read_bytes() != self.right:
            self.count.wrong.append(f"the table of sweep {self.count.survived}")
        return True


def killed(toy: Toy, cluster: Cluster, kills: int, chance: random.Random) -> Count:
    """Kill something again and again, until there were so many kills and the sweep then came to its end."""
    sweeping = Sweeping(toy, cluster)
    count = sweeping.count
    client = None
    for victim in chance.sample(VICTIMS * (-(-kills // len(VICTIMS))), kills):
        sweeping.revive()
        if client is not None and client.poll() is not None:
            if sweeping.check(client):
                sweeping.anew()
            client = None
        if client is None:
            cluster.wait_for_workers(1)
            client = sweeping.client()
        time.sleep(chance.uniform(0.0, _LONGEST_PAUSE_S))
        sweeping.kill(victim, client, chance)
    for _ in range(kills):
        sweeping.revive()
        if client is not None and sweeping.check(client):
            return count
        cluster.wait_for_workers(WORKERS)
        client = sweeping.client()
    raise AssertionError(f"the sweep does not come to its end: {count}")
