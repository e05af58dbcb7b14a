"""Files that were truncated, edited or forged are never taken for results, and cost no valid one."""

import json
import os
import random
import shutil

import h5py
import pytest

from pipeline.cache import disk
from pipeline.errors import ArtefactError
from pipeline.execution.executor import Planner, State
from tests.pipeline.toy import Toy


def survey(toy):
    """What `status` finds of each stage."""
    study = toy.study()
    names = tuple(study.graph.stages)
    return {item.name: item for item in Planner(study, study.parameters(names)).survey(names)}


def entry_folder(toy, stage):
    record = json.loads((toy.root / f"results/.cache/current/{stage}.json").read_text())
    return toy.root / "results/.cache" / record["key"]


def flipped(content):
    """One bit is another in the middle of it."""
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


@pytest.mark.parametrize("damage", [lambda content: content[:-100], lambda content: b"", lambda content: content + b"x",
                                    lambda content: content.replace(b"Result", b"result") + b"\0", flipped])
def test_a_damaged_artefact_is_seen_and_put_right(done, damage):
    before = done.results()
    path = done.root / "results/fall.h5"
    path.write_bytes(damage(path.read_bytes()))
    assert survey(done)["fall"].reasons == ("results/fall.h5 was edited or damaged",)
    assert done.run()["fall"] == "restored"
    assert done.results() == before


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


# --- Results that came without their cache are taken where each artefact tells how it was made and what its files
# hold.


CURRENT = {"fall": "current", "bounce": "current", "side": "current", "picture": "current"}


def arrive(toy: Toy) -> None:
    """Leave of the results folder what an upload without hidden folders leaves."""
    shutil.rmtree(toy.root / "results/.cache")
    (toy.root / "results/log.jsonl").unlink(missing_ok=True)


def states(toy: Toy) -> dict[str, State]:
    return {name: item.state for name, item in survey(toy).items()}


def manifests(toy: Toy) -> dict[str, object]:
    store = toy.study().store
    found = {path.parent.name: store.entry(path.parent.name) for path in store.folder.glob("*/manifest.json")}
    assert all(found.values())
    return {key: (entry.ingredients, entry.outs, entry.summary) for key, entry in found.items()}


def test_results_without_their_cache_are_current_and_enter_it_as_if_computed(done):
    before, kept = done.results(), manifests(done)
    arrive(done)
    assert set(states(done).values()) == {State.CURRENT} and not (done.root / "results/.cache").exists()
    assert done.run() == CURRENT and done.results() == before and manifests(done) == kept
    assert done.run("ground.gravity=5")["fall"] == "computed"
    assert set(done.run().values()) == {"restored", "current"} and done.results() == before


def test_results_that_replaced_others_beside_their_cache_are_current(done):
    before = done.results()
    done.run("ground.gravity=5")
    shutil.rmtree(next(path for path in (done.root / "results/.cache").glob("*/results/fall.h5")
                       if path.read_bytes() == before["fall.h5"]).parents[1])  # fmt: skip
    (done.root / "results/fall.h5").write_bytes(before["fall.h5"])
    assert states(done)["fall"] is State.CURRENT and done.run(names=("fall",)) == {"fall": "current"}


def test_what_arrived_for_other_parameters_says_what_changed(done):
    arrive(done)
    done.edit("params/fall.yaml", "{value: 2.0,", "{value: 3,")
    fall = survey(done)["fall"]
    assert fall.state is State.STALE and fall.reasons == ("fall.yaml: height 2 -> 3",)


def test_results_that_can_only_be_read_are_current_without_a_cache(ran):
    arrive(ran)
    full = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0)); "
    pytest.importorskip("resource")
    code, out, errors = ran.command("run", "picture", before=full)
    assert (code, errors) == (0, "") and out.count("current") == 4


def _number(chance, toy, other):
    path = toy.root / f"results/{chance.choice(list(CURRENT))}.h5"
    with h5py.File(path, "r+") as file:
        found: list[str] = []
        file.visititems(lambda name, item: found.append(name) if getattr(item, "size", None) else None)
        item = file[chance.choice([name for name in found if file[name].dtype.kind in "fi"] or found)]
        item[...] = item[...] * 1.01 + 1 if item.dtype.kind in "fi" else "another"
    return path.stem


def _attribute(chance, toy, other):
    path = toy.root / f"results/{chance.choice(list(CURRENT))}.h5"
    with h5py.File(path, "r+") as file:
        said = file["provenance"].attrs
        name = chance.choice([name for name in said if said[name]])
        at = chance.randrange(len(said[name]))
        said[name] = said[name][:at] + ("0" if said[name][at] != "0" else "1") + said[name][at + 1 :]
    return path.stem


def _key(chance, toy, other):
    """The key that is wanted, on a result of other parameters."""
    with h5py.File(toy.root / "results/fall.h5") as file:
        key = file["provenance"].attrs["key"]
    (toy.root / "results/fall.h5").write_bytes(other)
    with h5py.File(toy.root / "results/fall.h5", "r+") as file:
        assert file["provenance"].attrs["key"] != key
        file["provenance"].attrs["key"] = key
    return "fall"


def _beside(chance, toy, other):
    name, stage = chance.choice((("side.bin", "side"), ("figures/one.svg", "picture"), ("claims.yaml", "picture")))
    path = toy.root / "results" / name
    path.write_bytes(path.read_bytes()[:-1] if chance.random() < 0.5 else path.read_bytes() + b"1")
    return stage


def _bit(chance, toy, other):
    path = toy.root / f"results/{chance.choice(list(CURRENT))}.h5"
    content = bytearray(path.read_bytes())
    content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    path.write_bytes(content)
    return path.stem


def _gone(chance, toy, other):
    name, stage = chance.choice((("side.bin", "side"), ("figures/one.svg", "picture"), ("claims.yaml", "picture")))
    (toy.root / "results" / name).unlink()
    return stage


FORGERIES = (_number, _attribute, _key, _beside, _bit, _gone)


def test_of_a_hundred_forged_results_none_is_taken(done):
    done.run("fall.height=3", names=("fall",))
    other = (done.root / "results/fall.h5").read_bytes()
    done.run()
    before, chance = done.results(), random.Random(5)
    arrive(done)
    for number in range(100):
        stage = FORGERIES[number % len(FORGERIES)](chance, done, other)
        found = states(done)
        assert found[stage] is State.STALE, (number, stage)
        if number in (0, 3):
            assert done.run()[stage] == "computed" and done.results() == before
            arrive(done)
        for name, content in before.items():
            (done.root / "results" / name).write_bytes(content)
    assert done.run() == CURRENT
