"""`dvc repro` and `bipedstudy run-all` build the same study from the same dvc.yaml."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

DVC = shutil.which("dvc", path=os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")]))
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(DVC is None, reason="dvc is not installed (extra [dvc])"),
    pytest.mark.skipif(os.name != "posix", reason="puts a shell script on the path"),
]


def dvc(toy, shims, *arguments):
    environment = {**os.environ, "PATH": os.pathsep.join([str(shims), os.environ["PATH"]]), "DVC_NO_ANALYTICS": "1"}
    done = subprocess.run([DVC, *arguments], cwd=toy.root, env=environment, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def shims(tmp_path_factory, repository):
    """A folder with the command `bipedstudy` as an installation would put it on the path."""
    folder = tmp_path_factory.mktemp("bin")
    command = folder / "bipedstudy"
    command.write_text(f'#!/bin/sh\nPYTHONPATH="{repository}" exec "{sys.executable}" -m pipeline.cli "$@"\n')
    command.chmod(0o755)
    return folder


def test_the_same_study_by_either_way(toy_with_commands, shims):
    toy = toy_with_commands
    code, _, errors = toy.command("run-all")
    assert code == 0, errors
    right = toy.results()
    shutil.rmtree(toy.root / "results")
    (toy.root / ".dvcignore").write_text("__pycache__\n")
    dvc(toy, shims, "init", "--no-scm")
    assert "Running stage 'fall'" in dvc(toy, shims, "repro")
    assert toy.results() == right
    assert [line.split()[1] for line in toy.command("run-all")[1].splitlines()] == ["current"] * 4

    toy.edit("params/ground.yaml", "value: 1e5", "value: 2e5")
    said = dvc(toy, shims, "repro")
    assert "Running stage 'bounce'" in said and "Running stage 'fall'" not in said
    assert [line.split()[1] for line in toy.command("run-all")[1].splitlines()] == ["current"] * 4

    toy.edit("params/ground.yaml", "value: 2e5", "value: 1e5")
    dvc(toy, shims, "repro", "--force")
    assert toy.results() == right
