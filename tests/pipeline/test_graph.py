"""dvc.yaml is the graph, and what the pipeline does not understand in it is refused."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from pipeline import graph
from pipeline.errors import StudyError
from stages.figures.drawn import NAMES
from tests.pipeline.toy import Toy, git, put_on_path


def refused(toy):
    with pytest.raises(StudyError) as caught:
        graph.read(toy.root)
    return caught.value.sentences


def test_order_and_dependencies(toy):
    found = graph.read(toy.root)
    assert list(found.stages) == ["fall", "bounce", "side", "picture"]
    assert found.upstream("picture") == ("bounce", "side")
    assert found.needed_for(("bounce",)) == ("fall", "bounce")
    assert found.stages["bounce"].parameters["ground"][0] == "gravity"
    assert found.stages["side"].parameters == {"side": None}
    with pytest.raises(StudyError, match=r'there is no stage "bonce" \(stages: .*\); did you mean "bounce"\?'):
        found.stage("bonce")


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("cmd: bipedstudy run side", "cmd: make side", 'cmd must be "bipedstudy run side", not \'make side\''),
        ("deps: [PACKAGE/side]", "wdir: x", 'the key "wdir" is not understood here (only cmd, meta, frozen, deps, '
         'params, outs, metrics, plots)'),
        ("deps: [PACKAGE/side]", "frozen: 3", "stage side: frozen must be true or false, not 3"),
        ("deps: [PACKAGE/side]", "frozen: true\n    deps: [PACKAGE/side]", "stage picture reads results/side.bin, but "
         "stage side is frozen and runs only when it is named; leave one of both out"),
        ("deps: [PACKAGE/side]", "dep: [x]", 'did you mean "deps"?'),
        ("results/side.bin]\n", "/x]\n", "outs: /x lies outside the study"),
        ("results/side.bin]\n", "results/side.bin]\n    metrics: [{side.json: {cache: false}}]\n",
         "metrics: side.json lies outside the study"),
        ("results/side.bin]\n", "results/side.bin]\n    plots: [{results/a.csv: {}, results/b.csv: {}}]\n",
         "stage side: plots must be a list of plain paths"),
        ("outs: [results/side.h5, ", "outs: [", "stage side: outs must list results/side.h5"),
        ("results/fall.h5]\n    params", "results/fal.h5]\n    params", 'reads results/fal.h5, which no stage makes; '
         'did you mean "results/fall.h5"?'),
        ("[results/bounce.h5]", "[results/bounce.h5, results/fall.h5]", "results/fall.h5 is made by both"),
        ("[PACKAGE/fall, PACKAGE/body]", "[results/bounce.h5]", "these stages wait for each other: bounce, fall"),
        ("- params/side.yaml:", "- seeds.yaml:", "params must be lines like"),
        ("params:\n      - params/side.yaml:", "params: 3", "stage side: params must be a list"),
        ("results/side.bin]\n", "results/.cache/lock]\n", "results/.cache/lock is this program's own place"),
        ("results/side.bin]\n", "results/report.html]\n", "results/report.html is this program's own place"),
        ("results/side.bin]\n", "results/log/side]\n", "results/log/side is this program's own place"),
        ("results/side.bin]\n", "results/figures/side]\n", "results/figures/side of stage side lie in"),
        ("results/side.bin]\n", "results/side.h5]\n", "results/side.h5 is made by side twice"),
        ("results/side.bin]\n", "results/../x]\n", "lies outside the study"),
        ("results/side.bin]\n", "'results/..\\x']\n", "lies outside the study"),
        ("results/side.bin]\n", "'results/c:x']\n", "lies outside the study"),
    ],
)  # fmt: skip
def test_what_is_not_understood_is_refused(toy, old, new, sentence):
    toy.edit("dvc.yaml", old.replace("PACKAGE", toy.package), new.replace("PACKAGE", toy.package))
    found = refused(toy)
    assert any(sentence in line for line in found), found


def test_a_file_that_is_no_graph_is_one_sentence(toy):
    for text in ("", "vars: [x]\nstages: {}\n", "[1]"):
        (toy.root / "dvc.yaml").write_text(text)
        (sentence,) = refused(toy)
        assert sentence.endswith('dvc.yaml: expected the key "stages" with the stages under it, and beside it only '
                                 "metrics and plots")  # fmt: skip


def test_what_dvc_shows_of_a_stage_is_an_out_of_it(toy):
    toy.edit("dvc.yaml", "outs: [results/side.h5, results/side.bin]", "outs: [results/side.h5]\n    metrics:\n      "
             "- results/side.bin: {cache: false}\n    plots:\n      - results/side.csv: {x: time, y: height}")
    with toy.path("dvc.yaml").open("a") as graph_file:
        graph_file.write("metrics: [results/side.bin]\nplots:\n  - results/side.csv: {x: time}\n")
    found = graph.read(toy.root)
    assert found.stages["side"].outs == ("results/side.h5", "results/side.bin", "results/side.csv")
    assert found.upstream("picture") == ("bounce", "side")


def test_what_dvc_compares_is_made_by_the_study(repository):
    """A misspelt file there would be said by DVC alone."""
    declared, outs = yaml.safe_load((repository / "dvc.yaml").read_text()), set()
    for stage in graph.read(repository).stages.values():
        outs.update(stage.outs)
    assert declared["metrics"] == [graph.CLAIMS] and graph.CLAIMS in outs and graph.FIGURES in outs
    assert declared["plots"] and {Path(path).parent.as_posix() for path in declared["plots"]} == {graph.FIGURES}
    assert {Path(path).stem for path in declared["plots"]} <= {*NAMES}


# --- `dvc repro` and `bipedstudy run-all` build the same study from the same dvc.yaml.


DVC = shutil.which("dvc", path=os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")]))


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


@pytest.mark.slow
@pytest.mark.skipif(DVC is None, reason="dvc is not installed (extra [dvc])")
@pytest.mark.skipif(os.name != "posix", reason="puts a shell script on the path")
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
