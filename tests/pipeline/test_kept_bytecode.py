"""What Python keeps compiled of this program and of a study's stages: a flipped bit is never believed."""

import importlib.util
import shutil
import sys
from pathlib import Path

import pytest

from pipeline import SealedLoader
from tests.pipeline.toy import flipped


@pytest.fixture
def kept(repository, tmp_path, monkeypatch):
    """What loads a source, what was kept of it, and the code that it means."""
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    copy = shutil.copy(repository / "stages/ground/laws.py", tmp_path)
    loader = SealedLoader("laws", str(copy))
    right = loader.get_code("laws")
    return loader, Path(importlib.util.cache_from_source(copy)), right


def test_any_flipped_bit_gives_the_code_of_the_source(kept):
    loader, path, right = kept
    whole = path.read_bytes()
    for at in range(0, len(whole), len(whole) // 200):
        path.write_bytes(flipped(whole, at))
        assert loader.get_code("laws") == right, at


def test_what_is_whole_is_taken_as_it_lies_and_what_python_left_is_sealed(kept, monkeypatch):
    (loader, path, right), compiled = kept, []
    monkeypatch.setattr(SealedLoader, "source_to_code", lambda self, data, path: compiled.append(path) or compile(
        data, path, "exec", dont_inherit=True))  # fmt: skip
    assert loader.get_code("laws") == right and compiled == []
    path.write_bytes(path.read_bytes()[:-32])  # as Python itself writes it
    assert loader.get_code("laws") == right and compiled.pop()
    assert loader.get_code("laws") == right and compiled == []


def test_commands_seal_what_they_keep_of_the_engine_and_keep_nothing_of_a_study(ran, repository):
    asked = {"PYTHONPYCACHEPREFIX": str(ran.root / "kept"), "PYTHONDONTWRITEBYTECODE": ""}
    assert ran.command("status", environment=asked)[0] == 0
    source = (repository / "pipeline/graph.py").relative_to("/").with_suffix("")
    (path,) = (ran.root / "kept").rglob(f"{source}.*.pyc")
    assert SealedLoader("", "").get_data(str(path)) == path.read_bytes()[:-32]
    assert not [*(ran.root / "kept" / ran.root.relative_to("/")).rglob("*.pyc")]
