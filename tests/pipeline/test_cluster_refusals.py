"""Clusters with certificates, and what refuses: strangers, machines with other code, machines with other versions."""

from __future__ import annotations

import shutil

import pytest

pytest.importorskip("distributed", reason="needs the extra cluster")

from tests.pipeline.dask_processes import Cluster, certificates
from tests.pipeline.toy import HOME

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
    row = tmp_path / "other/pipeline/sweep/journal.py"
    row.write_text(row.read_text() + "LATER = 1\n")
    cluster = started(first_on_path=(tmp_path / "other",))
    code, _, said = swept(toy, "--cluster", cluster.address)
    assert code == 1 and "pipeline/sweep/journal.py differs from what the sweep was started with" in said
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
    (tmp_path / "other/pipeline/__init__.py").write_text("")
    cluster = started(first_on_path=(tmp_path / "other",))
    code, _, said = swept(toy, "--cluster", cluster.address)
    assert code == 1 and "every machine of a cluster needs this program" in said
