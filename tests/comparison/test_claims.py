"""Every claim must be able to hold, to fail, and not to apply, each for a reason of its own."""

import dataclasses
import re
from math import inf, nan
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from pipeline.commands import claims as shown
from pipeline.study import Study
from stages.comparison.claims import judge, numerics
from stages.comparison.claims.judge import judged
from stages.comparison.claims.paper import BIPED, SETTINGS
from stages.comparison.result import DOES_NOT_APPLY, FAILS, HOLDS, HOLDS_IF, OPEN, VERDICTS, BipedSummary
from stages.comparison.run import as_yaml
from stages.tradeoff import constraint_ways, penalty_ways
from tests.changed import changed

ROOT = Path(__file__).resolve().parents[2]
#: At the level of which no numerical error is known.
PARAMETERS = Study(ROOT, ROOT / "params", ROOT / "results", ("accuracy.level=reference",)).parameters(
    ("comparison",))["comparison"]  # fmt: skip
LIMITS = PARAMETERS.settings
PARTS = (("creep", -5e-4, 2e-5), ("slip", 2.5e-4, 0.0), ("finite stiffness", 3e-4, 2e-5))
FALLS = (("speed to the side", "m/s", 0.1, 0.15), ("angle of yaw", "rad", 0.2, inf))


def given(claim, *numbers):
    return judge.STATEMENTS[claim].of(*numbers)


#: For each claim an input that makes it hold, and what changes to make it fail.
CASES = [
    (given("constraints_reduce_effort", 1e-7, 600.0, 5000.0, 2.8, 100.0), {"penalty": 500.0}),
    (given("twice_differentiated_constraints", 1e-3, 0.139, 0.264), {"drift": 1e-14, "slip": 0.0, "descent": 0.0}),
    (given("multipliers_minimised", 0.6, 0.62, "hip_mass -5 %"), {"now": 1.2, "best": 1.1}),
    (given("stable_gait", 0.64, 0.642), {"multibody": 1.02}),
    (given("tight_tolerances_add_rounding", "way", 1e-13, 2e-12, 1e-12, 1e-7, 4.5, 0.0), {"error": 1e-13}),
    (given("chaos_amplifies", 1.1, 4.0, 2.6, 10), {"multiplier": 0.64, "left": 0.02}),
    (given("contact_set", 0.124, 0.049, 0.6, 3.7, 100.0), {"best": 0.13}),
    (given("contact_set_figure_8", 2e-4, 3e4, 4e-3, 1.9e-3, 4.5e-4, 0.05), {"least": 2.3e-3}),
    (given("rolling_without_slip", 1.1, 0.19, 0.9, 0.4, 0.0, 0.0), {"trailing": 24.0, "time_outside": 0.2}),
    (given("friction_velocities", "stiction_velocity", inf, 2e-3, -3e-3, 4e-3), {"turning": 1.05}),
    (given("stiff_solver", 400.0, 500.0, 4000.0, 5000.0), {"constraint_stiff": 600.0, "penalty_stiff": 6000.0}),
    (given("hip_displacement", 2.5e-4, 2.9e-4, 1.9e-4, 1.1e-3, 1.2e-3, PARTS, 2.4e-4, 2e-5, 0.1), {"limit_step": 4e-4}),
    (given("hip_velocity", 2.7e-3, 3.4e-3, 3.9e-3, 4e-3), {"limit_cycle": 6e-3}),
    (given("integration_tolerance", "completed", 1e-4, 2e-4, 1e-5, PARTS, 0.9, 0.9), {"integration": 1e-8}),
    (given("twin_settles", 1, 0.496, 0.49, 0.77, "2.041 ± 0.001 Hz"), {"steps": -1}),
    (given("ramp_length", 0.161, 1.69, 0.024, 0.042, 0.08), {"step": 0.2, "needed": 2.08}),
    (given("ramp_passed", 11, 4e-4, 0.95, 0.93, 0.97, 0.9, 0.99, nan, 4e-4), {"chance": 0.8}),
    (given("push_converges", 0, 30, (("speed to the side", "m/s", 0.2, inf),), 0.77, 0.99), {"failed": 3}),
    (given("step_frequency", 2.0718, 0.0068, "biped.foot_com", 0.0032, (2.047, 2.075)), {"frequency": 2.2}),
    (given("sensor_range", 3.0, 3.5, 169.0, 0.0, 0.48, (15.0, 160.0), (1.5e-3, 2.2e-3), 2.4),
     {"above": 0.02, "hip": 80.0}),
    (given("twin_like_simple", 0.017, 0.017, 0.005, (("inertia", 0.026), ("leg", -0.018)), 0.48, False), {"up": 0.2}),
    (given("hip_path_drifts", "synthetic", 1.7, 0.2, 0.02, 2e-3, 0.16, 1e-3, 0.161, 0.162), {"twice": 1e-3}),
    (given("measurement_encloses", "measured", 30, (0.97, 1.0, 1.0)), {"shares": (0.5, 1.0, 1.0)}),
    (given("measurement_slower", "measured", 1.9, 2.0, -0.11, -0.09), {"frequency": 2.1, "lower": 0.1, "upper": 0.2}),
    (given("outsole_slows", 2e-3, -1e-3, -3e-3, 0.01, nan, "measured", 2, 2e-3, 4e-4, -3e-3, 1e-3, nan),
     {"length_alone": 2e-3, "with_mass": 1e-3, "slower": 3e-3}),
    (given("push_slows", "measured", 30, -0.6, 0.36, 0.36), {"correlation": 0.1}),
    (
        given("prototype_is_model", "measured", 2, (("hip_mass", 0.31, 0.32, 0.316),), -1),
        {"intervals": (("hip_mass", 0.33, 0.34, 0.316),)},
    ),
]

#: Inputs that make a claim hold on a condition, or leave it open.
ROLLING = next(holding for holding, _ in CASES if holding.about.id == "rolling_without_slip")
PATH = next(holding for holding, _ in CASES if holding.about.id == "hip_path_drifts")
CONDITIONS = [
    (PATH, {"once": 5e-3}, "one integration of the rate"),
    (CASES[1][0], {"drift": 1e-14}, "no impact map"),
    (CASES[6][0], {"factor": 0.1}, "a factor of 10.0 is small"),
    (CASES[9][0], {"turning": 1.4}, "below a factor of 1.4"),
    (CASES[10][0], {"constraint_stiff": 600.0}, "the penalty model is meant"),
    (CASES[11][0], {"limit_cycle": 4.6e-4}, "over one step from a common state"),
    (CASES[17][0], {"limits_of": FALLS}, "speed to the side below 0.15 m/s"),
    (CASES[19][0], {"above": 2e-3}, "the 2.0 ms a step around heel strike are not counted"),
    (CASES[20][0], {"assumed": True}, "the bill of parts that twin.yaml assumes"),
    (CASES[24][0], {"length_alone": 1e-3, "turning": 3e-3}, "more than 3.0 g a leg"),
    (CASES[16][0], {"lost": 7e-4, "highest": 1e-3}, "blocks are good to 0.4 mm"),
]
UNDECIDED = [
    (PATH, {"twice": nan}, "whose truth is known"),
    (CASES[0][0], {"penalty": nan}, "no way of one of the models"),
    (CASES[0][0], {"error": nan}, "has no walk at the paper's setting"),
    (CASES[2][0], {"best": 0.5}, "fine-tuned to the robot"),
    (CASES[2][0], {"best": nan}, "no neighbouring design"),
    (CASES[3][0], {"multibody": nan}, "no fixed point of the multibody model"),
    (CASES[4][0], {"error": nan}, "one tolerance at most"),
    (CASES[6][0], {"default": nan}, "no step was finished"),
    (CASES[7][0], {"least": nan}, "no step with k_c"),
    (CASES[9][0], {"halved": nan, "doubled": nan}, "no walk with a changed"),
    (CASES[10][0], {"constraint_stiff": nan, "penalty_stiff": nan}, "no pair"),
    (CASES[11][0], {"limit_step": nan}, "has no gait"),
    (CASES[12][0], {"limit_step": nan}, "has no gait"),
    (CASES[13][0], {"whole": nan, "outcome": "over one step: fall"}, "fall"),
    (CASES[15][0], {"reach": nan}, "fewer steps than"),
    (CASES[22][0], {"origin": "synthetic"}, "synthetic"),
    (CASES[23][0], {"origin": "synthetic"}, "synthetic"),
    (CASES[23][0], {"upper": 0.01}, "holds zero"),
    (CASES[24][0], {"length_alone": nan}, "no gait was found with an outsole"),
    (CASES[24][0], {"length_alone": 1e-3, "with_mass": nan}, "mass does was not computed"),
    (CASES[25][0], {"origin": "synthetic"}, "synthetic"),
    (CASES[25][0], {"correlation": nan}, "holds no pushes"),
    (CASES[26][0], {"intervals": ()}, "must be estimated"),
    (CASES[26][0], {"intervals": (("hip_mass", 0.2, 0.5, 0.316),)}, "too wide to decide: hip_mass"),
    (CASES[24][0], {"slower_half": 4e-3}, "the calibrated interval of the change holds zero"),
]


def names(cases):
    return [case[0].about.id for case in cases]


def of(measured, **changes):
    return dataclasses.replace(measured, numbers={**measured.numbers, **changes})


def reason(claim):
    """The causes without their numbers."""
    return re.sub(r"[-+]?\d[\d.e+-]*", "#", " ".join(claim.causes))


@pytest.mark.parametrize(("holding", "change"), CASES, ids=names(CASES))
def test_every_claim_can_hold_fail_and_not_apply_for_three_different_reasons(holding, change):
    other = changed(PARAMETERS, **({"legs": "rigid"} if holding.about.method else {"hip_mass": 0.4}))
    claims = [judged(PARAMETERS, holding), judged(PARAMETERS, of(holding, **change)), judged(other, holding)]
    assert [claim.verdict for claim in claims] == [HOLDS, FAILS, DOES_NOT_APPLY]
    reasons = [reason(claim) for claim in claims]
    assert all(reasons) and len(set(reasons)) == 3
    assert claims[0].measured != claims[1].measured and claims[0].measured == claims[2].measured


@pytest.mark.parametrize(("holding", "change", "condition"), CONDITIONS, ids=names(CONDITIONS))
def test_a_claim_that_holds_on_a_condition_names_it_and_why(holding, change, condition):
    claim = judged(PARAMETERS, of(holding, **change))
    assert claim.verdict == HOLDS_IF and condition in claim.condition
    assert claim.causes and reason(claim) != reason(judged(PARAMETERS, holding))


def test_ground_that_would_have_to_pull_is_not_told_as_friction_without_a_number():
    for foot, needed, words in (("trailing", inf, "pull the trailing foot"), ("landing", 2.0, "on the landing")):
        claim = judged(PARAMETERS, of(ROLLING, **{foot: needed}))
        said = " ".join([claim.measured, *claim.causes])
        assert claim.verdict == FAILS and words in said and not re.search(r"\binf\b|asks the trailing foot", said)


@pytest.mark.parametrize(("holding", "change", "words"), UNDECIDED, ids=names(UNDECIDED))
def test_what_cannot_be_decided_stays_open_with_a_reason(holding, change, words):
    claim = judged(PARAMETERS, of(holding, **change))
    assert claim.verdict == OPEN and words in " ".join(claim.causes)
    assert not re.search(r"\bnan\b", " ".join([claim.measured, *claim.causes]))


def test_only_a_verdict_with_a_condition_has_one():
    for holding, change in [*CASES, *((case[0], case[1]) for case in [*CONDITIONS, *UNDECIDED])]:
        claim = judged(PARAMETERS, of(holding, **change))
        assert bool(claim.condition) == (claim.verdict == HOLDS_IF)


def test_a_cause_that_is_not_true_is_not_named():
    hip, ladder = CASES[11][0], CASES[20][0]
    for measured, words, named in (
        (ladder, "act against each other", True),
        (of(ladder, details=(("inertia", 0.026), ("leg", 0.018))), "act against each other", False),
        (hip, "cancel", True), (hip, "creep -0.50 ± 0.02 mm, finite stiffness", True),
        (of(hip, parts=(("slip", 1e-4, 0.0),)), "cancel", False),
    ):  # fmt: skip
        assert (words in " ".join(judged(PARAMETERS, measured).causes)) == named


@pytest.mark.parametrize("key", BIPED)
def test_another_biped_or_slope_is_not_judged_as_the_papers(key):
    """Each of Table 1's values, legs, slope and gravity alone makes claims on that biped not apply, and is named."""
    file, name = key.split(".")
    section, printed = {"biped": "biped", "ground": "slope"}[file], BIPED[key].value
    value = "rigid" if isinstance(printed, str) else 1.01 * printed + 1e-3
    parameters = changed(PARAMETERS, **{section: dataclasses.replace(getattr(PARAMETERS, section), **{name: value})})
    claim = judged(parameters, CASES[18][0])
    assert claim.verdict == DOES_NOT_APPLY and f"{key} is " in claim.causes[0] and BIPED[key].source in claim.causes[0]
    of_the_method = judged(parameters, CASES[0][0])
    assert (of_the_method.verdict == DOES_NOT_APPLY) == (key == "biped.legs")


@pytest.mark.parametrize(("key", "value", "word"), [
    ("frame_mass", 0.1, "0.1 kg"), ("other_leg_length", 0.3331, "0.3331 m"), ("feet_retract", True, "true")])
def test_a_detail_that_the_papers_biped_has_not_is_another_biped(key, value, word):
    parameters = changed(PARAMETERS, biped=dataclasses.replace(PARAMETERS.biped, **{key: value}))
    claim = judged(parameters, CASES[18][0])
    assert claim.verdict == DOES_NOT_APPLY and f"biped.{key} is {word}, the paper's biped has none" in claim.causes[0]
    assert judged(parameters, CASES[0][0]).verdict == HOLDS  # of the method


def test_a_changed_contact_set_or_solver_keeps_the_claim_and_is_named_in_it():
    planar = dataclasses.replace(PARAMETERS.planar, tolerance=1e-8)
    claim = judged(changed(PARAMETERS, contact_stiffness=2e5, stiction_velocity=0.1, planar=planar), CASES[3][0])
    assert claim.verdict == HOLDS and judge.another_biped(PARAMETERS) == ()
    for words in ("ground.contact_stiffness 200000 N/mm^e", "ground.stiction_velocity 0.1 m/s",  # as the paper has it
                  "multibody.tolerance 1e-08 (paper: 1e-06, section 3.5)"):  # fmt: skip
        assert words in claim.rests_on


def test_every_parameter_that_a_claim_or_the_paper_names_exists():
    stages = {"imu"}  # whose settings name a file, which the comparison does not read
    for key in [key for case in CASES for key in case[0].about.rests_on] + [*BIPED, *SETTINGS]:
        assert key.split(".")[0] in stages or judge.found(PARAMETERS, key) != (None, ""), key


def test_every_statement_has_a_claim_and_they_come_in_the_papers_order():
    assert [case[0].about.id for case in CASES] == list(judge.STATEMENTS)
    sections = [[int(part) for part in re.findall(r"\d+", says.section)[:2]] for says in judge.STATEMENTS.values()]
    assert sections == sorted(sections)


def test_rounding_is_told_no_finer_than_the_reference_is_sure():
    """Another biped's tightest walk equals its reference: it said that rounding stays below 0e+00 m."""
    tight = next(holding for holding, _ in CASES if holding.about.id == "tight_tolerances_add_rounding")
    claim = judged(PARAMETERS, of(tight, error=2e-16, before=2e-16, doubt=2e-16))
    assert claim.verdict == FAILS and "rounding stays below 2e-16 m: the reference" in claim.causes[0]
    assert "from < 2.0e-16 to < 2.0e-16 m" in claim.measured
    for error, said in ((2e-14, "2e-14 m: the reference"), (3e-14, "3e-14 m: the error falls")):
        claim = judged(PARAMETERS, of(tight, error=error, before=1e-12, doubt=2e-14))
        assert f"rounding stays below {said}" in claim.causes[0]
    for error, verdict in ((1.5e-12, FAILS), (2.1e-12, HOLDS)):
        assert judged(PARAMETERS, of(tight, error=error, before=1e-12, doubt=5e-13)).verdict == verdict


def test_each_claim_begins_with_a_sentence_in_plain_words():
    for name, one in judge.STATEMENTS.items():
        assert one.plain.endswith(".") and len(one.plain.split()) <= 25 and ";" not in one.plain, name
    short = shown.Claim("a", "1", "b", "c", "d", "open", "", [], [], plain="Short.")
    assert shown.as_text(short, 80).splitlines()[1] == "  in short  Short."


def test_the_models_of_the_tradeoff_are_called_what_it_calls_them():
    assert (numerics.ROLLING, numerics.PENALTY) == (constraint_ways.ROLLING, penalty_ways.PENALTY)


def test_claims_survive_yaml_and_the_command_knows_their_verdicts():
    assert tuple(shown.VERDICTS) == VERDICTS
    claim = dataclasses.replace(
        judged(PARAMETERS, CASES[0][0]), words='quotes " and: colons', measured="µ ≤ 3 # no comment", causes=("a\nb",)
    )
    biped = BipedSummary(*[nan] * 16, 3e-10, 1.25)
    read = yaml.safe_load(as_yaml([claim], [("title", ("", "a"), [("row", "1")])], ["one: two"], "draft", biped))
    numbers = [str(number) for number in claim.numbers]
    assert read["claims"] == [{**dataclasses.asdict(claim), "causes": ["a\nb"], "rests_on": list(claim.rests_on),
                               "numbers": numbers}] and numbers  # fmt: skip
    assert (read["level"], read["headlines"]) == ("draft", ["one: two"])
    assert read["tables"] == [{"title": "title", "columns": ["", "a"], "rows": [["row", "1"]]}]
    assert (read["verdicts"], read["numbers"]) == ({"holds": 1}, {"penalty_work": 3e-10, "error": 1.25})
    assert shown.Claim(**read["claims"][0]).full_verdict == "holds (errors unknown here)"


def test_a_multibody_model_without_a_cycle_leaves_stability_open():
    multibody = SimpleNamespace(cycle=SimpleNamespace(largest_multiplier=nan))
    leading = CASES[3][0].numbers["constraint"]
    analytic = SimpleNamespace(gait=SimpleNamespace(floquet_multipliers=leading * np.eye(1, 2)))
    evidence = SimpleNamespace(results=SimpleNamespace(multibody=multibody, analytic=analytic))
    claim = judged(PARAMETERS, judge.STATEMENTS["stable_gait"].measured(evidence))
    assert claim.verdict == OPEN and "no multibody gait" in claim.measured


def test_without_a_synthetic_campaign_pushes_along_the_path_do_not_apply():
    judged = given("push_converges", 0, 0, (("speed to the side", "m/s", 0.2, inf),), 0.77, 0.99).judge(LIMITS)
    assert judged.verdict == DOES_NOT_APPLY
    assert any("a lab's own measurements take its place" in words for words in judged.reasons)


def test_synthetic_runs_decide_as_a_method_and_say_so():
    """What a calibration finds of a machine that is made up is a verdict on that machine."""
    for place, said in ((24, "mm longer"), (26, "estimated from 2 synthetic runs")):
        holding, changes = CASES[place]
        for made_up, verdict in ((of(holding, origin="synthetic"), HOLDS),
                                 (of(holding, origin="synthetic", **changes), FAILS)):
            claim = judged(PARAMETERS, made_up)
            assert claim.verdict == verdict and said in claim.measured
            assert "the runs are synthetic" in claim.causes[0]
