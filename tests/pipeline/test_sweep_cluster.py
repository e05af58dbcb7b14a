"""Sweeps and questions on a dask cluster of this machine, also when dask's workers are killed half way."""

import contextlib
import dataclasses
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from pipeline.errors import StudyError
from pipeline.questions.asking import Asked
from pipeline.room.confine import landlock
from pipeline.sweep import cluster
from tests import commands
from tests.pipeline import documented
from tests.pipeline.cluster_kills import VICTIMS, killed
from tests.pipeline.dask_processes import Cluster, certificates, free_port
from tests.pipeline.toy import HOME

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


# --- Clusters with certificates, and what refuses: strangers, machines with other code or other versions.


NOBODY = 65534
SWEEP = "stage: side\nkind: grid\nvary: {side.seed: [1, 2, 3, 4, 5]}\n"


@pytest.fixture
def seeds(toy_with_commands):
    (toy_with_commands.root / "seeds.yaml").write_text(SWEEP)
    return toy_with_commands


@pytest.fixture
def started(tmp_path):
    """Starts a cluster with one worker."""
    (folder := tmp_path / "cluster").mkdir()
    with contextlib.ExitStack() as clusters:
        def start(**how):
            cluster = Cluster(folder, **how)
            clusters.callback(cluster.close)
            cluster.start_scheduler()
            cluster.wait_for_workers(1)
            return cluster

        yield start


@pytest.mark.slow
def test_a_cluster_with_certificates_by_arguments_and_by_configuration(seeds, started, tmp_path, monkeypatch):
    mine, strangers = certificates(tmp_path / "mine"), certificates(tmp_path / "strangers")
    cluster = started(secured=mine)
    sweep = f"sweep seeds.yaml --cluster {cluster.address}"
    seeds.says(" ".join([sweep, "--out there.h5", *mine.options()]), "5 computed")
    said = seeds.answers(" ".join([sweep, *strangers.options()]), sweep.replace("tls", "tcp")).values()
    assert [code for code, _, _ in said] == [2, 2]
    assert all("no dask scheduler answers there (" in errors for _, _, errors in said)
    assert "certificate" in next(iter(said))[2].lower()
    for name, file in (("CA_FILE", mine.authority), ("CLIENT__CERT", mine.certificate), ("CLIENT__KEY", mine.key)):
        monkeypatch.setenv(f"DASK_DISTRIBUTED__COMM__TLS__{name}", str(file))
    seeds.says(f"{sweep} --results again --out again.h5", "0 were known")
    seeds.says("sweep seeds.yaml --results here --out here.h5", "0 were known")
    assert len({(seeds.root / name).read_bytes() for name in ("there.h5", "again.h5", "here.h5")}) == 1


def test_certificates_that_cannot_be_used_are_one_sentence(seeds, tmp_path):
    mine, other, spoilt = (certificates(tmp_path / name) for name in ("mine", "other", "spoilt"))
    spoilt.certificate.write_text("no certificate")
    there, unusable = "--cluster tls://127.0.0.1:9", "the certificates cannot be used: "
    wrong = {
        there: "needs certificates: --tls-ca-file", f"{there} --tls-ca-file {mine.authority}": "needs certificates",
        " ".join([there, *mine.options()[:-1], str(other.key)]): unusable,
        " ".join([there, *spoilt.options()]): unusable,
        " ".join([there.replace("tls", "tcp"), *mine.options()]): "begins with tls://",
        " ".join(mine.options()): "are for --cluster",
    }
    told = seeds.answers(*(f"sweep seeds.yaml {words}" for words in wrong)).values()
    for (code, _, errors), said in zip(told, wrong.values(), strict=True):
        assert code == 2 and said in errors.strip().splitlines()[-1]


def other_code(folder):
    shutil.copytree(HOME / "pipeline", folder / "pipeline")
    row = folder / "pipeline/sweep/pool.py"
    row.write_text(row.read_text() + "LATER = 1\n")


def other_versions(folder):
    (folder / "h5py-9.9.dist-info").mkdir(parents=True)
    (folder / "h5py-9.9.dist-info/METADATA").write_text("Name: h5py\nVersion: 9.9\n")


def no_program(folder):
    (folder / "pipeline").mkdir(parents=True)  # empty, an editable install would fill it
    (folder / "pipeline/__init__.py").write_text("raise ModuleNotFoundError('No module named pipeline')")


@pytest.mark.slow
@pytest.mark.parametrize(("make", "said"), [
    (other_code, "pipeline/sweep/pool.py differs from what the sweep was started with"),
    (other_versions, "has h5py 9.9 instead of "),
    (no_program, "every machine of a cluster needs this program"),
], ids=["other code", "other versions", "no program"])  # fmt: skip
def test_a_machine_that_is_not_like_this_one_refuses(seeds, started, tmp_path_factory, make, said):
    make(other := tmp_path_factory.mktemp("other"))  # in the study it would be code that nobody agreed to
    cluster = started(first_on_path=(other,))
    seeds.says(f"sweep seeds.yaml --cluster {cluster.address}", said, code=1)


#: Another user, or this one with the key, has a function run that leaves a file; every way to talk is tried.
INTRUDES = """
import os, sys
from distributed import Client
from distributed.security import Security
port, left, user, *files = sys.argv[1:]
if int(user):
    os.setgroups([]), os.setgid(int(user)), os.setuid(int(user))
named = dict(zip(("tls_ca_file", "tls_client_cert", "tls_client_key"), files))
for number, (address, security) in enumerate((
    (f"tcp://127.0.0.1:{port}", None), (f"tls://127.0.0.1:{port}", Security(require_encryption=True)),
    (f"tls://127.0.0.1:{port}", Security(require_encryption=True, **named)),
)):
    try:
        with Client(address, security=security, timeout=5) as client:
            client.submit(os.mkdir, f"{left}/{number}", pure=False).result(timeout=20)
    except Exception as error:
        print(address, type(error).__name__)
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid(), reason="needs to become another user")
def test_another_user_of_the_machine_runs_nothing_on_the_documented_cluster():
    """The commands as docs/sweeps.md has them, on one machine; whoever has the key may run functions there."""
    tmp_path = Path(tempfile.mkdtemp())  # pytest's own folders are closed to others
    try:
        tmp_path.chmod(0o755)
        _intruded(tmp_path)
    finally:
        shutil.rmtree(tmp_path)


def _intruded(tmp_path):
    made, scheduler, worker = (block.split() for text in documented.blocks(HOME / "docs/sweeps.md", "text")
                               for block in text.splitlines() if block.startswith(("openssl", "dask")))  # fmt: skip
    subprocess.run(made, cwd=tmp_path, check=True, capture_output=True)
    theirs = certificates(tmp_path / "theirs")
    for path in (tmp_path / "theirs", *(tmp_path / "theirs").iterdir(), left := tmp_path / "left"):
        left.mkdir(exist_ok=True)
        os.chown(path, NOBODY, NOBODY)
        path.chmod(0o777)
    port = free_port()
    began = [subprocess.Popen([sys.executable, "-m", f"distributed.cli.dask_{program}", *words], cwd=tmp_path,
                              stderr=subprocess.DEVNULL, env={**os.environ, "PYTHONPATH": str(HOME)})
             for program, words in (("scheduler", [*scheduler[2:], "--host", "127.0.0.1", "--port", str(port)]),
                                    ("worker", [f"tls://127.0.0.1:{port}", *worker[3:]]))]  # fmt: skip

    def intrude(user, *files):
        """What was run of it."""
        commands.python(INTRUDES, str(port), str(left), str(user), *map(str, files), cwd=tmp_path)
        return len([*left.iterdir()])

    try:
        assert intrude(NOBODY, theirs.authority, theirs.certificate, theirs.key) == 0
        assert intrude(NOBODY, *(tmp_path / name for name in ("cluster.pem", "cluster.pem", "cluster.key"))) == 0
        assert intrude(0, *(tmp_path / name for name in ("cluster.pem", "cluster.pem", "cluster.key"))) == 1
    finally:
        for process in began:
            process.terminate()
            process.wait()


# --- A sweep on a cluster whose scheduler, workers and client are killed at random moments loses nothing.


@pytest.mark.slow
def test_kills_of_scheduler_workers_and_client(toy_with_commands, tmp_path):
    (tmp_path / "cluster").mkdir()
    cluster = Cluster(tmp_path / "cluster", secured=certificates(tmp_path / "secured"))
    try:
        count = killed(toy_with_commands, cluster, 12, random.Random(1))
    finally:
        cluster.close()
    assert count.problems == [] and set(count.hit) == set(VICTIMS) and count.survived >= 1
