"""An accuracy asked for: settings from the kept table, what is refused, that the true error keeps the request."""

import dataclasses
import shutil
import statistics
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from pipeline import requests
from pipeline.cache import provenance
from pipeline.cache.fingerprint import compact
from pipeline.errors import StudyError
from pipeline.parameters import loading
from pipeline.study import Study
from stages.biped.accuracy import CUSTOM, Accuracy
from stages.tradeoff import request
from stages.tradeoff.accuracy import choice, second_run

ROOT = Path(__file__).resolve().parents[2]
ASKED = (1e-3, 1e-4, 1e-5, 5e-6, 1e-6, 1e-7, 1e-8)


def study(*settings, asked=""):
    return Study(ROOT, ROOT / "params", ROOT / "results", settings, asked=(("accuracy", asked),))


def choices(asked, *settings, stages=choice.FILES):
    found = study(*settings, asked=asked)
    return decided(found, found.parameters(stages))


def decided(found, values):
    return {stage: decision for _, stage, decision, _ in requests.decisions(found, values)}


def with_key(folder, line, *settings, stage="twin"):
    """Parameters of a stage whose own file says `line` for its accuracy, and the number of that line."""
    shutil.copytree(ROOT / "params", folder, dirs_exist_ok=True)
    path = folder / f"{stage}.yaml"
    lines = path.read_text().splitlines()
    number = next(n for n, text in enumerate(lines) if text.startswith("accuracy"))
    lines[number] = line
    path.write_text("\n".join(lines))
    found = Study(ROOT, folder, ROOT / "results", settings)
    try:
        return found, found.parameters((stage,))[stage], number + 1
    except StudyError as error:
        return str(error), None, number + 1


def test_what_is_asked_sets_the_solver_and_is_stated():
    """Solver settings and request are among the parameters, from which the key and the artefact's account follow."""
    found = study(asked="hip_position_m=1e-6")
    values = found.parameters(("analytic", "multibody", "twin", "imu"))
    chosen = decided(found, values)
    assert set(chosen) == set(choice.FILES)
    for name, decision in chosen.items():
        plain = loading.as_plain(values[name])[name]
        assert {key: plain[key] for key in decision.settings} == decision.settings and decision.settings
        assert plain["accuracy"]["hip_position_m"] == 1e-6
        assert decision.expected <= 1e-6
        used = ", ".join(f"{key} {compact(value)}" for key, value in decision.settings.items())
        said = provenance._asked({"stage": name, "parameters": {name: plain}}, request)
        assert said == f"asked: {{hip_position_m: 1e-6}}; used: {used}"
    as_it_stands = study().parameters(("twin",))
    assert decided(study(), as_it_stands) == {} and as_it_stands["twin"].settings.accuracy == CUSTOM
    plain = loading.as_plain(as_it_stands["twin"])
    assert provenance._asked({"stage": "twin", "parameters": plain}, request) == ""


def test_what_can_be_asked_is_what_the_parameters_have():
    assert set(choice.KEYS) == set(vars(Accuracy()))


@pytest.mark.parametrize("line", [
    "accuracy: draft",
    'accuracy: {value: draft, unit: "-", source: "a test"}',
    "accuracy: {hip_position_m: 1e-3}",
    "accuracy: {value: {hip_position_m: 1e-3}, source: a test}",
])  # fmt: skip
def test_the_key_of_a_file_asks_as_the_option_does(tmp_path, line):
    found, values, _ = with_key(tmp_path, line)
    assert decided(found, {"twin": values}) == choices("draft", stages=("twin",))
    assert values.settings.tolerance == choices("draft")["twin"].settings["tolerance"]


def test_the_option_goes_before_the_key_and_set_before_both(tmp_path):
    found, _, _ = with_key(tmp_path, "accuracy: draft")
    asked = dataclasses.replace(found, asked=(("accuracy", "reference"),))
    assert asked.parameters(("twin",))["twin"].settings.accuracy == "reference"
    mine = dataclasses.replace(asked, settings=("twin.accuracy=custom", "twin.tolerance=3e-6"))
    assert mine.parameters(("twin",))["twin"].settings.tolerance == 3e-6
    assert mine.parameters(("analytic",))["analytic"].settings.accuracy == "reference"


@pytest.mark.parametrize(("line", "said"), [
    ("accuracy: drft", 'accuracy = "drft" is not allowed; allowed: custom, draft, paper, reference, or errors by '
                       'hip_position_m, period_s, multiplier, peak_force_n as {hip_position_m: 1e-5}; did you mean'),
    ("accuracy: 1e-5", "accuracy = 1e-05 is not a word; allowed: custom, draft, paper, reference, or errors by"),
    ("accuracy: {hip_position_m: -1}", "accuracy: hip_position_m = -1 m is not allowed; allowed: > 0 m"),
    ("accuracy: {hip_position: 1e-5}", 'accuracy has an unknown column "hip_position"; did you mean "hip_position_m"?'),
    ("accuracy: {}", "at least one of hip_position_m, period_s, multiplier, peak_force_n"),
    ("accuracy: {hip_position_m: 1e-20}", "stage twin cannot have hip_position_m <= 1e-20; allowed: >= "),
    ("accuracy: {multiplier: 1e-3}", "stage twin cannot have multiplier <= 0.001; its error was not measured"),
])  # fmt: skip
def test_a_wrong_key_is_told_with_file_line_value_and_what_is_allowed(tmp_path, line, said):
    told, _, number = with_key(tmp_path, line)
    assert f"twin.yaml:{number}: accuracy" in told and said in told and "\n" not in told


@pytest.mark.parametrize("stage", ["analytic", "multibody", "twin"])
def test_cost_falls_with_the_error_asked_for(stage):
    rows, _ = choice._rows()
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
    ("quick", "the form is custom, draft, paper, reference"),
    ("hip_position=1e-5", 'did you mean "hip_position_m"'),
    ("hip_position_m=0", "allowed: > 0"),
    ("hip_position_m=nan", "allowed: > 0"),
    ("hip_position_m=1e-20", "stage analytic cannot have hip_position_m <= 1e-20; allowed: >= "),
    ("multiplier=1e-3", "its error was not measured"),
])  # fmt: skip
def test_what_cannot_be_had_is_refused_in_a_sentence(asked, said):
    with pytest.raises(StudyError) as refused:
        choices(asked)
    assert said in str(refused.value)


def test_a_setting_is_not_given_twice():
    with pytest.raises(StudyError, match=r"--set twin\.tolerance=1e-5 is not allowed: twin\.accuracy decides it"):
        choices("draft", "twin.tolerance=1e-5")
    with pytest.raises(StudyError, match=r"twin\.accuracy decides it"):
        choices("", "twin.tolerance=1e-5", "twin.accuracy=draft")


def test_walks_are_compared_at_common_times():
    one = SimpleNamespace(time=np.arange(5) * 0.1, hip_position=np.zeros((5, 2)))
    other = SimpleNamespace(time=np.arange(4) * 0.2, hip_position=np.full((4, 2), 0.25))
    assert second_run.walk_difference(one, other) == 0.25


def test_the_second_run_takes_half_the_budget_or_the_next_finer_setting():
    """Half the budget where that is measured; an error that goes with the tolerance to the power 1 is told exactly."""
    tight, loose = (choices(f"hip_position_m={error}")["multibody"] for error in (1e-8, 1e-3))
    assert tight.second.budget <= 0.5 and tight.second.settings["tolerance"] > tight.settings["tolerance"]
    assert loose.second.budget > 1.0 and loose.second.settings["tolerance"] < loose.settings["tolerance"]
    for found in (tight, loose):
        assert found.second.settings["largest_step"] == found.settings["largest_step"]
        assert 0.7 < found.second.order < 1.3  # adaptive steps: errors go about as the tolerance
    for ratio in (100.0, 0.1):
        assert choice.Second({}, 0.5, 1.0, ratio).estimate(abs(ratio - 1.0) * 2e-7) == pytest.approx(2e-7)


class Made:
    """A twin's artefact and a second run of it, whose walk differs by 8.1e-6 m at a hundred times the error."""

    key = "k1"
    result = SimpleNamespace(walk=SimpleNamespace(time=np.arange(3.0), hip_position=np.zeros((3, 2))))

    def __init__(self, *_):
        self.ran = []

    def run(self, parameters):
        self.ran.append(parameters)
        return SimpleNamespace(walk=SimpleNamespace(time=np.arange(3.0), hip_position=np.full((3, 2), 8.1e-6)))


class Falls(Made):
    def run(self, parameters):
        raise ValueError("it fell")


@pytest.fixture
def verifiable(tmp_path):
    return Study(ROOT, ROOT / "params", tmp_path, (), asked=(("accuracy", "hip_position_m=1e-8"),))


def verify(found, made, monkeypatch, told):
    monkeypatch.setattr("pipeline.execution.direct.Direct", made)
    chosen = requests.to_verify(found, ("twin",))
    requests.verify(found, chosen, told=told)
    return chosen[0][2], yaml.safe_load(requests.record_of(found, request, "twin").read_text())


def test_an_estimate_is_kept_beside_the_artefact_it_belongs_to(verifiable, monkeypatch, capsys):
    decision, kept = verify(verifiable, Made, monkeypatch, told=True)
    assert kept["hip_error_estimate_m"] == pytest.approx(decision.second.estimate(8.1e-6), rel=0.05)
    assert kept["hip_difference_m"] == 8.1e-6 and kept["asked"] == {"hip_position_m": 1e-8}
    assert kept["settings"] == decision.settings and 0 < kept["second_run"]["budget"] <= 0.5
    said = f"estimated {kept['hip_error_estimate_m']:.1e} m"
    about = {"stage": "twin", "key": "k1", "accuracy": "asked: {hip_position_m: 1e-8}; used: tolerance 1e-9"}
    assert said in "".join(requests.kept(verifiable, about)) and said in capsys.readouterr().out
    assert list(requests.kept(verifiable, {**about, "key": "of another run"})) == [f"accuracy {about['accuracy']}"]


def test_a_second_run_that_fails_is_a_reason_and_not_an_estimate(verifiable, monkeypatch):
    _, kept = verify(verifiable, Falls, monkeypatch, told=False)
    assert kept["hip_error_estimate_m"] is None and "it fell" in kept["reason"]
    assert "not estimated" in request.line(kept)


def test_the_second_run_has_the_second_setting(verifiable, monkeypatch):
    seen = []

    class Watched(Made):
        def run(self, parameters):
            seen.append(parameters)
            return super().run(parameters)

    decision, _ = verify(verifiable, Watched, monkeypatch, told=False)
    assert {key: getattr(seen[0].settings, key) for key in decision.second.settings} == decision.second.settings


def test_nothing_asked_is_nothing_to_verify():
    with pytest.raises(StudyError, match=r"none is asked of twin, imu; give --accuracy"):
        requests.to_verify(study(), ("twin", "imu"))


def true_errors(stage, tight, run):
    """True over asked and estimated over true error, for each error asked, against a run at `tight` settings."""
    values = study().parameters((stage,))[stage]

    def walk(settings):
        return run(dataclasses.replace(values, settings=dataclasses.replace(values.settings, **settings)))

    exact = walk(tight)
    shares, estimates, walks = [], [], {}
    for error in ASKED:
        decision = choices(f"hip_position_m={error!r}", stages=(stage,))[stage]
        both = [decision.settings, decision.second.settings]
        for settings in both:
            if repr(settings) not in walks:
                walks[repr(settings)] = walk(settings)
        one, other = (walks[repr(settings)] for settings in both)
        true = second_run.walk_difference(one, exact)
        shares.append(true / error)
        estimates.append(decision.second.estimate(second_run.walk_difference(one, other)) / true)
    return shares, estimates


@pytest.mark.slow
@pytest.mark.parametrize("stage", ["analytic", "multibody", "twin"])
def test_the_true_error_of_the_stages_own_walk_keeps_the_request(stage):
    # imported here, because Exudyn takes seconds
    from stages.analytic.gait.gait_search import find_gait
    from stages.analytic.walk.recording import crossing_state, record
    from stages.analytic.walk.sampling import sample_walk
    from stages.multibody.assembly.state import rolling_state
    from stages.multibody.walking.walk import simulate
    from stages.twin.machine.machine import build
    from stages.twin.walking.simulate import rolling_start, simulate_twin

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
    shares, estimates = true_errors(stage, tight, {"analytic": analytic, "multibody": multibody, "twin": twin}[stage])
    print(stage, *([f"{number:.2g}" for number in numbers] for numbers in (shares, estimates)))
    assert max(shares) <= 1.0
    assert 1.0 / statistics.median(shares) <= 30.0
    assert 0.2 < statistics.median(estimates) < 5.0 and max(estimates) < 30.0 and min(estimates) > 1.0 / 30.0
