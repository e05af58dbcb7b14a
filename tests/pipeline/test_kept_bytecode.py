"""What Python keeps compiled of this program and of a study's stages: a flipped bit is never believed."""

import importlib.util
import random
import shutil
import sys
from pathlib import Path

import pytest

from pipeline import SealedLoader

#: What computes, reads and decides: code of the engine and of stages.
SOURCES = ("pipeline/graph.py", "pipeline/study.py", "pipeline/cache/hdf5.py", "stages/imu/export.py",
           "stages/biped/kinematics.py", "stages/ground/laws.py", "stages/comparison/agreement.py")  # fmt: skip


@pytest.fixture
def kept(repository, tmp_path, monkeypatch):
    """Sources with what was kept of them, and the code that they mean."""
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    found = []
    for source in SOURCES:
        copy = tmp_path / source.replace("/", "_")
        shutil.copy(repository / source, copy)
        loader = SealedLoader(copy.stem, str(copy))
        right = loader.get_code(copy.stem)
        found.append((loader, Path(importlib.util.cache_from_source(str(copy))), right))
    assert all(path.is_file() for _, path, _ in found)
    return found


@pytest.mark.parametrize("flips", [100, pytest.param(1000, marks=pytest.mark.slow)])
def test_flips_give_the_code_of_the_source(kept, flips):
    chance, other = random.Random(4), []
    for number in range(flips):
        loader, path, right = chance.choice(kept)
        content = bytearray(path.read_bytes())
        at = chance.randrange(8 * len(content))
        content[at // 8] ^= 1 << at % 8
        path.write_bytes(content)
        if loader.get_code(loader.name) != right:
            other.append((number, path.name, at))
    assert other == []


def test_what_is_whole_is_taken_as_it_lies_and_what_python_left_is_sealed(kept, monkeypatch):
    compiled = []
    monkeypatch.setattr(SealedLoader, "source_to_code", lambda self, data, path: compiled.append(path) or compile(
        data, path, "exec", dont_inherit=True))  # fmt: skip
    for loader, path, right in kept:
        assert loader.get_code(loader.name) == right and compiled == []
        path.write_bytes(path.read_bytes()[:-32])  # as Python itself writes it
        assert loader.get_code(loader.name) == right and compiled.pop()
        assert loader.get_code(loader.name) == right and compiled == []


def test_commands_seal_what_they_keep_of_the_engine_and_keep_nothing_of_a_study(ran, repository):
    asked = {"PYTHONPYCACHEPREFIX": str(ran.root / "kept"), "PYTHONDONTWRITEBYTECODE": ""}
    assert ran.command("status", environment=asked)[0] == 0
    source = (repository / "pipeline/graph.py").relative_to("/").with_suffix("")
    (path,) = (ran.root / "kept").rglob(f"{source}.*.pyc")
    assert SealedLoader("", "").get_data(str(path)) == path.read_bytes()[:-32]
    assert not [*(ran.root / "kept" / ran.root.relative_to("/")).rglob("*.pyc")]
