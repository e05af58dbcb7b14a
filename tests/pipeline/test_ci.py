"""Figures in CI: the script of docs/ci.md does what the page says, in a fresh clone with results that were kept."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import pytest

from tests.pipeline import documented
from tests.pipeline.toy import HOME

#: What has the toy's stage draw a picture in PNG, whose grey follows from a setting.
PICTURE = """\
    from io import BytesIO
    from PIL import Image
    Image.new("L", (20, 10), 20 * len(title)).save(file := BytesIO(), format="png")
    files["figures/one.png"] = file.getvalue()
"""


def git(folder, *words):
    subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *words], cwd=folder, check=True,
                   capture_output=True)  # fmt: skip


@pytest.fixture
def hosted(ran, tmp_path_factory):
    """A repository with a study, what was kept of its results, and the commands that a runner has."""
    host = tmp_path_factory.mktemp("host")
    ran.edit("PACKAGE/picture/run.py", "    if parameters", PICTURE + "    if parameters")
    assert ran.command("run-all")[0] == 0
    (ran.root / ".gitignore").write_text("results/\nexpected/\n__pycache__/\n")
    shutil.copytree(ran.root / "results", host / "kept/results")
    git(ran.root, "init", "-q", "-b", "main")
    (host / "bin").mkdir()
    program = host / "bin/bipedstudy"
    program.write_text(f'#!/bin/sh\nPYTHONPATH="$PWD:{HOME}" exec "{sys.executable}" -m pipeline.cli --trust "$@"\n')
    program.chmod(0o755)
    return ran, host


def checked(toy, host, name):
    """What the script of the page says and ends with in a shallow clone called `name` of what the study is now."""
    git(toy.root, "add", "-A")
    git(toy.root, "commit", "-q", "--allow-empty", "-m", name)
    git(host, "clone", "-q", "--depth", "1", toy.root.as_uri(), name)
    (script,) = (block for block in documented.blocks(HOME / "docs/ci.md", "sh") if "--check" in block)
    environment = {**os.environ, "PATH": f"{host / 'bin'}:{os.environ['PATH']}", "KEPT": str(host / "kept"),
                   "COLUMNS": "200"}  # fmt: skip
    done = subprocess.run(["bash", "-c", script], cwd=host / name, env=environment, text=True, capture_output=True)
    assert "Traceback" not in done.stderr
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("cache", ["with", "without"])
def test_in_a_fresh_clone_only_what_an_edit_touches_is_computed(hosted, cache):
    toy, host = hosted
    if cache == "without":
        shutil.rmtree(host / "kept/results/.cache")
    code, out, errors = checked(toy, host, "same")
    assert code == 0, out + errors
    assert out.count(" current ") == 4 and "0 differ" in out and not (host / "same/results/differences").exists()
    toy.edit("params/picture.yaml", "title: fall", "title: falling")
    code, out, errors = checked(toy, host, "edited")
    assert code == 1, out + errors
    assert out.count(" current ") == 3 and out.count(" computed ") == 1
    assert "beyond what is allowed" in out
    assert [*(host / "edited/results/differences").glob("*.png")]
