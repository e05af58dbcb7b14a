"""Files that were truncated, edited or forged are never taken for results, and cost no valid one."""

import json
import random
import shutil

import h5py
import pytest

from pipeline.cache import disk
from pipeline.execution.executor import CURRENT, STALE
from tests.pipeline.toy import Toy, flipped


@pytest.mark.parametrize("damage", [lambda content: content[:-100], lambda content: b"", lambda content: content + b"x",
                                    lambda content: content.replace(b"Result", b"result") + b"\0",
                                    lambda content: flipped(content, len(content) // 2)])
def test_a_damaged_artefact_is_seen_and_put_right(done, damage):
    before = done.results()
    path = done.root / "results/fall.h5"
    path.write_bytes(damage(path.read_bytes()))
    assert done.survey()["fall"].reasons == ("results/fall.h5 was edited or damaged",)
    assert done.run()["fall"] == "restored"
    assert done.results() == before


def test_a_damaged_store_is_computed_again_when_it_is_needed(done):
    before = done.results()
    stored = done.entry("fall") / "results/fall.h5"
    stored.write_bytes(stored.read_bytes()[:-10])
    assert set(done.run().values()) == {"current"}  # the good copy in the results folder is untouched
    (done.root / "results/fall.h5").unlink()
    assert done.run()["fall"] == "computed"
    assert done.results() == before


@pytest.mark.parametrize("text", ["", "{", "[]", '{"seal": "x", "entry": {}}'])
def test_a_damaged_manifest_is_not_believed(done, text):
    before = done.results()
    (done.entry("fall") / "manifest.json").write_text(text)
    assert done.run()["fall"] == "current", "as the artefact tells of itself, and the manifest is made anew"
    (done.root / "results/fall.h5").unlink()
    assert done.run()["fall"] == "restored"
    (done.entry("fall") / "manifest.json").write_text(text)
    (done.root / "results/fall.h5").unlink()
    assert done.run()["fall"] == "computed"
    assert done.results() == before


def test_a_manifest_that_vouches_for_other_bytes_is_not_believed(done):
    path = done.entry("fall") / "manifest.json"
    manifest = json.loads(path.read_text())
    forged = b"not what the stage made"
    manifest["entry"]["outs"]["results/fall.h5"].update(sha256=disk.digest(forged), size=len(forged))
    path.write_text(json.dumps(manifest))
    (done.root / "results/fall.h5").write_bytes(forged)
    assert done.run()["fall"] == "computed"


@pytest.mark.parametrize("text", ["", "{", "[]", '{"key": "../../x", "complete": true}',
                                  '{"key": 3, "complete": true}', '{"seal": ' + "9" * 10_000 + "}",
                                  "[" * 100_000, "that of another stage"], ids=range(8))  # fmt: skip
def test_a_damaged_record_costs_nothing(done, text):
    before, record = done.results(), done.record("fall")
    whole, another = record.read_bytes(), record.with_name("picture.json").read_text()
    text = another if text.startswith("that of") else text
    record.write_text(text)
    done.kept_syntax().write_text(text)
    assert done.run()["fall"] == "current"
    assert done.results() == before and record.read_bytes() == whole


def test_the_record_or_manifest_of_another_result_is_not_believed(done):
    """The one edited, the other copied into its place."""
    done.run("fall.height=3", names=("fall",))
    other = done.entry("fall")
    done.run()
    own, record = done.entry("fall"), done.record("fall")
    right = record.read_text()
    record.write_text(right.replace(own.name, other.name))
    assert done.survey()["fall"].state == CURRENT, "as its artefact tells of itself"
    record.write_text(right)
    shutil.copy(other / "manifest.json", own)
    assert done.survey()["fall"].state == CURRENT


def test_every_flip_of_the_kept_syntax_is_seen(done):
    path = done.kept_syntax()
    content = path.read_bytes()
    assert disk.read_sealed(path)
    for at in range(0, len(content), len(content) // 200):
        path.write_bytes(flipped(content, at))
        assert disk.read_sealed(path) is None, at


@pytest.mark.parametrize("text", [None, "", '{"key": 3, "complete": true}'])
def test_a_figure_that_is_no_longer_made_disappears_and_a_users_own_stays_whatever_the_record_says(done, text):
    before, record = done.results(), done.record("picture")
    (done.root / "results/figures/mine.svg").write_text("mine")
    done.run("picture.extra=true")
    assert "figures/two.svg" in done.results()
    record.write_text(record.read_text() if text is None else text)
    assert done.run()["picture"] == "restored"
    assert done.results() == {**before, "figures/mine.svg": b"mine"}


def test_a_figure_left_by_a_run_that_was_killed_while_it_put_files_in_place_goes(done):
    done.run("picture.extra=true")
    two = done.results()["figures/two.svg"]
    done.run()
    before, store = done.results(), done.study().store
    entry = store.current("picture")
    (done.root / "results/figures/two.svg").write_bytes(two)
    store._set_record(entry, False, sorted([*entry.outs, "results/figures/two.svg"]))
    assert done.run()["picture"] == "restored"
    assert done.results() == before


# --- Results that came without their cache are taken where each artefact tells how it was made and what its files
# hold.


def arrive(toy: Toy) -> None:
    """Leave of the results folder what an upload without hidden folders leaves."""
    shutil.rmtree(toy.root / "results/.cache")
    (toy.root / "results/log.jsonl").unlink(missing_ok=True)


def states(toy: Toy) -> dict[str, str]:
    return {name: item.state for name, item in toy.survey().items()}


def manifests(toy: Toy) -> dict[str, object]:
    store = toy.study().store
    found = {path.parent.name: store.entry(path.parent.name) for path in store.folder.glob("*/manifest.json")}
    assert all(found.values())
    return {key: (entry.ingredients, entry.outs, entry.summary) for key, entry in found.items()}


def test_results_without_their_cache_are_current_and_enter_it_as_if_computed(done):
    before, kept = done.results(), manifests(done)
    arrive(done)
    assert set(states(done).values()) == {CURRENT} and not (done.root / "results/.cache").exists()
    assert set(done.run().values()) == {CURRENT} and done.results() == before and manifests(done) == kept
    assert done.run("ground.gravity=5")["fall"] == "computed"
    assert set(done.run().values()) == {"restored", "current"} and done.results() == before


def test_results_that_replaced_others_beside_their_cache_are_current(done):
    before = done.results()
    done.run("ground.gravity=5")
    shutil.rmtree(next(path for path in (done.root / "results/.cache").glob("*/results/fall.h5")
                       if path.read_bytes() == before["fall.h5"]).parents[1])  # fmt: skip
    (done.root / "results/fall.h5").write_bytes(before["fall.h5"])
    assert states(done)["fall"] == CURRENT and done.run(names=("fall",)) == {"fall": "current"}


def test_what_arrived_for_other_parameters_says_what_changed(done):
    arrive(done)
    done.edit("params/fall.yaml", "{value: 2.0,", "{value: 3,")
    fall = done.survey()["fall"]
    assert fall.state == STALE and fall.reasons == ("fall.yaml: height 2 -> 3",)


def test_results_that_can_only_be_read_are_current_without_a_cache(ran):
    arrive(ran)
    full = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0)); "
    pytest.importorskip("resource")
    code, out, errors = ran.command("run", "picture", before=full)
    assert (code, errors) == (0, "") and out.count("current") == 4


def test_of_forged_results_none_is_taken(done):
    """Another number, the key that is wanted on a result of other parameters, bits, and what lies beside."""
    path, chance = done.root / "results/fall.h5", random.Random(5)
    done.run("fall.height=3", names=("fall",))
    other = path.read_bytes()
    done.run()
    before = done.results()
    forged = [("side.bin", "side", b""), ("claims.yaml", "picture", before["claims.yaml"] + b"1"),
              ("figures/one.svg", "picture", None)]  # fmt: skip
    with h5py.File(path) as file:
        key = file["provenance"].attrs["key"]
    for content, place, name, value in ((before["fall.h5"], "/", "height", 3.0), (other, "provenance", "key", key)):
        path.write_bytes(content)
        with h5py.File(path, "r+") as file:
            if place == "/":
                file[name][...] = value
            else:
                assert file[place].attrs[name] != value
                file[place].attrs[name] = value
        forged.append(("fall.h5", "fall", path.read_bytes()))
    forged += [(name, name[:-3], flipped(before[name], chance.randrange(len(before[name]))))
               for name in ("bounce.h5", "picture.h5")]
    path.write_bytes(before["fall.h5"])
    arrive(done)
    for name, stage, content in forged:
        place = done.root / "results" / name
        place.unlink() if content is None else place.write_bytes(content)
        assert states(done)[stage] == STALE, name
        place.write_bytes(before[name])
    (done.root / "results/side.bin").write_bytes(b"")
    assert done.run()["side"] == "computed" and done.results() == before
