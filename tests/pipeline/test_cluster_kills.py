"""A sweep on a cluster whose scheduler, workers and client are killed at random moments loses nothing."""

import random

import pytest

pytest.importorskip("distributed", reason="needs the extra cluster")

from tests.pipeline.cluster_kills import VICTIMS, killed
from tests.pipeline.dask_processes import Cluster, certificates


@pytest.mark.slow
def test_kills_of_scheduler_workers_and_client(toy_with_commands, tmp_path):
    (tmp_path / "cluster").mkdir()
    cluster = Cluster(tmp_path / "cluster", secured=certificates(tmp_path / "secured"))
    try:
        count = killed(toy_with_commands, cluster, 12, random.Random(1))
    finally:
        cluster.close()
    assert count.problems == [] and set(count.hit) == set(VICTIMS) and count.survived >= 1
