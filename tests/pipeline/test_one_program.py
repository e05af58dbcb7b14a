"""One folder, one program, one environment: a checkout is computed by its own engine, stages come from one place."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import replace

import pytest

from pipeline.cache import processor
from pipeline.errors import StudyError
from pipeline.home import engine, face
from pipeline.study import locate
from tests import commands


@pytest.fixture
def other(repository, tmp_path):
    """As much of another checkout as tells that it is one."""
    (tmp_path / "pipeline").mkdir()
    for name in ("dvc.yaml", "pipeline/home.py"):
        shutil.copy(repository / name, tmp_path / name)
    return tmp_path.resolve()


@pytest.mark.parametrize("words", ["gait --json", "run-all --accuracy draft", "run analytic", "status", "unknown"])
def test_a_command_in_another_checkout_ends_with_a_sentence(other, words):
    done = commands.run(*words.split(), cwd=other)
    own = other / ".venv" / "bin" / "bipedstudy"
    assert done.returncode == 2 and done.stdout == "" and len(done.stderr.splitlines()) == 1
    assert f"{other} is computed by its own program, and this one is that of {engine()}; " in done.stderr
    assert done.stderr.endswith(f"run make install in {other}, then {own}\n")


def test_nor_does_a_notebook_mix_them(other):
    (other / "below").mkdir()
    with pytest.raises(StudyError, match="is computed by its own program"):
        locate(start=other / "below")


def test_a_copy_of_this_one_under_another_name_is_itself(repository, tmp_path):
    (tmp_path / "link").symlink_to(repository)
    assert locate(start=tmp_path / "link").root == repository.resolve()


def test_the_face_takes_the_stages_of_a_study_that_brings_its_own(toy_with_commands):
    """Questions as workers: the installed stages, which the face knows as its own, have no such question."""
    with_face = f"import sys; sys.path.insert(0, {str(face().parent)!r}); import bipedstudy; "
    code, out, errors = toy_with_commands.command("tally", "--jobs", "1", before=with_face)
    assert code == 0 and out, errors


def test_one_process_takes_the_stages_of_one_place(done):
    values = done.study().parameters(("side",))
    assert values and type(values["side"]).__module__.startswith(done.package)
    shutil.copytree(done.root, done.root.with_name("copy"))
    with pytest.raises(StudyError, match=f"another {done.package} was imported before, from {done.root}"):
        replace(done, root=done.root.with_name("copy")).study().parameters(("side",))


@pytest.mark.parametrize("begin", ["import bipedstudy", "import pipeline.cli as c; c.cli.main = int; c.main()"])
def test_notebooks_and_commands_compute_in_the_environment_of_workers(begin, monkeypatch):
    """Before NumPy is loaded, which reads it then."""
    monkeypatch.delenv(processor.VARIABLE, raising=False)  # what whoever runs the tests chose
    clean = {name: value for name, value in os.environ.items() if name not in processor.environment()}
    tell = (f"import os, sys, atexit; told = {sorted(processor.environment())}\n"
            f"sys.path.insert(0, {str(face().parent)!r})\n"
            "atexit.register(lambda: print('numpy' in sys.modules, [os.environ.get(name) for name in told]))\n")
    said = subprocess.run([sys.executable, "-c", tell + begin], cwd=engine(), env=clean, text=True, capture_output=True)
    assert said.stdout == f"False {[value for _, value in sorted(processor.environment().items())]}\n", said.stderr
