"""Workers and what a stage is given: typed inputs, foreign output, and what a user keeps beside his study."""

import dataclasses
import gc
import json
import math
import platform
import re
import time
import warnings
from pathlib import Path

import pytest

from pipeline.cache import fingerprint
from pipeline.errors import StudyError
from pipeline.execution import process, worker
from pipeline.execution.display import Display
from pipeline.execution.executor import bring_up_to_date
from pipeline.execution.inputs import disagreements
from pipeline.execution.job import Job, engine_code, job_of, task_of
from pipeline.graph import Stage
from pipeline.parameters import loading
from pipeline.study import Study, locate
from pipeline.sweep import cluster
from tests import commands

BOUNCE = "PACKAGE/bounce/run.py"


@pytest.mark.parametrize(
    ("path", "old", "new", "sentence"),
    [
        ("dvc.yaml", "      - results/side.bin\n", "",
         'its Inputs have "side", but dvc.yaml lists no such result and no parameter such a file'),
        (BOUNCE, "    fall: Fall\n", "    fal: Fall\n",
         'dvc.yaml lists results/fall.h5 among its deps, but its Inputs have no "fall"; did you mean "fal"?'),
        (BOUNCE, "    fall: Fall\n", "    fall: Result\n",
         'its Inputs have "fall" as PACKAGE.bounce.result.Result; allowed: PACKAGE.fall.result.Result'),
        ("PACKAGE/picture/run.py", "    side: Path\n", "    side: Bounce\n",
         'its Inputs have "side" as PACKAGE.bounce.result.Result; allowed: pathlib.Path'),
        ("PACKAGE/fall/run.py", "from PACKAGE.fall.errors import", "from .errors import",
         "it imports PACKAGE/fall/errors.py in a way that cannot be seen in the text"),
        ("PACKAGE/picture/run.py", '"claims.yaml": (CLAIM', '"figures/claims.yaml": (CLAIM',
         "it did not return results/claims.yaml"),
    ],
)  # fmt: skip
def test_a_stage_that_disagrees_with_the_graph_is_one_sentence(done, path, old, new, sentence):
    done.edit(path, old.replace("PACKAGE", done.package), new)
    failed = done.fails()
    assert len(failed.sentences) == 1
    assert failed.sentences[0].partition(": ")[2].startswith(sentence.replace("PACKAGE", done.package))


def test_a_worker_needs_no_names_that_windows_lacks(done, tmp_path, monkeypatch):
    (tmp_path / "sitecustomize.py").write_text("import os, signal\ndel os.O_ACCMODE, signal.SIGCONT\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(process, "FORKED", False)
    assert set(done.run("picture.extra=true", force=True).values()) == {"computed"}


def test_what_a_stage_computes_in_processes_that_it_started_counts_too():
    before = worker._processor_seconds()
    spent = commands.python("import time\nwhile time.process_time() < 0.3: pass\nprint(time.process_time())",
                            cwd=Path.cwd())  # fmt: skip
    own = time.process_time()
    while time.process_time() < own + 0.05:
        pass
    assert worker._processor_seconds() - before > float(spent.stdout) + 0.05 - 0.02  # as coarse as a tick is


def test_every_disagreement_is_found_at_once():
    @dataclasses.dataclass(frozen=True)
    class Inputs:
        one: Path

    stage = Stage("last", (), ("results/two.bin", "results/three.bin"), {}, ())
    found = list(disagreements("package", stage, Inputs, dataclasses.make_dataclass("Parameters", ())))
    assert [sentence.split('"')[1] for sentence in found] == ["two", "three", "one"]


def test_a_stage_may_take_a_result_as_the_file_itself(done):
    done.edit(BOUNCE, "    fall: Fall\n", "    fall: Path\n")
    done.edit(BOUNCE, f"from {done.package}.fall.result import Result as Fall", "from pathlib import Path")
    done.edit(BOUNCE, "    assert not fall.files\n", "    return Result(float(fall.stat().st_size))\n")
    assert done.run(names=("bounce",))["bounce"] == "computed"


def test_a_file_that_changes_while_a_stage_reads_it_is_refused(toy, monkeypatch):
    table = toy.root / "lab.txt"
    table.write_text("41")
    toy.edit("PACKAGE/side/run.py", "        number = int(", "        while inputs.table.read_text() != '42':\n"
             "            progress(0.5, 'waits')\n        number = int(")  # fmt: skip
    monkeypatch.setattr(Display, "progress", lambda *told: told[-1] and table.write_text("42"))
    toy.fails("side.table=lab.txt", names=("side",), said="its input table was changed while it ran, so its result was")


def test_what_others_print_before_a_worker_begins_is_no_message(done, own_server, tmp_path, monkeypatch):
    (tmp_path / "sitecustomize.py").write_text("print('hello', 3, '[]', '{}', '{\"a\": 1}', '', sep='\\n', flush=True)")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    assert done.run("fall.height=3", names=("fall",)) == {"fall": "computed"}


def test_a_worker_that_ended_leaves_no_file_open(done, own_server):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        assert done.run("fall.height=3", names=("fall",)) == {"fall": "computed"}
        gc.collect()
    assert [str(each.message) for each in said if each.category is ResourceWarning] == []


def test_a_pipeline_of_the_users_own_disturbs_no_stage(toy):
    for name in ("pipeline", "h5py", "queue"):
        (toy.root / f"{name}.py").write_text("raise SystemExit('not this one')")
    assert set(toy.run().values()) == {"computed"}


def test_a_folder_with_the_name_of_the_stages_is_not_taken_for_them(toy, tmp_path, monkeypatch):
    """A study laid out by `init` lists no code: its stages are the installed ones, whatever lies beside it."""
    monkeypatch.syspath_prepend(str(toy.root))  # where the toy's package is installed
    mine = tmp_path / "mine"
    (mine / toy.package).mkdir(parents=True)
    (mine / toy.package / "__init__.py").write_text("raise SystemExit('not this one')")
    (mine / "params").symlink_to(toy.root / "params")
    graph = re.sub(rf"\n *- {toy.package}/.*|{toy.package}/[^,\]]*,? ?", "", (toy.root / "dvc.yaml").read_text())
    (mine / "dvc.yaml").write_text(graph)
    study = Study(mine, mine / "params", mine / "results", (), toy.package)
    assert toy.package not in graph and study.code_root == toy.root
    values = study.parameters(tuple(study.graph.stages))
    assert {outcome.how for outcome in bring_up_to_date(study, values, Display())} == {"computed"}


# --- What a worker is told is data: it comes back whole from JSON, to the last bit, and nothing of it is pickled.


@pytest.mark.parametrize("settings", [
    (),
    ("ground.normal_force=impact", "multibody.steps=2"),
    ("biped.hip_mass=0.3210123456789012345", "twin.inertia=planar"),
    ("biped.foot_com={value: 0.1, uncertainty: 0.003}",),
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


def test_jobs_come_back_whole(toy):
    study = toy.study()
    stage = study.graph.stages["bounce"]
    parts = fingerprint.ingredients(stage, study.sources, {}, {})
    job = job_of(study, parts, {"results/fall.h5": ("/somewhere", "0" * 64)})
    assert Job.of(job.text()).text() == job.text() and "\n" not in job.text()
    contents = {"results/fall.h5": bytes(range(256))}
    carried = Job(study.package, "/code", "/root", (stage,), parts["code"], contents=contents,
                  versions=parts["versions"], engine=engine_code(), time_limit_s=math.inf)  # fmt: skip
    assert Job.of(carried.text()).text() == carried.text() and Job.of(carried.text()).contents == contents


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
    return toy.sweep("stage: side\nkind: grid\nvary: {side.seed: [1, 2]}\n")


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
