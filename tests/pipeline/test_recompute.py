"""A stranger's results are held against what their parameters give here: the same, or which numbers are forged."""

import json
import random
import shutil
import sys
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from benchmarks import twice
from pipeline.changes.recompute import apart, chosen

STAGES = ("fall", "bounce", "side", "picture")


@pytest.fixture
def theirs(ran, tmp_path):
    """A stranger's results folder without its cache, beside the study of whoever asks."""
    folder = tmp_path / "theirs"
    shutil.copytree(ran.root / "results", folder, ignore=shutil.ignore_patterns(".cache"))
    return folder


def recompute(toy, folder, *more):
    code, out, errors = toy.command("recompute", str(folder), *more, "--json")
    assert code in (0, 2, 3), errors
    return code, json.loads(out) if out else errors


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


def test_results_are_the_same_where_they_follow(ran, theirs):
    code, found = recompute(ran, theirs)
    assert code == 0 and not found["differs"] and {row["stage"] for row in found["stages"]} == {*STAGES}


def test_a_forged_number_is_found_and_named_and_nothing_of_either_folder_changes(ran, theirs):
    chance = random.Random(5)
    name = chance.choice(numbers(theirs / "fall.h5"))
    forge(theirs / "fall.h5", name, chance)
    before = {path: path.read_bytes() for folder in (theirs, ran.root / "results") for path in folder.rglob("*.h5")}
    code, found = recompute(ran, theirs)
    rows = {row["stage"]: row["differences"] for row in found["stages"]}
    assert code == 3 and found["differs"] and name in {row["path"] for row in rows["fall"]}
    assert all(path.read_bytes() == content for path, content in before.items())


def test_parameters_that_two_artefacts_state_differently_are_a_difference(ran, theirs):
    assert ran.command("run-all", "--set", "ground.gravity=5")[0] == 0
    shutil.copy(ran.root / "results/fall.h5", theirs / "fall.h5")
    assert ran.command("run-all")[0] == 0
    code, found = recompute(ran, theirs)
    assert code == 3 and any("ground.gravity" in row["path"] for each in found["stages"] for row in each["differences"])


def test_null_in_one_artefact_is_what_follows_in_another(toy_with_commands, tmp_path):
    """A stage that needs it fills it in, one that only reads the file leaves it; any other value is a difference."""
    toy = toy_with_commands
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
    code, _, errors = toy.command("run-all")
    assert code == 0, errors
    assert recompute(toy, toy.root / "results")[0] == 0
    theirs = shutil.copytree(toy.root / "results", tmp_path / "theirs")
    assert toy.command("run", "side", "--set", "picture.pace=3")[0] == 0
    shutil.copy(toy.root / "results/side.h5", theirs)
    code, found = recompute(toy, theirs)
    assert code == 3 and "picture.pace" in str(found["stages"])


def test_a_share_finds_as_often_as_it_promises():
    drawn = [chosen(STAGES, 0.5, seed) for seed in range(400)]
    assert {len(names) for names in drawn} == {2}
    assert 160 < sum("fall" in names for names in drawn) < 240


@pytest.mark.parametrize("count", [40, pytest.param(1000, marks=pytest.mark.slow)])
def test_each_of_many_forgeries_is_found_by_one_recomputation(done, tmp_path, count):
    chance = random.Random(7)
    honest = {stage: (done.root / f"results/{stage}.h5").read_bytes() for stage in STAGES}
    fields = [(stage, name) for stage in STAGES for name in numbers(done.root / f"results/{stage}.h5")]
    missed = []
    for number in range(count):
        stage, name = chance.choice(fields)
        path = tmp_path / f"{number}.h5"
        path.write_bytes(honest[stage])
        forge(path, name, chance)
        if not list(apart(path.read_bytes(), honest[stage], stage, exactly=True)):
            missed.append((stage, name))
        path.unlink()
    assert missed == []


def test_a_folder_without_results_is_refused(ran, tmp_path):
    (tmp_path / "empty").mkdir()
    code, said = recompute(ran, tmp_path / "empty")
    assert code == 2 and "result" in said


# --- Computing a study twice: what does not repeat is named.


def test_a_stage_that_does_not_repeat_is_named(toy_with_commands, monkeypatch, capsys):
    toy, said = toy_with_commands, []
    toy.edit("PACKAGE/side/run.py", "random.Random(parameters.settings.seed)", "random.SystemRandom()")
    toy.edit("PACKAGE/side/run.py", "randrange(1000)", "randrange(10**9)")
    toy.edit("PACKAGE/side/run.py", "bytes([number % 256])", "str(number).encode()")

    def run(words, stdout):
        assert words[:3] == [sys.executable, "-m", "pipeline.cli"] and stdout is sys.stderr
        code, _, errors = toy.command(*words[3:])
        said.append(errors)
        return SimpleNamespace(returncode=code)

    monkeypatch.chdir(toy.root)
    monkeypatch.setattr(twice, "subprocess", SimpleNamespace(run=run))
    monkeypatch.setattr(sys, "argv", ["twice", "hashes.txt"])
    with pytest.raises(SystemExit) as ended:
        twice.main()
    differ = ended.value.code.partition(": ")[2].split(", ")
    assert {"side.h5", "side.bin"} <= {*differ} and "fall.h5" not in differ
    assert "computing it again gave other bytes than before" in "".join(said)
    listed = (toy.root / "hashes.txt").read_text().splitlines()
    assert listed == capsys.readouterr().out.splitlines()
    assert len(listed) == 8 and all(len(line.split()[0]) == 64 for line in listed)
