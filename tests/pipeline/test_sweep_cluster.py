"""Sweeps and questions on a dask cluster of this machine, also when dask's workers are killed half way."""

import dataclasses
import os
import signal

import pytest

from pipeline.errors import StudyError
from pipeline.questions.asking import Asked
from pipeline.room.confine import landlock
from pipeline.sweep import cluster

distributed = pytest.importorskip("distributed", reason="needs the extra cluster")

MIXED = """
stage: fall
kind: list
time_limit_s: 1
start_limit_s: 15
points: [{fall.behaviour: well}, {fall.behaviour: crash}, {fall.behaviour: sleep}, {fall.behaviour: answer}]
"""


@pytest.fixture
def client(monkeypatch, repository):
    monkeypatch.setenv("PYTHONPATH", str(repository))
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@pytest.mark.slow
def test_hangs_and_crashes_on_a_cluster_are_rows_of_one_sweep_after_another(toy, client):
    for text in (MIXED, MIXED.replace("fall.behaviour: well", "fall.height: 3")):
        summary = toy.sweep(text).run(toy.root / "t.h5", 2, client)
        assert summary["outcomes"] == {"computed": 1, "crash": 1, "time limit": 1, "no answer": 1}
    assert len(client.scheduler_info(n_workers=-1)["workers"]) == 2


@pytest.mark.slow
def test_a_question_is_answered_by_a_cluster_as_here_with_a_worker_killed_half_way(toy, client):
    study = toy.study()
    tally, parameters = study.module("side", "questions.tally"), study.parameters(["side"])["side"]
    pids = list(client.run(os.getpid).values())

    def asked(study, client):
        with Asked(study, "side", tally.QUESTION, parameters, 2, client) as asking:
            if client is not None:
                asking.progress = lambda share, _: os.kill(pids[0], signal.SIGKILL) if share == 0.25 else None
            return list(asking.each(tally.number_of, list(range(60)), 0.1, ""))

    there = asked(study, client)
    assert there == asked(dataclasses.replace(study, results=toy.root / "elsewhere"), None) and len(there) == 60


@pytest.mark.slow
def test_machines_that_cannot_confine_are_named(client, monkeypatch):
    assert cluster.unconfined(client) == [] or landlock() == 0
    monkeypatch.setattr(cluster, "landlock", int)
    assert cluster.unconfined(client) == ["127.0.0.1"]


def test_a_scheduler_that_is_not_there_is_one_sentence(monkeypatch):
    monkeypatch.setattr(cluster, "_CONNECT_S", 1)
    with pytest.raises(StudyError, match=r"no dask scheduler answers there"):
        cluster.connected("tcp://127.0.0.1:9", {})
