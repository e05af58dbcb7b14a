"""`--accuracy`: settings from the kept table, what is refused, and that the true error keeps the request."""

import dataclasses
import statistics
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline import accuracy
from pipeline.errors import StudyError
from pipeline.study import Study
from pipeline.verification import walk_difference

ROOT = Path(__file__).resolve().parents[2]
ASKED = (1e-3, 1e-4, 1e-5, 5e-6, 1e-6, 1e-7, 1e-8)


def study(*settings, asked=""):
    return Study(ROOT, ROOT / "params", ROOT / "results", settings, accuracy=asked)


def choices(asked, *settings, stages=("analytic", "multibody", "twin")):
    found = study(*settings, asked=asked)
    return {choice.stage: choice for choice in found.choices(found.parameters(stages))}


def test_what_is_asked_sets_the_solver_and_is_stated():
    found = study(asked="hip_position_m=1e-6")
    values = found.parameters(("analytic", "multibody", "twin", "imu"))
    for choice in found.choices(values):
        for key, value in choice.settings.items():
            assert getattr(values[choice.stage].settings, key) == value
        assert found.asked(choice.stage, values[choice.stage]) == {"accuracy": {"hip_position_m": 1e-6}}
        assert choice.expected <= 1e-6
    assert len(found.choices(values)) == 3 and found.asked("imu", values["imu"]) == {}
    assert study().asked("twin", values["twin"]) == {}


@pytest.mark.parametrize("stage", ["analytic", "multibody", "twin"])
def test_cost_falls_with_the_error_asked_for(stage):
    rows, _ = accuracy._rows()
    costs = []
    for error in ASKED:
        chosen = choices(f"hip_position_m={error!r}", stages=(stage,))[stage].settings
        costs.append(min(row["evaluations"] for row in rows if row["way"] in WAYS[stage]
                         and row["tolerance"] == chosen["tolerance"]
                         and ("largest_step" not in chosen or row["largest_step"] == chosen["largest_step"])))
    assert costs == sorted(costs) and costs[-1] > 1.4 * costs[0]


WAYS = {"analytic": ("compiled",), "multibody": ("Exudyn tree, DOPRI5",), "twin": ("Exudyn tree in space, DOPRI5",)}


def test_words_longer_walks_and_other_ways():
    draft, paper, reference = (choices(word) for word in ("draft", "paper", "reference"))
    for stage in draft:
        assert draft[stage].settings["tolerance"] >= paper[stage].settings["tolerance"]
        assert paper[stage].settings["tolerance"] >= reference[stage].settings["tolerance"]
    longer = choices("hip_position_m=1e-6", "analytic.steps=1000")["analytic"]
    assert longer.settings["tolerance"] < choices("hip_position_m=1e-6")["analytic"].settings["tolerance"]
    joints = choices("hip_position_m=1e-5", "multibody.assembly=joints")["multibody"]
    assert set(joints.settings) == {"rolling_step", "impact_step"}


@pytest.mark.parametrize(("asked", "said"), [
    ("quick", "the form is draft, paper, reference"),
    ("hip_position=1e-5", 'did you mean "hip_position_m"'),
    ("hip_position_m=0", "allowed: > 0"),
    ("hip_position_m=nan", "allowed: > 0"),
    ("hip_position_m=1e-20", "the least measured is"),
    ("multiplier=1e-3", "its error was not measured"),
])  # fmt: skip
def test_what_cannot_be_had_is_refused_in_a_sentence(asked, said):
    with pytest.raises(StudyError) as refused:
        choices(asked)
    assert said in str(refused.value)


def test_a_setting_is_not_given_twice():
    with pytest.raises(StudyError, match=r"cannot be given by --set as well"):
        choices("draft", "twin.tolerance=1e-5")


def test_walks_are_compared_at_common_times():
    one = SimpleNamespace(time=np.arange(5) * 0.1, hip_position=np.zeros((5, 2)))
    other = SimpleNamespace(time=np.arange(4) * 0.2, hip_position=np.full((4, 2), 0.25))
    assert walk_difference(one, other) == 0.25


def true_errors(stage, tight, run):
    """True over asked error, for each error asked, against a run at `tight` settings."""
    values = study().parameters((stage,))[stage]

    def walk(settings):
        return run(dataclasses.replace(values, settings=dataclasses.replace(values.settings, **settings)))

    exact = walk(tight)
    chosen = [choices(f"hip_position_m={error!r}", stages=(stage,))[stage].settings for error in ASKED]
    return [walk_difference(walk(settings), exact) / error for settings, error in zip(chosen, ASKED)]


@pytest.mark.slow
@pytest.mark.parametrize("stage", ["analytic", "multibody", "twin"])
def test_the_true_error_of_the_stages_own_walk_keeps_the_request(stage):
    # imported here, because Exudyn takes seconds
    from stages.analytic.gait_search import find_gait
    from stages.analytic.recording import crossing_state, record
    from stages.analytic.sampling import sample_walk
    from stages.multibody.state import rolling_state
    from stages.multibody.walk import simulate
    from stages.twin.machine import build
    from stages.twin.simulate import rolling_start, simulate_twin

    given = study().parameters(("analytic",))["analytic"]
    walker, point = find_gait(given.biped, given.slope, 1e-13)
    upright = crossing_state(walker, point.z, 1e-13)
    stance = walker.stance_state(upright)

    def sampled(at):
        return lambda end: SimpleNamespace(time=(time := np.arange(0.0, end, 1e-3)), hip_position=at(time))

    def analytic(values):
        mine, gait = find_gait(values.biped, values.slope, values.settings.tolerance)
        start = crossing_state(mine, gait.z, values.settings.tolerance)
        segments = record(mine, start, values.settings.steps + 1, values.settings.tolerance, 1)
        return sample_walk(mine, segments, 1000.0)

    def multibody(values):
        state = rolling_state(values.biped, values.contact, stance, 9.4)
        done = simulate(values.biped, values.slope, values.contact, state, values.settings).trajectory
        return sampled(lambda time: done.at(time)[0][:, :2])(done.time[-1])

    def twin(values):
        machine = build(values.biped, values.settings)
        start = rolling_start(machine, values.contact, stance, 9.4)
        done = simulate_twin(machine, values.slope, values.contact, start, values.settings)
        return sampled(lambda time: done.at(time)[0][:, :2])(done.time[-1])

    tight = {"analytic": {"tolerance": 1e-13}, "multibody": {"tolerance": 1e-11, "largest_step": 1e-3},
             "twin": {"tolerance": 1e-10, "largest_step": 2e-3}}[stage]  # fmt: skip
    shares = true_errors(stage, tight, {"analytic": analytic, "multibody": multibody, "twin": twin}[stage])
    print(stage, [f"{share:.2g}" for share in shares])
    assert max(shares) <= 1.0
    assert 1.0 / statistics.median(shares) <= 30.0
