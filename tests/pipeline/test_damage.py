"""Files that were truncated, edited or forged are never taken for results, and cost no valid one."""

from __future__ import annotations

import json
import os

import pytest

from pipeline.cache import disk
from pipeline.errors import ArtefactError
from pipeline.execution.executor import Planner


def reasons(toy):
    study = toy.study()
    names = tuple(study.graph.stages)
    return {item.name: item.reasons for item in Planner(study, study.parameters(names)).survey(names)}


def entry_folder(toy, stage):
    record = json.loads((toy.root / f"results/.cache/current/{stage}.json").read_text())
    return toy.root / "results/.cache" / record["key"]


@pytest.mark.parametrize("damage", [lambda content: content[:-100], lambda content: b"", lambda content: content + b"x",
                                    lambda content: content.replace(b"Result", b"result") + b"\0"])  # fmt: skip
def test_a_damaged_artefact_is_seen_and_put_right(done, damage):
    before = done.results()
    path = done.root / "results/fall.h5"
    path.write_bytes(damage(path.read_bytes()))
    assert reasons(done)["fall"] == ("results/fall.h5 was edited or damaged",)
    assert done.run()["fall"] == "restored"
    assert done.results() == before


def test_one_flipped_bit_of_the_same_length_is_seen(done):
    path = done.root / "results/bounce.h5"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    assert done.run()["bounce"] == "restored"


def test_a_damaged_store_is_computed_again_when_it_is_needed(done):
    before = done.results()
    stored = entry_folder(done, "fall") / "results/fall.h5"
    stored.write_bytes(stored.read_bytes()[:-10])
    assert set(done.run().values()) == {"current"}  # the good copy in the results folder is untouched
    (done.root / "results/fall.h5").unlink()
    assert done.run()["fall"] == "computed"
    assert done.results() == before


@pytest.mark.parametrize("text", ["", "{", "[]", '{"seal": "x", "entry": {}}'])
def test_a_damaged_manifest_is_not_believed(done, text):
    before = done.results()
    (entry_folder(done, "fall") / "manifest.json").write_text(text)
    assert done.run()["fall"] == "current", "as the artefact tells of itself, and the manifest is made anew"
    (done.root / "results/fall.h5").unlink()
    assert done.run()["fall"] == "restored"
    (entry_folder(done, "fall") / "manifest.json").write_text(text)
    (done.root / "results/fall.h5").unlink()
    assert done.run()["fall"] == "computed"
    assert done.results() == before


def test_a_manifest_that_vouches_for_other_bytes_is_not_believed(done):
    path = entry_folder(done, "fall") / "manifest.json"
    manifest = json.loads(path.read_text())
    forged = b"not what the stage made"
    manifest["entry"]["outs"]["results/fall.h5"].update(sha256=disk.digest(forged), size=len(forged))
    path.write_text(json.dumps(manifest))
    (done.root / "results/fall.h5").write_bytes(forged)
    assert done.run()["fall"] == "computed"


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"key": "../../x", "complete": true}', '{"key": 3, "complete": true}']
)
def test_a_damaged_record_costs_nothing(done, text):
    before, record = done.results(), done.root / "results/.cache/current/fall.json"
    whole = record.read_bytes()
    record.write_text(text)
    done.kept_syntax().write_text(text)
    assert done.run()["fall"] == "current"
    assert done.results() == before and record.read_bytes() == whole


def test_a_record_cannot_make_the_pipeline_delete_other_files(done):
    record = done.root / "results/.cache/current/fall.json"
    stored = json.loads(record.read_text())
    stored["files"] += ["results/../dvc.yaml", "params/fall.yaml"]
    record.write_text(json.dumps({**stored, "complete": False}))
    assert done.run()["fall"] == "current"
    assert (done.root / "dvc.yaml").exists() and (done.root / "params/fall.yaml").exists()


def test_the_record_of_another_stage_removes_nothing(done):
    before = done.results()
    folder = done.root / "results/.cache/current"
    (folder / "picture.json").write_bytes((folder / "fall.json").read_bytes())
    assert done.run() == {"fall": "current", "bounce": "current", "side": "current", "picture": "current"}
    assert done.results() == before


@pytest.mark.parametrize("text", ["", '{"key": 3, "complete": true}'])
def test_a_figure_that_is_no_longer_made_disappears_also_when_the_record_is_damaged(done, text):
    before = done.results()
    done.run("picture.extra=true")
    (done.root / "results/figures/mine.svg").write_text("mine")
    (done.root / "results/.cache/current/picture.json").write_text(text)
    assert done.run()["picture"] == "restored"
    assert done.results() == {**before, "figures/mine.svg": b"mine"}


def test_the_clock_set_back_changes_nothing(done):
    for path in [*(done.root / "results").rglob("*"), *done.path("PACKAGE").rglob("*.py")]:
        os.utime(path, (0, 0))
    assert set(done.run().values()) == {"current"}
    done.edit("PACKAGE/body/motion.py", "0.5 * gravity", "0.8 * gravity")
    os.utime(done.path("PACKAGE/body/motion.py"), (0, 0))
    assert done.run()["fall"] == "computed"


def test_reading_a_foreign_or_truncated_file_is_one_sentence(done, tmp_path):
    from pipeline.cache import artefact

    content = (done.root / "results/fall.h5").read_bytes()
    for damaged in (b"", b"hello", content[:2000], content[:-1]):
        with pytest.raises(ArtefactError, match=r"x\.h5: (is empty|is truncated or not an HDF5 file)"):
            artefact.tree(damaged, "x.h5")
