"""An accuracy asked for: settings the kept table proposes, what is refused, how a run checks and refines them."""

import dataclasses
import shutil
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from pipeline import requests
from pipeline.cache import artefact, fingerprint
from pipeline.cache.fingerprint import compact
from pipeline.errors import StudyError
from pipeline.parameters import loading
from pipeline.study import Study
from stages.biped.accuracy import estimate as error_estimate
from stages.biped.accuracy.estimate import ErrorEstimate, NotMet, to_accuracy
from stages.biped.accuracy.tolerances import CUSTOM, LEVELS, Accuracy
from stages.tradeoff import request
from stages.tradeoff.accuracy import choice

ROOT = Path(__file__).resolve().parents[2]
ASKED = (1e-3, 1e-4, 1e-5, 5e-6, 1e-6, 1e-7, 1e-8)


def study(*settings, asked=""):
    return Study(ROOT, ROOT / "params", ROOT / "results", settings, asked=(("accuracy", asked),))


@cache
def choices(asked, *settings, stages=choice.FILES):
    found = study(*settings, asked=asked)
    return decided(found, found.parameters(stages))


def decided(found, values):
    return {stage: decision for _, stage, decision in requests.decisions(found, values)}


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
        assert plain["accuracy"]["hip_position_m"] == 1e-6 and decision.expected <= 1e-6
        used = ", ".join(f"{key} {compact(value)}" for key, value in decision.settings.items())
        assert said_of(name, {name: plain}) == f"asked: {{hip_position_m: 1e-6}}; used: {used}"
    as_it_stands = study().parameters(("twin",))
    assert decided(study(), as_it_stands) == {} and as_it_stands["twin"].settings.accuracy == CUSTOM
    assert said_of("twin", loading.as_plain(as_it_stands["twin"])) == ""


def said_of(stage, parameters):
    """What an artefact's account says of the request."""
    return fingerprint._asked({"stage": stage, "parameters": parameters}, request)


def test_what_can_be_asked_is_what_the_parameters_have():
    assert set(choice.KEYS) == set(vars(Accuracy()))


@pytest.mark.parametrize("line", [
    "accuracy: {hip_position_m: 1e-3}",
    "accuracy: {value: {hip_position_m: 1e-3}, source: a test}",
])  # fmt: skip
def test_the_key_of_a_file_asks_as_the_option_does(tmp_path, line):
    found, values, _ = with_key(tmp_path, line)
    assert decided(found, {"twin": values}) == choices("hip_position_m=1e-3", stages=("twin",))
    assert values.settings.tolerance == choices("hip_position_m=1e-3")["twin"].settings["tolerance"]


def test_the_option_goes_before_the_key_and_set_before_both(tmp_path):
    found, _, _ = with_key(tmp_path, "accuracy: {hip_position_m: 1e-3}")
    asked = dataclasses.replace(found, asked=(("accuracy", "hip_position_m=1e-7"),))
    assert asked.parameters(("twin",))["twin"].settings.accuracy.hip_position_m == 1e-7
    mine = dataclasses.replace(asked, settings=("twin.accuracy=custom", "twin.tolerance=3e-6"))
    assert mine.parameters(("twin",))["twin"].settings.tolerance == 3e-6
    assert mine.parameters(("analytic",))["analytic"].settings.accuracy.hip_position_m == 1e-7


@pytest.mark.parametrize("level", LEVELS)
def test_a_word_is_the_level_of_the_whole_study_and_what_is_set_by_hand_wins(tmp_path, level):
    stages = ("analytic", "multibody", "twin", "campaign", "twin_ladder", "comparison")
    values = study(asked=level).parameters(stages)
    assert {one.level.level for one in values.values()} == {level}
    assert all(values[name].settings.accuracy == CUSTOM for name in choice.FILES)
    mine = study("twin.tolerance=3e-6", asked=level).parameters(stages)
    assert {mine["twin"].settings.tolerance, mine["campaign"].twin.tolerance} == {3e-6}
    assert mine["multibody"].settings.tolerance == values["multibody"].settings.tolerance
    assert study("accuracy.level=draft", asked=level).parameters(("twin",))["twin"].level.level == "draft"
    _, by_hand, _ = with_key(tmp_path, "accuracy: custom", f"accuracy.level={level}")
    path = tmp_path / "twin.yaml"
    path.write_text(path.read_text().replace("tolerance:        {value: 1e-6,", "tolerance:        {value: 4e-6,"))
    edited = Study(ROOT, tmp_path, ROOT / "results", (f"accuracy.level={level}",)).parameters(("twin",))["twin"]
    assert edited.settings.tolerance == 4e-6 and by_hand.settings.tolerance == values["twin"].settings.tolerance


def test_tolerances_tighten_and_runs_grow_from_level_to_level():
    levels = [study(asked=level).parameters(("multibody", "twin", "campaign")) for level in LEVELS]
    tolerances = [(values["multibody"].settings.tolerance, values["twin"].settings.tolerance,
                   values["campaign"].twin.with_tolerance(None).tolerance) for values in levels]  # fmt: skip
    assert all(draft > paper > reference for draft, paper, reference in zip(*tolerances))
    draft, paper, reference = (values["campaign"].runs.runs for values in levels)
    assert draft < paper == reference


def test_an_error_brings_the_least_accurate_level_that_has_it():
    errors = choice.LEVEL_ERRORS
    assert list(errors) == list(LEVELS)
    for key in choice.KEYS:
        assert errors["draft"][key] >= errors["paper"][key] >= errors["reference"][key] > 0
        for level in LEVELS:
            assert errors[choice.level({key: errors[level][key]})][key] <= errors[level][key]
    assert errors["draft"]["hip_position_m"] > 5 * errors["paper"]["hip_position_m"]
    assert choice.level({"hip_position_m": 1e-30}) == "reference"
    assert study(asked="hip_position_m=1e-3").parameters(("campaign",))["campaign"].level.level == "draft"


@pytest.mark.parametrize(("line", "said"), [
    ("accuracy: custm", 'accuracy = "custm" is not allowed; allowed: custom, or errors by '
                       'hip_position_m, period_s, multiplier, peak_force_n as {hip_position_m: 1e-5}; did you mean'),
    ("accuracy: 1e-5", "accuracy = 1e-05 is not a word; allowed: custom, or errors by"),
    ("accuracy: {hip_position_m: -1}", "accuracy: hip_position_m = -1 m is not allowed; allowed: > 0 m"),
    ("accuracy: {hip_position: 1e-5}", 'accuracy has an unknown column "hip_position"; did you mean "hip_position_m"?'),
    ("accuracy: {}", "at least one of hip_position_m, period_s, multiplier, peak_force_n"),
    ("accuracy: {hip_position_m: 1e-20}", "stage twin cannot have hip_position_m <= 1e-20; allowed: >= "),
    ("accuracy: {multiplier: 1e-3}", "stage twin cannot have multiplier <= 0.001; its error was not measured"),
])  # fmt: skip
def test_a_wrong_key_is_told_with_file_line_value_and_what_is_allowed(tmp_path, line, said):
    told, _, number = with_key(tmp_path, line)
    assert f"twin.yaml:{number}: accuracy" in told and said in told and "\n" not in told


@pytest.mark.parametrize(("stage", "way"), [
    ("multibody", "Exudyn tree, DOPRI5"), ("twin", "Exudyn tree in space, DOPRI5")])
def test_cost_falls_with_the_error_asked_for(stage, way):
    rows, _ = choice._rows()
    costs = []
    for error in ASKED:
        chosen = choices(f"hip_position_m={error!r}")[stage].settings
        costs.append(min(row["evaluations"] for row in rows if row["way"] == way
                         and all(row[key] == chosen[key] for key in ("tolerance", "largest_step") if key in chosen)))
    assert costs == sorted(costs) and costs[-1] > 1.4 * costs[0]


def test_longer_walks_and_other_ways():
    longer, usual = (choices("hip_position_m=1e-6", *steps)["multibody"].settings["tolerance"]
                     for steps in (("multibody.steps=1000",), ()))  # fmt: skip
    joints = choices("hip_position_m=1e-5", "multibody.assembly=joints")["multibody"]
    assert longer < usual and set(joints.settings) == {"rolling_step", "impact_step"}


def test_a_looser_tolerance_that_saves_nothing_is_not_taken():
    for error in ASKED:
        assert choices(f"hip_position_m={error!r}")["analytic"].settings["tolerance"] <= choice.LOOSEST_ANALYTIC


@pytest.mark.parametrize(("asked", "settings", "said"), [
    ("quick", (), "the form is draft, paper, reference"),
    ("step_frequency_hz=0.02", (), "an error of hip_position_m, period_s, multiplier, peak_force_n, as in"),
    ("hip_position=1e-5", (), 'did you mean "hip_position_m"'),
    ("hip_position_m=0", (), "allowed: > 0"),
    ("hip_position_m=nan", (), "allowed: > 0"),
    ("hip_position_m=1e-20", (), "stage analytic cannot have hip_position_m <= 1e-20; allowed: >= "),
    ("multiplier=1e-3", (), "its error was not measured"),
    ("hip_position_m=1e-3", ("twin.tolerance=1e-5",),
     "--set twin.tolerance=1e-5 is not allowed: twin.accuracy decides it"),
    ("", ("twin.tolerance=1e-5", "twin.accuracy={hip_position_m: 1e-3}"), "twin.accuracy decides it"),
])  # fmt: skip
def test_what_cannot_be_had_or_is_given_twice_is_refused_in_a_sentence(asked, settings, said):
    with pytest.raises(StudyError) as refused:
        choices(asked, *settings)
    assert said in str(refused.value)


def test_walks_are_compared_at_common_times():
    one = SimpleNamespace(time=np.arange(5) * 0.1, hip_position=np.zeros((5, 2)))
    other = SimpleNamespace(time=np.arange(4) * 0.2, hip_position=np.full((4, 2), 0.25))
    assert error_estimate.walk_difference(one, other) == 0.25


@pytest.fixture
def verifiable(tmp_path):
    """A study in whose results the twin's artefact lies, one whose run estimated an error."""
    study = Study(ROOT, ROOT / "params", tmp_path, (), asked=(("accuracy", "hip_position_m=1e-8"),))
    place = study.store.place(study.graph.stages["twin"].artefact)
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_bytes(b"made up")
    return study


def test_an_estimate_is_kept_beside_the_artefact_it_belongs_to(verifiable, monkeypatch, capsys):
    estimated = (ErrorEstimate("hip_position_m", 1e-8, 2.34e-9, "tolerance 1e-10"),)
    monkeypatch.setattr(artefact, "provenance", lambda *_: {"key": "k1"})
    monkeypatch.setattr(artefact, "decode", lambda *_: SimpleNamespace(errors=estimated))
    chosen = requests.to_verify(verifiable, ("twin",))
    requests.verify(verifiable, chosen, told=True)
    kept = yaml.safe_load(requests.record_of(verifiable, request, "twin").read_text())
    assert kept["estimated"] == {"hip_position_m": 2.3e-9} and kept["asked"] == {"hip_position_m": 1e-8}
    assert kept["proposed"] == chosen[0][2].settings and kept["settings"] == "tolerance 1e-10"
    said = "used tolerance 1e-10; estimated hip_position_m 2.3e-09"
    about = {"stage": "twin", "key": "k1", "accuracy": "asked: {hip_position_m: 1e-8}; used: tolerance 1e-9"}
    assert said in "".join(requests.kept(verifiable, about)) and said in capsys.readouterr().out
    assert list(requests.kept(verifiable, {**about, "key": "of another run"})) == [f"accuracy {about['accuracy']}"]


def test_nothing_asked_is_nothing_to_verify():
    with pytest.raises(StudyError, match=r"none is asked of twin, imu; give --accuracy"):
        requests.to_verify(study(), ("twin", "imu"))


@dataclasses.dataclass(frozen=True)
class Solver:
    """Settings of a solver that has a floor."""

    tolerance: float

    def finer(self):
        return Solver(self.tolerance / 10) if self.tolerance > 1.5e-8 else None


def solved(asked, error_of, tolerance=1e-3):
    """The settings taken, their value, and its estimate, of a solver with a given error at a tolerance."""
    accuracy = asked if isinstance(asked, str) else Accuracy(hip_position_m=asked)
    return to_accuracy(accuracy, Solver(tolerance), lambda at: error_of(at.tolerance), Solver.finer,
                       lambda one, other: {"hip_position_m": abs(one - other)})  # fmt: skip


@pytest.mark.parametrize("asked", [1e-1, 1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("factor, order", [(1.0, 1.0), (30.0, 0.7), (1e-3, 2.0)])
def test_settings_are_refined_until_the_error_is_what_was_asked(asked, factor, order):
    """Where the estimate says so the true error is smaller still; else it is refused."""
    try:
        settings, error, (estimate,) = solved(asked, lambda tolerance: factor * tolerance**order)
    except NotMet as refusal:
        assert factor * 1e-8**order * 4 > asked and f"hip_position_m <= {asked:g} requested" in str(refusal)
        return
    assert error <= estimate.estimated <= estimate.asked == asked
    assert estimate.settings == f"tolerance {settings.tolerance:g}"


def test_what_is_not_estimated_or_does_not_converge_is_not_met():
    for error_of, words in ((lambda tolerance: np.sin(1 / tolerance), "reached with the finest settings"),
                            (lambda tolerance: np.nan, "reached")):  # fmt: skip
        with pytest.raises(NotMet, match=words):
            solved(1e-3, error_of)
    with pytest.raises(NotMet, match="has no estimate"):
        to_accuracy(Accuracy(multiplier=1.0), Solver(1e-3), lambda at: 0.0, Solver.finer, lambda one, other: {})


def test_nothing_asked_is_one_walk_as_the_settings_stand():
    walked = []
    settings, _, errors = solved(CUSTOM, lambda tolerance: walked.append(tolerance))
    assert (settings.tolerance, walked, errors) == (1e-3, [1e-3], ())


def analytic(*settings, asked):
    from tests.analytic.designs import run_alone

    return run_alone(study(*settings, asked=asked).parameters(("analytic",))["analytic"])


ODD = ("biped.foot_com=0.12", "ground.slope_deg=3", "analytic.steps=4", "analytic.sampling_rate_hz=500")


@pytest.fixture(scope="module")
def exact():
    return analytic(*ODD, "analytic.tolerance=1e-14", asked="")


@pytest.mark.parametrize("asked", ["hip_position_m=1e-5", "hip_position_m=1e-9,multiplier=1e-9"])
def test_an_accuracy_is_met_on_a_design_that_no_table_knows(asked, exact):
    """The design on which 0.1.0 asked for 1e-5 m had 3.8e-5."""
    found = analytic(*ODD, asked=asked)
    true = error_estimate.walk_differences(found.walk, exact.walk)
    leading = [np.hypot(*one.gait.floquet_multipliers[0]) for one in (found, exact)]
    true["multiplier"] = abs(leading[0] - leading[1])
    for row in found.errors:
        assert true[row.name] <= row.asked and row.estimated <= row.asked
    assert exact.errors == ()


def test_an_error_that_grows_beyond_the_finest_tolerance_is_refused():
    """An unstable gait loses a digit every few steps: after twenty, round-off is more than a micrometre."""
    with pytest.raises(NotMet, match=r"hip_position_m <= 1e-06 requested"):
        analytic("ground.slope_deg=8", "analytic.steps=20", "analytic.sampling_rate_hz=100",
                 asked="hip_position_m=1e-6")


@pytest.mark.slow
@pytest.mark.parametrize("error", [1e-4, 1e-6])
def test_the_true_error_of_a_penalty_walk_keeps_the_request(error):
    from stages.multibody.run import walk_to_accuracy
    from stages.planar.run import rolling_state

    start = analytic(*ODD, asked="").mid_stance

    def walk(*settings, asked):
        values = study(*ODD, *settings, asked=asked).parameters(("multibody",))["multibody"]
        state = rolling_state(values.biped, values.contact, start, 9.4)
        return walk_to_accuracy(values, state, 0.3)[1][2]

    exact = walk("multibody.tolerance=1e-11", "multibody.largest_step=2e-4", asked="")
    found = walk(asked=f"hip_position_m={error!r}")
    assert error_estimate.walk_difference(found, exact) <= error
