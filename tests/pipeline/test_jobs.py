"""What a worker is told is data: it comes back whole from JSON, to the last bit, and nothing of it is pickled."""

from __future__ import annotations

import json
import math
import random

import pytest

from pipeline.cache import fingerprint
from pipeline.execution.job import Job, engine_code, job_of, task_of
from pipeline.parameters import loading
from pipeline.study import locate


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
