"""`status` says why a stage is stale."""

from __future__ import annotations

from pipeline.execution.executor import Planner, State


def survey(toy, *settings):
    study = toy.study(*settings)
    names = tuple(study.graph.stages)
    found = Planner(study, study.parameters(names)).survey(names)
    return {item.name: (item.state, item.reasons) for item in found}


def test_never_run(toy):
    found = survey(toy)
    assert found["fall"] == (State.STALE, ("never run",))
    assert found["bounce"] == (State.WAITING, ("input fall will be computed first",))


def test_nothing_to_say_after_a_run(done):
    assert set(survey(done).values()) == {(State.CURRENT, ())}


def test_a_changed_parameter(done):
    done.edit("params/ground.yaml", "value: 1e5", "value: 2e5")
    found = survey(done)
    assert found["fall"] == (State.CURRENT, ())
    assert found["bounce"] == (State.STALE, ("ground.yaml: contact_stiffness 1e5 -> 2e5",))
    assert found["picture"] == (State.WAITING, ("input bounce will be computed first",))


def test_a_changed_input(done):
    done.run("ground.contact_stiffness=2e5", names=("bounce",))
    assert survey(done, "ground.contact_stiffness=2e5")["picture"] == (State.STALE, ("input bounce changed",))


def test_changed_code(done):
    done.edit("PACKAGE/body/motion.py", "0.5 * gravity", "0.4 * gravity")
    assert survey(done)["fall"] == (State.STALE, (f"{done.package}/body/motion.py changed",))


def test_what_the_cache_still_has(done):
    done.run("fall.height=3", names=("fall",))
    assert survey(done)["fall"] == (State.RESTORABLE, ("fall.yaml: height 3 -> 2",))


def test_missing_and_edited_files(done):
    (done.root / "results/bounce.h5").unlink()
    (done.root / "results/fall.h5").write_bytes(b"")
    found = survey(done)
    assert found["bounce"] == (State.RESTORABLE, ("results/bounce.h5 is missing",))
    assert found["fall"] == (State.RESTORABLE, ("results/fall.h5 was edited or damaged",))


def test_results_of_unknown_origin(toy):
    (toy.root / "results").mkdir()
    (toy.root / "results/fall.h5").write_bytes(b"from elsewhere")
    assert survey(toy)["fall"] == (State.STALE, ("results/fall.h5 is there, but nothing says how it was made",))
