"""A stranger's results are held against what their parameters give here: the same, or which numbers are forged."""

import json
import random
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from benchmarks import twice
from pipeline.cache import artefact, fingerprint
from pipeline.changes.recompute import apart, chosen, held, unstated
from pipeline.errors import StudyError
from pipeline.parameters import loading
from pipeline.report import page
from pipeline.report.page import entries
from tests.pipeline.test_stages_that_say_no import can_do_without

STAGES = ("fall", "bounce", "side", "picture")


@pytest.fixture
def theirs(ran, tmp_path):
    """A stranger's results folder without its cache, beside the study of whoever asks."""
    folder = tmp_path / "theirs"
    shutil.copytree(ran.root / "results", folder, ignore=shutil.ignore_patterns(".cache"))
    return folder


def recompute(toy, folder, code):
    """What recomputing a folder says, which ends with this code."""
    return json.loads(toy.says(f"recompute {folder} --json", code=code))


def numbers(path):
    """Names of the datasets of numbers of an artefact."""
    with h5py.File(path) as file:
        found: list[str] = []
        file.visititems(lambda name, item: found.append(name) if getattr(item, "size", None) and
                        item.dtype.kind in "fi" and name.split("/")[0] != "provenance" else None)  # fmt: skip
    return found


def forge(path, name, chance):
    """Change one number of an artefact by a part of 1e-9, or by one."""
    with h5py.File(path, "r+") as file:
        values = np.array(file[name][()])
        at = tuple(chance.randrange(size) for size in values.shape)
        values[at] = values[at] * (1 + 1e-9) + (values[at] == 0) if values.dtype.kind == "f" else values[at] + 1
        file[name][...] = values


def test_a_forged_number_is_found_and_named_and_nothing_of_either_folder_changes(ran, theirs):
    chance, folders = random.Random(5), (theirs, ran.root / "results")
    found = recompute(ran, theirs, 0)
    assert not found["differs"] and {row["stage"] for row in found["stages"]} == {*STAGES}
    name = chance.choice(numbers(theirs / "fall.h5"))
    forge(theirs / "fall.h5", name, chance)
    before = {path: path.read_bytes() for folder in folders for path in folder.rglob("*.h5")}
    found = recompute(ran, theirs, 3)
    rows = {row["stage"]: row["differences"] for row in found["stages"]}
    assert found["differs"] and name in {row["path"] for row in rows["fall"]}
    assert all(path.read_bytes() == content for path, content in before.items())
    said = ran.says(f"recompute {theirs}", code=3)
    assert name in said and "more, in --json" not in said


def test_a_field_that_only_one_has_is_a_difference_and_named_as_what_it_is(ran, theirs):
    content, name = (theirs / "fall.h5").read_bytes(), numbers(theirs / "fall.h5")[0]
    with h5py.File(theirs / "fall.h5", "r+") as file:
        del file[name]
    without = (theirs / "fall.h5").read_bytes()
    for pair, kinds in (((content, without), ("a dataset", "nothing")), ((without, content), ("nothing", "a dataset"))):
        rows = [row for row in apart(*pair, "fall", exactly=True) if row["path"] == name]
        assert [(row["theirs"], row["recomputed"]) for row in rows] == [kinds]


def test_a_number_of_another_machine_may_be_off_by_its_error_alone(theirs):
    path = theirs / "fall.h5"
    name = next(each for each in numbers(path) if h5py.File(path)[each].dtype.kind == "f")
    contents = []
    for change in (0.0, 0.5, 2.0):
        with h5py.File(path, "r+") as file:
            file[name].attrs[artefact.ERROR] = 1.0
            file[name][...] = np.full(file[name].shape, 7.0 + change)
        contents.append(path.read_bytes())
    assert not [*apart(contents[1], contents[0], "fall", exactly=False)]
    (row,) = apart(contents[2], contents[0], "fall", exactly=False)
    assert (row["path"], row["apart"], row["allowed"]) == (name, 2.0, 1.0)


def test_null_in_one_artefact_is_what_follows_in_another(toy, tmp_path):
    """A stage that needs it fills it in, one that only reads the file leaves it; any other value is a difference."""
    pace = '\n    pace: float | None = parameter("s", "null: half the wait", default=None)'
    toy.edit("PACKAGE/picture/parameters.py", '"a second figure")', f'"a second figure"){pace}')
    toy.edit("PACKAGE/side/parameters.py", "from dataclasses import dataclass",
             "from dataclasses import dataclass, replace\nfrom PACKAGE.picture.parameters import Settings as Other"
             .replace("PACKAGE", toy.package))  # fmt: skip
    toy.edit("PACKAGE/side/parameters.py", "    settings: Settings", """    settings: Settings
    other: Other

    def __post_init__(self):
        if self.other.pace is None:
            object.__setattr__(self, "other", replace(self.other, pace=self.settings.wait / 2))""")
    toy.edit("dvc.yaml", "params/side.yaml:", "params/side.yaml:\n      - params/picture.yaml:")
    side = f"deps: [{toy.package}/side"
    toy.edit("dvc.yaml", f"{side}]", f"{side}, {toy.package}/picture/parameters.py]")
    toy.run()
    theirs = shutil.copytree(toy.root / "results", tmp_path / "theirs")
    assert not held(toy.study(), theirs, None, 1.0, 1)["differs"]
    toy.run("picture.pace=3", names=("side",))
    shutil.copy(toy.root / "results/side.h5", theirs)
    assert "picture.pace" in str(held(toy.study(), theirs, None, 1.0, 1)["stages"])


def test_a_stage_that_said_no_says_no_again(done, tmp_path):
    """Its parameters are stated nowhere: they are those of the study at hand, where no other result names them."""
    toy = can_do_without(done)
    toy.edit("params/fall.yaml", "value: well", "value: answer")
    toy.fails()
    theirs = shutil.copytree(toy.root / "results", tmp_path / "theirs")
    assert not (theirs / "fall.h5").exists() and not held(toy.study(), theirs, None, 1.0, 1)["differs"]
    toy.edit("params/fall.yaml", "value: answer", "value: well")
    with pytest.raises(StudyError, match="where that stage does not say no"):
        held(toy.study(), theirs, None, 1.0, 1)


def test_a_stage_without_an_artefact_has_values_and_half_widths_from_the_same_place(monkeypatch):
    """A half width that an artefact names was dropped; one at hand goes with the value at hand alone."""
    about = {"other": {fingerprint.INGREDIENTS: json.dumps({"parameters": {"robot": {
        "mass": 2.0, "mass half-width": 0.05, "length": 3.0, "width": None}}})}}  # fmt: skip
    here = {"robot": {"mass": 1.0, "mass half-width": 0.5, "length": 1.0, "length half-width": 0.5, "width": 4.0,
                      "depth": 5.0, "depth half-width": 0.5}}  # fmt: skip
    monkeypatch.setattr(loading, "as_plain", lambda own: here)
    monkeypatch.setattr(loading, "filled", lambda kind, plain: plain)
    found = unstated(SimpleNamespace(parameters=lambda names: dict.fromkeys(names)), ["other"], about)
    assert found == {"other": {"robot": {
        "mass": 2.0, "mass half-width": 0.05, "length": 3.0, "width": None, "depth": 5.0, "depth half-width": 0.5}}}


def test_results_of_a_study_that_leaves_an_input_out_are_refused_before_anything_is_computed(done, tmp_path):
    toy = can_do_without(done)
    whole = (toy.root / "dvc.yaml").read_text()
    toy.edit("dvc.yaml", "      - results/bounce.h5\n", "")
    toy.run()
    theirs = shutil.copytree(toy.root / "results", tmp_path / "theirs")
    assert not held(toy.study(), theirs, None, 1.0, 1)["differs"]
    (toy.root / "dvc.yaml").write_text(whole)
    (theirs / "bounce.h5").unlink()
    with pytest.raises(StudyError, match=r"picture\.h5: was made without results/bounce.h5, which that stage reads"):
        held(toy.study(), theirs, None, 1.0, 1)


def test_a_share_finds_as_often_as_it_promises():
    drawn = [chosen(STAGES, 0.5, seed) for seed in range(400)]
    assert {len(names) for names in drawn} == {2}
    assert 160 < sum("fall" in names for names in drawn) < 240


@pytest.mark.parametrize("stage", STAGES)
def test_a_forgery_of_any_number_is_found_by_one_recomputation(done, tmp_path, stage):
    path, honest = tmp_path / "forged.h5", (done.root / f"results/{stage}.h5").read_bytes()
    for name in numbers(done.root / f"results/{stage}.h5"):
        path.write_bytes(honest)
        forge(path, name, random.Random(7))
        assert [*apart(path.read_bytes(), honest, stage, exactly=True)], name


# --- Computing a study twice: what does not repeat is named.


def test_a_stage_that_does_not_repeat_is_named(toy, monkeypatch, capsys):
    for old, new in (("random.Random(parameters.settings.seed)", "random.SystemRandom()"),
                     ("randrange(1000)", "randrange(10**9)"), ("bytes([number % 256])", "str(number).encode()")):
        toy.edit("PACKAGE/side/run.py", old, new)

    def command(*words):
        if words[0] == "run-all":
            toy.run(force="--force" in words)
        else:
            study = toy.study()
            Path(words[-1]).write_bytes(page.render(study, entries(study), False, {}))

    monkeypatch.chdir(toy.root)
    monkeypatch.setattr(twice, "_bipedstudy", command)
    monkeypatch.setattr(sys, "argv", ["twice", "hashes.txt"])
    with pytest.raises(SystemExit) as ended:
        twice.main()
    differ = ended.value.code.partition(": ")[2].split(", ")
    assert {"side.h5", "side.bin"} <= {*differ} and "fall.h5" not in differ
    said = capsys.readouterr()
    assert "computing it again gave another result than before" in said.err
    listed = (toy.root / "hashes.txt").read_text().splitlines()
    assert listed == said.out.splitlines()
    assert len(listed) == 8 and all(len(line.split()[0]) == 64 for line in listed)
