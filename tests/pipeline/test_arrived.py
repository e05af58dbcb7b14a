"""Results that came without their cache are taken where each artefact tells how it was made and what its files hold."""

from __future__ import annotations

import random
import shutil

import h5py
import pytest

from pipeline.execution.executor import Planner, State
from tests.pipeline.toy import Toy

CURRENT = {"fall": "current", "bounce": "current", "side": "current", "picture": "current"}


def arrive(toy: Toy) -> None:
    """Leave of the results folder what an upload without hidden folders leaves."""
    shutil.rmtree(toy.root / "results/.cache")
    (toy.root / "results/log.jsonl").unlink(missing_ok=True)


def states(toy: Toy) -> dict[str, State]:
    study = toy.study()
    names = tuple(study.graph.stages)
    return {item.name: item.state for item in Planner(study, study.parameters(names)).survey(names)}


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
    study = done.study("fall.height=3")
    values = study.parameters(("fall",))
    (fall,) = Planner(study, values).survey(("fall",))
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
