"""An accuracy asked for: the level that goes with it, what is refused, how a run checks and refines its settings."""

import dataclasses
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from pipeline.cache import artefact, fingerprint
from pipeline.commands import options
from pipeline.errors import StudyError
from pipeline.parameters import loading
from pipeline.study import Study
from stages.biped.accuracy import estimate as error_estimate
from stages.biped.accuracy.estimate import ErrorEstimate, NotMet, to_accuracy
from stages.biped.accuracy.tolerances import CUSTOM, LEVEL_ERRORS, LEVELS, Accuracy
from stages.tradeoff import request

ROOT = Path(__file__).resolve().parents[2]


def study(*settings, asked=""):
    return Study(ROOT, ROOT / "params", ROOT / "results", settings, requested=(("accuracy", asked),))


def asked_of(found, values):
    return {stage: asked.errors for _, stage, asked in options.all_requested(found, values)}


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


def test_what_is_asked_is_among_the_parameters_and_stated():
    """Key and account of the artefact follow from them; the settings are those of the level that goes with it."""
    found, level = study(asked="hip_position_m=1e-6"), study(asked="reference")
    stages = ("analytic", "multibody", "twin", "imu")
    values, plain = found.parameters(stages), level.parameters(stages)
    assert asked_of(found, values) == {name: {"hip_position_m": 1e-6} for name in request.FILES}
    for name in request.FILES:
        own = loading.as_plain(values[name])[name]
        assert own["accuracy"]["hip_position_m"] == 1e-6 and values[name].settings.tolerance == (
            plain[name].settings.tolerance)  # fmt: skip
        assert said_of(name, {name: own}) == "asked: {hip_position_m: 1e-6}"
    as_it_stands = study().parameters(("twin",))
    assert asked_of(study(), as_it_stands) == {} and as_it_stands["twin"].settings.accuracy == CUSTOM
    assert said_of("twin", loading.as_plain(as_it_stands["twin"])) == ""


def said_of(stage, parameters):
    """What an artefact's account says of the request."""
    return fingerprint._requested({"stage": stage, "parameters": parameters}, request)


def test_what_can_be_asked_is_what_the_parameters_have():
    assert set(request.KEYS) == set(vars(Accuracy()))


@pytest.mark.parametrize("line", [
    "accuracy: {hip_position_m: 1e-3}",
    "accuracy: {value: {hip_position_m: 1e-3}, source: a test}",
])  # fmt: skip
def test_the_key_of_a_file_asks_as_the_option_does(tmp_path, line):
    found, values, _ = with_key(tmp_path, line)
    assert asked_of(found, {"twin": values}) == {"twin": {"hip_position_m": 1e-3}}


def test_the_option_goes_before_the_key_and_set_before_both(tmp_path):
    found, _, _ = with_key(tmp_path, "accuracy: {hip_position_m: 1e-3}")
    asked = dataclasses.replace(found, requested=(("accuracy", "hip_position_m=1e-7"),))
    assert asked.parameters(("twin",))["twin"].settings.accuracy.hip_position_m == 1e-7
    mine = dataclasses.replace(asked, settings=("twin.accuracy=custom", "twin.tolerance=3e-6"))
    assert mine.parameters(("twin",))["twin"].settings.tolerance == 3e-6
    assert mine.parameters(("analytic",))["analytic"].settings.accuracy.hip_position_m == 1e-7


@pytest.mark.parametrize("level", LEVELS)
def test_a_word_is_the_level_of_the_whole_study_and_what_is_set_by_hand_wins(tmp_path, level):
    stages = ("analytic", "multibody", "twin", "campaign", "twin_ladder", "comparison")
    values = study(asked=level).parameters(stages)
    assert {one.level.level for one in values.values()} == {level}
    assert all(values[name].settings.accuracy == CUSTOM for name in request.FILES)
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
    errors = LEVEL_ERRORS
    assert list(errors) == list(LEVELS)
    for key in request.KEYS:
        assert errors["draft"][key] >= errors["paper"][key] >= errors["reference"][key] > 0
        for level in LEVELS:
            assert errors[request.level({key: errors[level][key]})][key] <= errors[level][key]
    assert errors["draft"]["hip_position_m"] > 5 * errors["paper"]["hip_position_m"]
    assert request.level({"hip_position_m": 1e-30}) == "reference"
    assert study(asked="hip_position_m=1e-3").parameters(("campaign",))["campaign"].level.level == "draft"


@pytest.mark.parametrize(("line", "said"), [
    ("accuracy: custm", 'accuracy = "custm" is not allowed; allowed: custom, or errors by '
                       'hip_position_m, period_s, multiplier, peak_force_n as {hip_position_m: 1e-5}; did you mean'),
    ("accuracy: 1e-5", "accuracy = 1e-05 is not a word; allowed: custom, or errors by"),
    ("accuracy: {hip_position_m: -1}", "accuracy: hip_position_m = -1 m is not allowed; allowed: > 0 m"),
    ("accuracy: {hip_position: 1e-5}", 'accuracy has an unknown column "hip_position"; did you mean "hip_position_m"?'),
    ("accuracy: {}", "at least one of hip_position_m, period_s, multiplier, peak_force_n"),
])  # fmt: skip
def test_a_wrong_key_is_told_with_file_line_value_and_what_is_allowed(tmp_path, line, said):
    told, _, number = with_key(tmp_path, line)
    assert f"twin.yaml:{number}: accuracy" in told and said in told and "\n" not in told


@pytest.mark.parametrize(("asked", "said"), [
    ("quick", "the form is draft, paper, reference"),
    ("step_frequency_hz=0.02", "an error of hip_position_m, period_s, multiplier, peak_force_n, as in"),
    ("hip_position=1e-5", 'did you mean "hip_position_m"'),
    ("hip_position_m=0", "allowed: > 0"),
    ("hip_position_m=nan", "allowed: > 0"),
])  # fmt: skip
def test_what_cannot_be_asked_is_refused_in_a_sentence(asked, said):
    with pytest.raises(StudyError) as refused:
        study(asked=asked).parameters(request.FILES)
    assert said in str(refused.value)


def test_walks_are_compared_at_common_times():
    one = SimpleNamespace(time=np.arange(5) * 0.1, hip_position=np.zeros((5, 2)))
    other = SimpleNamespace(time=np.arange(4) * 0.2, hip_position=np.full((4, 2), 0.25))
    assert error_estimate.walk_difference(one, other) == 0.25


@pytest.fixture
def verifiable(tmp_path):
    """A study in whose results the twin's artefact lies, one whose run estimated an error."""
    study = Study(ROOT, ROOT / "params", tmp_path, (), requested=(("accuracy", "hip_position_m=1e-8"),))
    place = study.store.place(study.graph.stages["twin"].artefact)
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_bytes(b"made up")
    return study


def test_an_estimate_is_kept_beside_the_artefact_it_belongs_to(verifiable, monkeypatch, capsys):
    estimated = (ErrorEstimate("hip_position_m", 1e-8, 2.34e-9, "tolerance 1e-10"),)
    monkeypatch.setattr(artefact, "provenance", lambda *_: {"key": "k1"})
    monkeypatch.setattr(artefact, "decode", lambda *_: SimpleNamespace(errors=estimated))
    chosen = options.to_verify(verifiable, ("twin",))
    options.keep_verifications(verifiable, chosen, show=True)
    kept = yaml.safe_load(options.record_of(verifiable, request, "twin").read_text())
    assert kept["estimated"] == {"hip_position_m": 2.3e-9} and kept["asked"] == {"hip_position_m": 1e-8}
    assert kept["settings"] == "tolerance 1e-10"
    said = "used tolerance 1e-10; estimated hip_position_m 2.3e-09"
    about = {"stage": "twin", "key": "k1", "accuracy": "asked: {hip_position_m: 1e-8}"}
    assert said in "".join(options.verifications(verifiable, about)) and said in capsys.readouterr().out
    of_another = options.verifications(verifiable, {**about, "key": "of another run"})
    assert list(of_another) == [f"accuracy {about['accuracy']}"]


def test_nothing_asked_is_nothing_to_verify():
    with pytest.raises(StudyError, match=r"none is asked of twin, imu; give --accuracy"):
        options.to_verify(study(), ("twin", "imu"))


@dataclasses.dataclass(frozen=True)
class Solver:
    """Settings of a solver that has a floor."""

    tolerance: float

    def finer(self, by):
        found = Solver(min(max(self.tolerance * by, 1e-8), 1e-3))
        return None if found == self else found


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
    assert estimate.settings == f"tolerance {settings.tolerance:.3g}"


def test_what_is_not_estimated_or_does_not_converge_is_not_met():
    for error_of, words in ((lambda tolerance: np.sin(1 / tolerance), "reached with the finest settings"),
                            (lambda tolerance: np.nan, "reached")):  # fmt: skip
        with pytest.raises(NotMet, match=words):
            solved(1e-3, error_of)
    walked = []
    with pytest.raises(NotMet, match="has no estimate"):
        to_accuracy(Accuracy(multiplier=1.0), Solver(1e-3), walked.append, Solver.finer, lambda one, other: {})
    assert len(walked) == 2, "a finer walk would have none either"


def test_nothing_asked_is_one_walk_as_the_settings_stand():
    walked = []
    settings, _, errors = solved(CUSTOM, lambda tolerance: walked.append(tolerance))
    assert (settings.tolerance, walked, errors) == (1e-3, [1e-3], ())


def analytic(*settings, asked):
    from tests.analytic.designs import run_alone

    return run_alone(study(*settings, asked=asked).parameters(("analytic",))["analytic"])


#: Two robots of which no other's errors tell: a design unlike Table 1's, and one with legs of 1.2 m.
WALK = ("analytic.steps=4", "analytic.sampling_rate_hz=500")
ROBOTS = {
    "odd": ("biped.foot_com=0.12", "ground.slope_deg=3", *WALK),
    "table_1": WALK,
    "large": ("biped.leg_length=1.2", "biped.foot_radius=0.3", "biped.foot_com=0.36", "biped.stiffness=800",
              "biped.damping=32", *WALK),
}  # fmt: skip


@pytest.fixture(scope="module", params=ROBOTS)
def robot(request):
    """Settings of a robot, and its walk at the finest tolerance."""
    settings = ROBOTS[request.param]
    return settings, analytic(*settings, "analytic.tolerance=1e-14", asked="")


@pytest.mark.parametrize("asked", ["hip_position_m=1e-5", "hip_position_m=1e-9,multiplier=1e-9"])
def test_an_accuracy_is_met_on_any_design(asked, robot):
    """The odd design had 3.8e-5 m in 0.1.0 where 1e-5 was asked."""
    settings, exact = robot
    found = analytic(*settings, asked=asked)
    true = error_estimate.walk_differences(found.walk, exact.walk)
    leading = [np.hypot(*one.gait.floquet_multipliers[0]) for one in (found, exact)]
    true["multiplier"] = abs(leading[0] - leading[1])
    for row in found.errors:
        assert true[row.name] <= row.asked and row.estimated <= row.asked
    assert exact.errors == ()


@pytest.mark.parametrize("asked", ["hip_position_m=1e-20", "hip_position_m=1e-7"])
def test_an_error_that_grows_beyond_the_finest_tolerance_is_refused(asked):
    """An unstable gait loses a digit every few steps: after twenty, round-off is more than a tenth of a micrometre."""
    with pytest.raises(NotMet, match=r"hip_position_m <= 1e-(20|07) requested"):
        analytic("ground.slope_deg=8", "analytic.steps=20", "analytic.sampling_rate_hz=100", asked=asked)


@pytest.mark.slow
@pytest.mark.parametrize("error", [1e-4, 1e-6])
def test_the_true_error_of_a_penalty_walk_keeps_the_request(error, robot):
    from stages.multibody.run import walk_to_accuracy
    from stages.planar.run import rolling_state

    given, start = robot

    def walk(*settings, asked):
        values = study(*given, *settings, asked=asked).parameters(("multibody",))["multibody"]
        state = rolling_state(values.biped, values.contact, start.mid_stance, 9.4)
        return walk_to_accuracy(values, state, 0.3)[1][2]

    exact = walk("multibody.tolerance=1e-11", "multibody.largest_step=2e-4", asked="")
    found = walk(asked=f"hip_position_m={error!r}")
    assert error_estimate.walk_difference(found, exact) <= error
