"""`bipedstudy init` lays out a study that works; `bipedstudy doctor` finds what is wrong; completion completes."""

import json
import os
import re
import shutil
import sys
from types import SimpleNamespace

import pytest

from pipeline import graph
from pipeline.commands import house
from pipeline.parameters import yaml_text
from tests import commands
from tests.pipeline.toy import HOME

CHECKS = (".github/workflows/figures.yml", ".gitlab-ci.yml")


def bipedstudy(folder, *words, **environment):
    """What comes of commands in a folder, each with its words in one text."""
    home = os.pathsep.join([str(HOME), *(path for path in sys.path if path)])
    return [*commands.each(*words, cwd=folder, PYTHONPATH=home, **environment).values()]


@pytest.fixture(scope="module")
def laid_out(tmp_path_factory):
    """A new study, and what `init` and `status` said of it; tests take a copy."""
    folder = tmp_path_factory.mktemp("laid")
    (init,) = bipedstudy(folder, "init mine")
    assert not list(folder.glob(".mine*"))
    return folder / "mine", init


@pytest.fixture
def mine(laid_out, tmp_path):
    return shutil.copytree(laid_out[0], tmp_path / "mine")


def test_a_new_study_has_the_same_stages_and_every_parameter(laid_out, repository):
    study, (code, out, errors) = laid_out
    assert (code, errors) == (0, "") and "cd mine" in out
    found = graph.read(study)
    assert list(found.stages) == list(graph.read(repository).stages)
    of_program = [name for name in found.stages if name not in found.usual]
    assert of_program == ["tradeoff", "extremes"], "what measures the program runs when it is named"
    assert not {*of_program} & {each for name in found.usual for each in found.upstream(name)}
    ((code, out, errors),) = bipedstudy(study, "status")
    assert code == 0, errors
    assert out.splitlines()[0].split() == ["analytic", "stale", "never", "run"]


def test_a_new_study_in_the_folder_where_one_stands_leaves_it_in_place_and_gets_its_checks_later(tmp_path):
    (place := tmp_path / "mine").mkdir()
    before = place.stat().st_ino
    laid, none = bipedstudy(place, "init . --no-workflow", "init . --no-workflow --update --json")
    assert laid[0] == 0 and place.stat().st_ino == before and (place / "dvc.yaml").exists()
    assert json.loads(none[1]) == {} and not [check for check in CHECKS if (place / check).exists()]
    (place / ".gitlab-ci.yml").write_text("mine")
    ((_, added, _),) = bipedstudy(tmp_path, "init mine --update --json")
    assert json.loads(added) == {"mine/.github/workflows/figures.yml": "added"}
    assert (place / ".gitlab-ci.yml").read_text() == "mine"


def test_a_study_laid_out_by_an_earlier_version_is_told_what_changed_and_renewed(mine):
    path, slope = mine / "dvc.yaml", mine / "params/ground.yaml"
    now = path.read_text()
    earlier = now.replace("      - params/comparison.yaml:\n", "      - params/biped.yaml:\n", 1)
    path.write_text(earlier)
    slope.write_text(slope.read_text().replace("value: 2.0", "value: 2.5"))
    own = slope.read_text()
    (mine / "params/imu.yaml").unlink()
    (code, _, errors), (_, out, _) = bipedstudy(mine, "status", "init . --update --json")
    assert code == 2 and "since 0.2.0 stage figures makes results/figures" in errors
    assert errors.rstrip().endswith("write it anew with: bipedstudy init . --update")
    assert json.loads(out) == {"dvc.yaml": "written anew; the old one is dvc.yaml.old", "params/imu.yaml": "added"}
    assert path.read_text() == now and path.with_suffix(".yaml.old").read_text() == earlier
    assert slope.read_text() == own, "parameters are the user's own"
    assert bipedstudy(mine, "status")[0][0] == 0
    path.write_text(f"# mine\n{now}")
    ((_, out, _),) = bipedstudy(mine, "init . --update --json")
    assert json.loads(out) == {"dvc.yaml": "written anew; the old one is dvc.yaml.old2"}
    assert path.with_suffix(".yaml.old").read_text() == earlier, "nor is what was kept written over"


def test_entries_that_an_earlier_version_had_elsewhere_are_moved_and_those_it_had_not_are_added(mine):
    """Five were moved by hand, and of one that was missing no value was named."""
    ground, twin, multibody, comparison = (mine / f"params/{name}.yaml" for name in
                                           ("ground", "twin", "multibody", "comparison"))  # fmt: skip
    own = 'block_sets: {value: 9, unit: "1",\n  source: "mine"}\n'
    (line,) = re.findall(r"^passing_chance:.*\n", comparison.read_text(), re.MULTILINE)
    comparison.write_text(comparison.read_text().replace(line, ""))
    ground.write_text(re.sub(r"^block_sets:.*\n", "", ground.read_text(), flags=re.MULTILINE))
    texts = [path.read_text() for path in (ground, twin, multibody)]
    twin.write_text(own + texts[1])
    multibody.write_text(texts[2] + 'block_length: {value: 0.09, unit: m, source: "mine"}\n')
    (code, out, _), (again, _, left) = bipedstudy(mine, "init . --update --json", "status")
    assert code == 0 and set(json.loads(out)) == {f"params/{name}.yaml" for name in ("comparison", "ground", "twin")}
    assert ground.read_text() == texts[0] + own and twin.read_text() == texts[1] and line in comparison.read_text()
    assert twin.with_suffix(".yaml.old").read_text() == own + texts[1], "what was there stays beside it"
    assert again == 2 and left.count("error") == 1 and 'did you mean "ground.block_length"?' in left
    assert "0.09" in multibody.read_text(), "of two values neither is chosen"
    twin.write_bytes(b"\xe9")
    ground.write_text("- 1\n")
    assert bipedstudy(mine, "init . --update")[0] == (2, "", "error: params/twin.yaml: not a text file in UTF-8\n")
    twin.write_text(texts[1])
    assert bipedstudy(mine, "init . --update")[0][0] == 0 and ground.read_text() == "- 1\n"


def test_dvc_makes_by_the_last_stage_all_that_run_all_makes(laid_out):
    """It stops at a frozen stage that never ran, so the pages name `figures`."""
    stages = graph.read(laid_out[0])
    assert stages.needed_for(("figures",)) == stages.usual


def test_a_new_study_brings_its_checks_for_github_and_gitlab(laid_out):
    github, gitlab = (yaml_text.read(laid_out[0] / check, check).value for check in CHECKS)
    steps = github["jobs"].value["figures"].value["steps"].value
    scripts = ([step.value["run"].value for step in steps if "run" in step.value],
               [line.value for line in gitlab["figures"].value["script"].value])  # fmt: skip
    for lines in scripts:
        checking = [line for line in lines if "bipedstudy figures --check --against expected" in line]
        assert len(checking) == 1 and lines.index("bipedstudy run-all") < lines.index(checking[0])
        assert "if [ -d results/figures ]; then cp -R results/figures expected; fi" in lines


def test_init_renews_no_checkout_and_never_writes_into_what_is_there(tmp_path, repository):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/notes.txt").write_text("mine")
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    there, link, checkout = bipedstudy(tmp_path, "init mine", "init link", f"init '{repository}' --update")
    assert there == (2, "", "error: mine: is there already and not an empty folder; choose another\n")
    assert link == (2, "", "error: link: is there already and not an empty folder; choose another\n")
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["notes.txt"]
    assert checkout[0] == 2 and "is not a study that `init` laid out" in checkout[2]


@pytest.mark.skipif(sys.platform in ("win32", "darwin"), reason="all names are Unicode there")
def test_a_name_that_is_no_utf_8_is_one_sentence(tmp_path):
    done = commands.run("init", os.fsdecode(b"mine\xff"), cwd=tmp_path)
    assert (done.returncode, [*tmp_path.iterdir()]) == (2, [])
    assert done.stderr == "error: 'mine\\udcff': is no name in UTF-8, as that of a study's folder must be\n"


def test_doctor_on_this_machine(repository):
    ((code, out, errors),) = bipedstudy(repository, "doctor --json")
    findings = {finding["what"]: finding for finding in json.loads(out)}
    assert {"exudyn", "versions", "results folder", "compile cache", "free disk", "cores"} <= set(findings), errors
    assert code == (1 if any(finding["state"] == "bad" for finding in findings.values()) else 0)


def test_a_library_that_does_not_load_is_bad_and_says_what_to_install(monkeypatch):
    def broken(name):
        raise ImportError("libGL.so.1: cannot open shared object file: No such file or directory")

    monkeypatch.setattr(house.importlib, "import_module", broken)
    _, state, text = house.exudyn()
    assert state == "bad" and text.endswith("apt-get install libgl1 libx11-6")


@pytest.mark.parametrize(
    ("line", "state", "text"),
    [
        ("click==0.0.1 \\", "warning", "click {} instead of 0.0.1"),
        ("no-such-package==1.0 \\", "bad", "not installed: no-such-package; make install"),
        ("setuptools==1 \\", "good", "all as in lock.txt"),
        ("no-such-package==1.0 ; python_version < '3' \\", "good", "all as in lock.txt"),
    ],
)
def test_versions_are_held_against_the_lock(tmp_path, line, state, text):
    import importlib.metadata

    (tmp_path / "lock.txt").write_text(f"{line}\n    --hash=sha256:00\n")
    _, found, said = house.versions(tmp_path / "lock.txt")
    assert found == state and text.format(importlib.metadata.version("click")) in said


def test_a_folder_that_cannot_be_written_is_bad(tmp_path):
    (tmp_path / "file").touch()
    assert house.writable("results", tmp_path / "file/below")[1] == "bad"
    assert house.writable("results", tmp_path / "new/below")[1] == "good"


def test_a_full_disk_and_a_cold_cache_are_told(monkeypatch, tmp_path):
    monkeypatch.setattr(house.shutil, "disk_usage", lambda path: SimpleNamespace(free=5_000_000))
    assert house.free_space(tmp_path) == ("free disk", "bad", "5 MB")
    for refusal, cold, state, text in (
        ("", True, "warning", "cold: the first use of stage fall compiles it"),
        ("", False, "good", "warm: stage fall in there"),
        ("others may write in it", True, "warning", "none: others may write in it, so every process compiles"),
    ):
        code = SimpleNamespace(refusal=refusal, folder="there", is_cold=lambda cold=cold: cold)
        stage = SimpleNamespace(__name__="stages.fall.compiled", CODE=code)
        ((_, found, said),) = house.compiled(SimpleNamespace(offered=lambda name, stage=stage: (stage,)))
        assert found == state and said.startswith(text)


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion(tmp_path, shell):
    said = commands.afresh(cwd=tmp_path, _BIPEDSTUDY_COMPLETE=f"{shell}_source").stdout
    assert "bipedstudy" in said and "complete" in said
