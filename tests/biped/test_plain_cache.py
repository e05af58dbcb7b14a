"""Where numba's caches are made of other parts than today's, it keeps machine code by itself: every command works."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys

import pytest

#: Python runs it when it starts, in every process of a command: parts of numba's caches that ours are made of are gone.
OTHER_NUMBA = "from numba.core import caching\ndel caching._CacheLocator, caching.CompileResultCacheImpl\n"
COLD = "compiling the equations of motion"


@pytest.fixture
def command(tmp_path, repository):
    """Runs a command of a copy of the study with such a numba, and gives what it says."""
    for name in ("dvc.yaml", "params"):
        source = repository / name
        (shutil.copytree if source.is_dir() else shutil.copy)(source, tmp_path / name)
    (tmp_path / "other").mkdir()
    (tmp_path / "other/sitecustomize.py").write_text(OTHER_NUMBA)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path / "other"), str(repository)]),
                   "NUMBA_CACHE_DIR": str(tmp_path / "cache")}  # fmt: skip

    def run(*arguments):
        return subprocess.run([sys.executable, "-m", "pipeline.cli", *arguments], cwd=tmp_path, env=environment,
                              text=True, capture_output=True)  # fmt: skip

    return run


def test_a_command_answers_the_same_and_finds_its_machine_code_again(command, tmp_path, repository):
    first, again = command("gait", "--json"), command("gait", "--json")
    assert (first.returncode, again.returncode) == (0, 0), first.stderr
    assert COLD in first.stderr and COLD not in again.stderr
    ours = subprocess.run([sys.executable, "-m", "pipeline.cli", "gait", "--json"], cwd=repository, text=True,
                          capture_output=True)  # fmt: skip
    assert json.loads(first.stdout) == json.loads(again.stdout) == json.loads(ours.stdout)
    (folder,) = (tmp_path / "cache/bipedstudy").glob("analytic-*")
    assert [*folder.rglob("*.nbi")] and not [*repository.rglob("stages/**/*.nbi")]


@pytest.mark.slow
def test_the_whole_study_and_what_needs_other_functions(command):
    for words in ("run-all --accuracy draft", "run-all --accuracy draft", "sensitivity"):
        done = command(*words.split())
        assert done.returncode == 0, done.stderr
    assert command("status").stdout.count("current") > 10
