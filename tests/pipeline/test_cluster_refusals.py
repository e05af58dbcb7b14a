"""Clusters with certificates, and what refuses: strangers, machines with other code, machines with other versions."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

pytest.importorskip("distributed", reason="needs the extra cluster")

from tests import commands
from tests.pipeline import documented
from tests.pipeline.dask_processes import Cluster, certificates, free_port
from tests.pipeline.toy import HOME

NOBODY = 65534
SWEEP = "stage: side\nkind: grid\nvary: {side.seed: [1, 2, 3, 4, 5]}\n"


@pytest.fixture
def toy(toy_with_commands):
    (toy_with_commands.root / "seeds.yaml").write_text(SWEEP)
    return toy_with_commands


@pytest.fixture
def started(tmp_path):
    """Starts a cluster with one worker."""
    clusters = []

    def start(**how):
        folder = tmp_path / f"cluster-{len(clusters)}"
        folder.mkdir()
        clusters.append(cluster := Cluster(folder, **how))
        cluster.start_scheduler()
        cluster.start_workers(1)
        cluster.wait_for_workers(1)
        return cluster

    yield start
    for cluster in clusters:
        cluster.close()


def swept(toy, *words):
    code, out, errors = toy.command("sweep", "seeds.yaml", *words)
    assert "Traceback" not in errors and "unexpected" not in errors, errors
    return code, out, errors.strip().splitlines()[-1] if errors.strip() else ""


@pytest.mark.slow
def test_a_cluster_with_certificates_by_arguments_and_by_configuration(toy, started, tmp_path, monkeypatch):
    mine, strangers = certificates(tmp_path / "mine"), certificates(tmp_path / "strangers")
    cluster = started(secured=mine)
    code, out, said = swept(toy, "--cluster", cluster.address, "--out", "there.h5", *mine.options())
    assert code == 0 and "5 computed" in out, said
    assert swept(toy, "--cluster", cluster.address, *strangers.options())[0] == 2
    said = swept(toy, "--cluster", cluster.address, *strangers.options())[2]
    assert "no dask scheduler answers there (" in said and "certificate" in said.lower()
    said = swept(toy, "--cluster", cluster.address.replace("tls", "tcp"))[2]
    assert "no dask scheduler answers there" in said
    (toy.root / "results/sweeps").rename(toy.root / "elsewhere")  # so that nothing is known
    for name, file in (("CA_FILE", mine.authority), ("CLIENT__CERT", mine.certificate), ("CLIENT__KEY", mine.key)):
        monkeypatch.setenv(f"DASK_DISTRIBUTED__COMM__TLS__{name}", str(file))
    code, out, said = swept(toy, "--cluster", cluster.address, "--out", "again.h5")
    assert code == 0 and "0 were known" in out, said
    (toy.root / "results/sweeps").rename(toy.root / "elsewhere-2")
    assert swept(toy, "--out", "here.h5")[0] == 0
    tables = {(toy.root / name).read_bytes() for name in ("there.h5", "again.h5", "here.h5")}
    assert len(tables) == 1


def test_certificates_that_cannot_be_used_are_one_sentence(toy, tmp_path):
    mine, other = certificates(tmp_path / "mine"), certificates(tmp_path / "other")
    there = ("--cluster", "tls://127.0.0.1:9")
    code, _, said = swept(toy, *there)
    assert code == 2 and "needs certificates: --tls-ca-file" in said
    assert "needs certificates" in swept(toy, *there, "--tls-ca-file", str(mine.authority))[2]
    mixed = [*mine.options()[:-1], str(other.key)]
    assert "the certificates cannot be used: " in swept(toy, *there, *mixed)[2]
    mine.certificate.write_text("no certificate")
    assert "the certificates cannot be used: " in swept(toy, *there, *mine.options())[2]
    assert "begins with tls://" in swept(toy, "--cluster", "tcp://127.0.0.1:9", *mine.options())[2]
    assert "are for --cluster" in swept(toy, *mine.options())[2]


@pytest.mark.slow
def test_a_machine_with_other_code_of_this_program_refuses(toy, started, tmp_path):
    shutil.copytree(HOME / "pipeline", tmp_path / "other/pipeline")
    row = tmp_path / "other/pipeline/sweep/pool.py"
    row.write_text(row.read_text() + "LATER = 1\n")
    cluster = started(first_on_path=(tmp_path / "other",))
    code, _, said = swept(toy, "--cluster", cluster.address)
    assert code == 1 and "pipeline/sweep/pool.py differs from what the sweep was started with" in said
    assert "the machine " in said


@pytest.mark.slow
def test_a_machine_with_other_versions_refuses(toy, started, tmp_path):
    (tmp_path / "other/h5py-9.9.dist-info").mkdir(parents=True)
    cluster = started(first_on_path=(tmp_path / "other",))
    code, _, said = swept(toy, "--cluster", cluster.address)
    assert code == 1 and "has h5py 9.9 instead of " in said


@pytest.mark.slow
def test_a_machine_without_this_program_is_a_sentence(toy, started, tmp_path):
    (tmp_path / "other/pipeline").mkdir(parents=True)
    missing = "raise ModuleNotFoundError('No module named pipeline')"  # empty, an editable install would fill it
    (tmp_path / "other/pipeline/__init__.py").write_text(missing)
    cluster = started(first_on_path=(tmp_path / "other",))
    code, _, said = swept(toy, "--cluster", cluster.address)
    assert code == 1 and "every machine of a cluster needs this program" in said


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
        commands.python(INTRUDES, str(port), str(left), str(user), *map(str, files), cwd=tmp_path, env={**os.environ})
        return len([*left.iterdir()])

    try:
        assert intrude(NOBODY, theirs.authority, theirs.certificate, theirs.key) == 0
        assert intrude(NOBODY, *(tmp_path / name for name in ("cluster.pem", "cluster.pem", "cluster.key"))) == 0
        assert intrude(0, *(tmp_path / name for name in ("cluster.pem", "cluster.pem", "cluster.key"))) == 1
    finally:
        for process in began:
            process.terminate()
            process.wait()
