"""Workers and what a stage is given: typed inputs, foreign output, and what a user keeps beside his study."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest

from pipeline.errors import StageFailed
from pipeline.execution.display import Display
from pipeline.execution.executor import bring_up_to_date
from pipeline.execution.inputs import disagreements
from pipeline.graph import Stage
from pipeline.study import Study

BOUNCE = "PACKAGE/bounce/run.py"


@pytest.mark.parametrize(
    ("path", "old", "new", "sentence"),
    [
        ("dvc.yaml", "      - results/side.bin\n", "",
         'its Inputs have "side", but dvc.yaml lists no such result and no parameter such a file'),
        (BOUNCE, "    fall: Fall\n", "    fal: Fall\n",
         'dvc.yaml lists results/fall.h5 among its deps, but its Inputs have no "fall"; did you mean "fal"?'),
        (BOUNCE, "    fall: Fall\n", "    fall: Result\n",
         'its Inputs have "fall" as PACKAGE.bounce.result.Result; allowed: PACKAGE.fall.result.Result'),
        ("PACKAGE/picture/run.py", "    side: Path\n", "    side: Bounce\n",
         'its Inputs have "side" as PACKAGE.bounce.result.Result; allowed: pathlib.Path'),
    ],
)  # fmt: skip
def test_inputs_that_disagree_with_the_graph_are_one_sentence(done, path, old, new, sentence):
    done.edit(path, old, new)
    with pytest.raises(StageFailed) as failed:
        done.run()
    assert len(failed.value.sentences) == 1
    assert failed.value.sentences[0].partition(": ")[2].startswith(sentence.replace("PACKAGE", done.package))


def test_every_disagreement_is_found_at_once():
    @dataclasses.dataclass(frozen=True)
    class Inputs:
        one: Path

    stage = Stage("last", (), ("results/two.bin", "results/three.bin"), {}, ())
    found = list(disagreements("package", stage, Inputs, dataclasses.make_dataclass("Parameters", ())))
    assert [sentence.split('"')[1] for sentence in found] == ["two", "three", "one"]


def test_a_stage_may_take_a_result_as_the_file_itself(done):
    done.edit(BOUNCE, "    fall: Fall\n", "    fall: Path\n")
    done.edit(BOUNCE, f"from {done.package}.fall.result import Result as Fall", "from pathlib import Path")
    done.edit(BOUNCE, "    assert not fall.files\n", "    return Result(float(fall.stat().st_size))\n")
    assert done.run(names=("bounce",))["bounce"] == "computed"


def test_a_file_that_changes_while_a_stage_reads_it_is_refused(toy, monkeypatch):
    table = toy.root / "lab.txt"
    table.write_text("41")
    toy.edit("PACKAGE/side/run.py", "        number = int(", "        while inputs.table.read_text() != '42':\n"
             "            progress(0.5, 'waits')\n        number = int(")  # fmt: skip
    monkeypatch.setattr(Display, "progress", lambda *told: table.write_text("42"))
    with pytest.raises(StageFailed, match=r"its input table was changed while it ran, so its result was not kept"):
        toy.run("side.table=lab.txt", names=("side",))


def test_a_relative_import_is_refused(done):
    done.edit("PACKAGE/fall/run.py", f"from {done.package}.fall.errors import", "from .errors import")
    with pytest.raises(StageFailed, match=r"it imports \w+/fall/errors\.py in a way that cannot be seen in the text"):
        done.run()


def test_what_others_print_before_a_worker_begins_is_no_message(done, own_server, tmp_path, monkeypatch):
    (tmp_path / "sitecustomize.py").write_text("print('hello', 3, '[]', '{}', '{\"a\": 1}', '', sep='\\n', flush=True)")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    assert done.run("fall.height=3", names=("fall",)) == {"fall": "computed"}


def test_a_pipeline_of_the_users_own_disturbs_no_stage(toy):
    for name in ("pipeline", "h5py", "queue"):
        (toy.root / f"{name}.py").write_text("raise SystemExit('not this one')")
    assert set(toy.run().values()) == {"computed"}


def test_a_folder_with_the_name_of_the_stages_is_not_taken_for_them(toy, tmp_path, monkeypatch):
    """A study laid out by `init` lists no code: its stages are the installed ones, whatever lies beside it."""
    monkeypatch.syspath_prepend(str(toy.root))  # where the toy's package is installed
    mine = tmp_path / "mine"
    (mine / toy.package).mkdir(parents=True)
    (mine / toy.package / "__init__.py").write_text("raise SystemExit('not this one')")
    (mine / "params").symlink_to(toy.root / "params")
    graph = re.sub(rf"\n *- {toy.package}/.*|{toy.package}/[^,\]]*,? ?", "", (toy.root / "dvc.yaml").read_text())
    (mine / "dvc.yaml").write_text(graph)
    study = Study(mine, mine / "params", mine / "results", (), toy.package)
    assert toy.package not in graph and study.code_root == toy.root
    values = study.parameters(tuple(study.graph.stages))
    assert {outcome.how for outcome in bring_up_to_date(study, values, Display())} == {"computed"}
