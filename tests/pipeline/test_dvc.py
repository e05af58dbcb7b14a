"""`dvc repro` and `bipedstudy run-all` build the same study from the same dvc.yaml."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline import graph
from tests.pipeline.toy import Toy, git, put_on_path

DVC = shutil.which("dvc", path=os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")]))
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(DVC is None, reason="dvc is not installed (extra [dvc])"),
    pytest.mark.skipif(os.name != "posix", reason="puts a shell script on the path"),
]


def dvc(toy, command, *arguments):
    environment = {**os.environ, "PATH": f"{command.parent}:{os.environ['PATH']}", "DVC_NO_ANALYTICS": "1"}
    done = subprocess.run([DVC, *arguments], cwd=toy.root, env=environment, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def outcomes(said):
    """What DVC's own lines and those of the command say became of each stage; what was computed is current later."""
    found = re.findall(r"^(\w+) +(computed|restored|current) ", said, flags=re.M)
    return {name: next((how for stage, how in found if stage == name and how != "current"), "current")
            for name, _ in found}  # fmt: skip


def test_the_whole_study_by_either_way(repository, tmp_path):
    """A copy of the checkout under git, as a user has it, at level draft: results go to a remote, come back in a clone,
    and say there by themselves that they are current. An edit builds anew what it changes, and what it changed is told.
    """
    root = tmp_path / "study"
    for name in ("params", "pipeline", "stages"):
        shutil.copytree(repository / name, root / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("dvc.yaml", ".dvcignore", ".gitignore"):
        shutil.copyfile(repository / name, root / name)
    study, stages = Toy(root, "stages"), graph.read(root).stages
    study.edit("params/accuracy.yaml", "value: paper", "value: draft")
    git(root, "init", "-q")
    git(root, "config", "user.name", "a lab")
    git(root, "config", "user.email", "lab@example.org")
    git(root, "add", "-A")
    git(root, "commit", "-q", "-m", "as cloned")
    command = put_on_path(tmp_path / "bin", "$PWD", "--trust")
    subprocess.run([command, "run-all"], cwd=root, check=True, capture_output=True)
    right = study.results()
    for name in right:
        (root / "results" / name).unlink()
    dvc(study, command, "init")
    said = dvc(study, command, "repro")
    assert all(f"Running stage '{name}'" in said for name in stages)
    assert study.results() == right
    assert git(root, "status", "--porcelain", "--untracked-files").splitlines() == [
        "A  .dvc/.gitignore", "A  .dvc/config", "?? dvc.lock"]  # fmt: skip
    dvc(study, command, "remote", "add", "--default", "lab", str(tmp_path / "remote"))
    git(root, "add", "-A")
    git(root, "commit", "-q", "-m", "with results")
    dvc(study, command, "push")

    git(tmp_path, "clone", "-q", str(root), "clone")
    git(tmp_path / "clone", "config", "user.name", "a lab")
    git(tmp_path / "clone", "config", "user.email", "lab@example.org")
    clone = Toy(tmp_path / "clone", "stages")
    dvc(clone, command, "pull")
    said = subprocess.run([command, "status"], cwd=clone.root, check=True, text=True, capture_output=True).stdout
    assert [line.split() for line in said.splitlines()] == [[name, "current"] for name in stages]
    assert "Running stage" not in dvc(clone, command, "repro") and clone.results() == right

    limit = "params/comparison.yaml:position_limit.value"
    apart = outcomes(dvc(clone, command, "exp", "run", "--temp", "--set-param", f"{limit}=1e-5"))
    assert {name for name, how in apart.items() if how != "current"} == {"comparison", "figures"} < {*apart}
    assert clone.results() == right
    dvc(clone, command, "exp", "run", "--set-param", f"{limit}=1e-6")
    assert "results/claims.yaml" in dvc(clone, command, "metrics", "diff")
    picture = "results/figures/figure_08_hip_motion.png"
    compared = json.loads(dvc(clone, command, "plots", "diff", "--json"))["data"][picture]
    assert {name for each in compared for name in each["revisions"]} == {"HEAD", "workspace"}
    said = dvc(clone, command, "exp", "run", "--set-param", "params/ground.yaml:slope_deg.value=2.1", "analytic")
    assert outcomes(said) == {"analytic": "computed"}
