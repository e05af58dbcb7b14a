"""What a worker is told is data: it comes back whole from JSON, to the last bit, and nothing of it is pickled."""

from __future__ import annotations

import dataclasses
import json
import math
import platform
import random
import tempfile
import time

import pytest

from pipeline.cache import fingerprint
from pipeline.errors import StudyError
from pipeline.execution.display import Display
from pipeline.execution.job import Job, engine_code, job_of, task_of
from pipeline.parameters import loading
from pipeline.study import locate
from pipeline.sweep import cluster, pool
from pipeline.sweep import spec as specs
from pipeline.sweep.sweep import Sweep


@pytest.mark.parametrize("settings", [
    (),
    ("ground.normal_force=impact", "multibody.steps=2"),
    ("biped.hip_mass=0.3210123456789012345", "twin.inertia=planar"),
])  # fmt: skip
def test_parameters_of_every_stage_come_back_whole(repository, settings):
    study = locate(None, None, settings, repository)
    values = study.parameters(tuple(study.graph.stages))
    for value in values.values():
        _, point = task_of(study, {"it": value})
        plain, _ = json.loads(json.dumps(point))["it"]
        assert loading.from_plain(type(value), plain) == value
        assert json.dumps(loading.as_plain(value)) == json.dumps(plain)


def test_parameters_that_would_lose_something_are_refused(toy):
    value = toy.study().parameters(["bounce"])["bounce"]
    plain = loading.as_plain(value)
    plain["ground"]["gravity half-width"] = 0.005  # as if the class kept it, and were not filled again
    with pytest.raises(StudyError, match="do not come back whole"):
        loading.from_plain(type(value), plain)


def test_random_numbers_come_back_to_the_last_bit(toy):
    chance = random.Random(1)
    for _ in range(200):
        number = math.ldexp(chance.random(), chance.randint(-1000, 900))
        value = toy.study(f"ground.contact_stiffness={number!r}").parameters(["bounce"])["bounce"]
        plain = json.loads(json.dumps(loading.as_plain(value)))
        assert loading.from_plain(type(value), plain).ground.contact_stiffness == number


def test_jobs_come_back_whole(toy):
    study = toy.study()
    stage = study.graph.stages["bounce"]
    parts = fingerprint.ingredients(stage, study.sources, {}, {})
    job = job_of(study, parts, {"results/fall.h5": ("/somewhere", "0" * 64)})
    assert Job.of(job.text()) == job and "\n" not in job.text()
    contents = {"results/fall.h5": bytes(range(256))}
    carried = Job(study.package, "/code", "/root", (stage,), parts["code"], contents=contents,
                  versions=parts["versions"], engine=engine_code(), time_limit_s=math.inf)  # fmt: skip
    assert Job.of(carried.text()) == carried


def test_what_the_engine_is_made_of_includes_every_module_that_a_worker_runs():
    files = {f"pipeline/{name}.py" for name in ("sweep/cluster", "execution/worker", "cache/artefact")}
    assert files <= {*engine_code()}


@pytest.mark.parametrize(("address", "leaves_open"), [
    ("tcp://10.0.0.1:8786", True), ("scheduler:8786", True), ("tls://10.0.0.1:8786", False),
    ("tcp://127.0.0.1:8786", True), ("localhost:8786", True), ("tcp://[::1]:8786", True), ("inproc://x/1", False),
])  # fmt: skip
def test_an_unencrypted_way_is_told(address, leaves_open):
    assert cluster.is_open(address) == leaves_open


@pytest.fixture
def sweep(toy):
    (toy.root / "sweep.yaml").write_text("stage: side\nkind: grid\nvary: {side.seed: [1, 2]}\n")
    return Sweep(toy.study(), specs.read(toy.root / "sweep.yaml"), Display())


def test_what_a_killed_sweep_left_is_removed_and_what_another_uses_stays(sweep, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(pool, "_NEW_S", 0.0)
    left = tmp_path / "bipedstudy-sweep-left"
    left.mkdir()
    (left / "held").touch()
    benches = [pool.Bench(sweep.chain.job(Display())) for _ in range(2)]
    for number, bench in enumerate(benches):  # two sweeps at a time
        assert [row.outcome for _, row in bench.work([sweep._task(number)])] == ["computed"]
        assert not left.exists()
    assert len([*tmp_path.glob("bipedstudy-sweep-*")]) == 2
    for bench in benches:
        bench.close()
    assert not [*tmp_path.glob("bipedstudy-sweep-*")]


def test_a_bench_of_a_cluster_that_nobody_asks_any_more_ends_and_starts_again(sweep, monkeypatch):
    """The client may have been killed."""
    monkeypatch.setattr(cluster, "_IDLE_S", 0.5)
    job = sweep.chain.job(Display()).text()
    first = json.loads(cluster.work("name", job, json.dumps([sweep._task(0)])))
    (bench,) = cluster._benches.values()
    assert first["rows"][0][1]["outcome"] == "computed" and bench._worker is not None
    end = time.monotonic() + 20
    while bench._worker is not None and time.monotonic() < end:
        time.sleep(0.1)
    assert bench._worker is None and not cluster._benches
    again = json.loads(cluster.work("name", job, json.dumps([sweep._task(0)])))
    assert again["rows"][0][1]["values"] == first["rows"][0][1]["values"]
    cluster.forget("name")
    assert not cluster._benches


def test_what_a_machine_refuses_is_told_with_its_name(sweep):
    job = Job.of(sweep.chain.job(Display()).text())
    other = dataclasses.replace(job, versions={**job.versions, "h5py": "0.1"})
    told = json.loads(cluster.work("other", other.text(), json.dumps([sweep._task(0)])))
    cluster.forget("other")
    assert told["refused"].startswith(f"the machine {platform.node()}: ") and "instead of 0.1" in told["refused"]
