"""Every claim must be able to hold, to fail, and not to apply, each for a reason of its own."""

import dataclasses
import re
from math import inf, nan
from types import SimpleNamespace

import pytest
import yaml

from pipeline.commands import claims as shown
from stages.comparison.claims import judge, numerics
from stages.comparison.claims.judge import judged
from stages.comparison.claims.paper import BIPED, SETTINGS
from stages.comparison.determinants import Determinants
from stages.comparison.evidence import Evidence, Inputs
from stages.comparison.result import DOES_NOT_APPLY, FAILS, HOLDS, HOLDS_IF, OPEN, VERDICTS, BipedSummary, counted
from stages.comparison.run import as_yaml, headlines
from stages.tradeoff import constraint_ways, penalty_ways
from tests.changed import changed
from tests.study import parameters_of

#: At the level of which no numerical error is known.
PARAMETERS = parameters_of("comparison", "accuracy.level=reference")
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
    (given("rolling_without_slip", 1.1, 0.19, 0.9, 0.4, 0.0, 0.0, 0.0), {"trailing": 24.0, "time_outside": 0.2}),
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
    (given("push_slows", "measured", 30, 30, -0.6, 0.36, 0.36), {"correlation": 0.1}),
    (
        given("prototype_is_model", "measured", 2, (("hip_mass", 0.31, 0.32, 0.316, "kg"),), -1),
        {"intervals": (("hip_mass", 0.33, 0.34, 0.316, "kg"),)},
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
    (CASES[25][0], {"correlation": nan, "pushed": 0}, "holds no pushes"),
    (CASES[26][0], {"intervals": ()}, "must be estimated"),
    (CASES[26][0], {"intervals": (("hip_mass", 0.2, 0.5, 0.316, "kg"),)}, "too wide to decide: hip_mass"),
    (CASES[24][0], {"slower_half": 4e-3}, "the calibrated interval of the change holds zero"),
]
#: For a claim of `CASES` what its numbers are changed to, and words of each cause that is then true, in their order.
NAMED = [
    (0, {}, "8.3 times the work | 100 times k_c takes 2.8 times"), (0, {"stiffer": 1.0}, "8.3 times the work"),
    (0, {"penalty": 600.0}, "only 1.00 times"), (0, {"penalty": nan}, "reached this error"),
    (0, {"error": nan}, "has no walk"),
    (1, {}, "more than 1e-06"), (1, {"slip": 0.0, "descent": 0.0}, "more than 1e-06"),
    (1, {"drift": 9e-7, "slip": 0.0}, "leaves a drift of 9.0e-07"),
    (1, {"drift": 9e-7, "descent": 0.0}, "leaves a drift"), (1, CASES[1][1], "without slip and descent"),
    (2, {}, "lowers it by 1 %"), (2, {"best": 0.597}, "lowers it by 1 %"), (2, {"best": 0.5}, "lowers it by 16.7 %"),
    (2, {"best": nan}, "no neighbouring"), (2, {"now": 1.2}, "one has 1.20"), (2, {"now": 1.0}, "one has 1.00"),
    (2, {"now": 1.2, "best": nan}, "one has 1.20"), (2, {"now": 1.2, "best": 1.3}, "one has 1.20"),
    (3, {}, "shrinks to 0.64"), (3, {"multibody": nan}, "no multipliers"), (3, {"constraint": nan}, "no multipliers"),
    (3, {"constraint": 1.02, "multibody": nan}, "grows 1.02 times"), (3, {"constraint": 1.02}, "grows 1.02 times"),
    (4, {}, "2.0 times larger"), (4, {"error": nan}, "one tolerance"), (4, {"error": 1e-13}, "falls to the tightest"),
    (4, {"error": 1e-12, "doubt": 1e-12}, "stays below 1e-12 m: the reference is known no better"),
    (5, {}, "by 1.10 in the long run"), (5, {"left": 1.0}, "the gait is stable | enlarge a difference, 4 times"),
    (5, {"left": 0.02, "most": 1.0}, "leaves 1.10 of a difference"),
    (6, {}, "lowers it to 40 % | bounces"), (6, {"beyond": 0.124}, "lowers it to 40 %"),
    (6, {"factor": 2.0}, "to 40 % | bounces"),
    (6, {"factor": 0.4}, "to 40 % | no smaller | at 100 times k_c it is 3.70"),
    (6, {"best": 0.124}, "bounces | no k_c"), (6, {"default": nan}, "no step"),
    (7, {}, "inside figure 8's 0.3 mm"), (7, CASES[7][1], "at 4.0 mm/s whatever | v_s = 50 mm/s | is 7.7 times"),
    (7, {"least": 2.3e-3, "creep_moves": 2e-4}, "to 0.45 mm | is 7.7 times"),
    (7, {"least": 4e-4}, "1.90 mm a step | is 1.3 times"),
    (8, {}, "at most at 0.90"), (8, {"trailing": 24.0}, "21.8 times the friction | with 17 % of the cone"),
    (8, {"trailing": inf}, "pull the trailing foot | does roll"), (8, {"landing": 2.0}, "the landing foot | does roll"),
    (8, {"slid": 8.8e-6}, "trailing foot slides: friction takes 8.8e-06 J of a step | does roll"),
    (8, {"time_outside": 0.2}, "towards toe-off | does roll"), (8, {"single": 1.2}, "single stance needs 1.20"),
    (9, {}, "up to a factor of 2 reaches 1 %"), (9, {"turning": 2.0}, "up to a factor"),
    (9, {"halved": nan}, "no change"), (9, {"turning": 1.9}, "4.0 mm/s"),
    (9, {"turning": 1.1}, "of 1.10 on the stiction velocity is a small"), (9, {"doubled": nan}, "no change"),
    (9, {"halved": nan, "doubled": nan}, "no walk"),
    (10, {}, "for the constraint model and the penalty model"),
    (10, {"constraint_explicit": nan}, "for the penalty model"),
    (10, {"penalty_stiff": 6e3}, "penalty model 1/1.2 of the work | takes no more for the constraint model"),
    (11, {}, "at most 0.29 mm | tends to that limit: 0.240 mm | act against each other at the step's end: creep -0.50"),
    (11, {"hardest": 2.4e-4, "step": 5e-4}, "at most 0.29 mm"), (11, {"parts": ()}, "at most 0.29 | tends"),
    (11, {"parts": (("slip", 1e-4, 0.0),)}, "at most | tends"),
    (11, {"limit_cycle": 4.6e-4, "parts": ()}, "later | tends"),
    (11, {"limit_step": 4e-4, "parts": ()}, "alone makes 0.40 mm | 0.020 mm with 0.1"),
    (12, {}, "by 3.4 mm/s at most"), (12, {"impact": 6e-3}, "at most | 6 mm/s off"),
    (12, {"limit_step": 6e-3}, "makes 6.0"), (12, {"limit_step": nan}, "no gait"),
    (13, {}, "outweighs the 1e-02 mm"),
    (13, {"integration": 1e-5}, "2e+01 times smaller | creep -0.50 ± 0.02 mm, finite"),
    (13, {"integration": 1e-5, "parts": (("slip", -2e-5, 0.0), ("creep", 9e-6, 0.0))}, "times smaller | slip -0.02 mm"),
    (13, {"integration": 0.0, "parts": ()}, "inf times smaller"),
    (14, {}, "is +1.2 % longer | leaves 0.77 | 1 of the first"),
    (14, {"first": 0.4901, "steps": 0}, "leaves 0.77 | 0 of the"), (14, {"multiplier": 1.1}, "longer | 1 of the first"),
    (14, {"steps": -1}, "still change"),
    (14, {"steps": -1, "multiplier": 1.1}, "still change | multiplies a difference by 1.10"),
    (15, {}, "0.31 m to spare | up to 40 mm from its middle, the feet need 24 mm"),
    (15, {"reach": 0.041}, "ends 40 mm"), (15, {"reach": 0.041, "needed": 2.08}, "0.08 m are missing"),
    (15, {"reach": nan}, "fewer steps"), (15, {"reach": nan, "needed": 2.08}, "0.08 m are missing"),
    (16, {}, "highest blocks | both models agree"), (16, {"other_low": 0.98}, "highest blocks | do not meet"),
    (16, {"other_high": 0.92}, "highest blocks | do not meet"),
    (16, {"highest": 1e-3}, "how even | both models agree"),
    (16, {"chance": 0.8, "lost": 7e-4}, "fall more often | good to 0.7 mm half | both models agree"),
    (17, {}, "leaves 0.77 of it | leaves 0.9900 of a turn | no push"),
    (17, {"sideways": 0.9}, "in the plane | no push"), (17, {"multiplier": 1.0}, "heading | no push"),
    (17, {"limits_of": FALLS}, "in the plane | larger pushes | heading"),
    (17, {"failed": 3, "limits_of": FALLS}, "heading | 3 of 33"),
    (17, {"pushes": 0}, "heading | no synthetic campaign"),
    (17, {"limits_of": (("speed", "m/s", 0.0, 0.1),)}, "in the plane | heading | even the smallest"),
    (18, {}, "0.0082 Hz left are less than 0.012 Hz | needs 0.0032 Hz of these | 2.0470 and 2.0750"),
    (18, {"part": 1e-3, "slopes": (2.05, 2.05)}, "0.0082 Hz left | foot_com has most, 0.0010 Hz"),
    (18, {"frequency": 2.087, "part": 3e-3}, "0.0070 Hz | foot_com decides: it alone contributes 0.0030 Hz | slopes"),
    (18, {"frequency": 2.079}, "0.0010 Hz left | on slopes"),
    (18, {"frequency": 2.065}, "on slopes | 0.0150 Hz is within 1 %, though more than 0.012 Hz"),
    (18, {"frequency": 2.2}, "on slopes | 0.1200 Hz is more than 1 % | uncertain by 0.0118 Hz"),
    (18, {"frequency": 2.2, "rounding": 0.2}, "on slopes | 0.1200 Hz is more than 1 %"),
    (19, {}, "no more than 3.5 g and 169 deg/s"), (19, {"rate": 2100.0}, "2100 deg/s is beyond"),
    (19, {"above": 2e-3}, "in 99.6 % | 15 to 160 g at the hip over its family, for 1.5 | it is 2.4 g at the hip"),
    (19, {"above": 2e-3, "spread": (15.0, 30.0), "filtered": 4.1}, "in 99.6 % of a step"),
    (19, {"above": 0.02}, "how high | low pass | 20.0 ms a step are more than the 1 %"),
    (19, {"above": 0.02, "rate": 2100.0}, "how high | low pass | 2100 deg/s is beyond"),
    (20, {}, "none is above 0.05 | inertia +26.0 ms, leg -18.0 ms, together +8.0 ms"),
    (20, {"assumed": True, "rate": 0.2}, "0.20 is above 0.05 | gives no parts | act against each other"),
    *((20, {"details": (("inertia", 0.026), ("leg", leg))}, "none is above") for leg in (-0.0047, 0.018)),
    (20, {"details": (("inertia", 0.026), ("leg", -6e-3))}, "none is above | together +20.0 ms"),
    (21, {"twice": 0.0165}, "too small"),
    (21, {}, "grows with the square | nor does one"), (21, {"once": 0.01}, "grows with the square | is not needed"),
    *((21, {"twice": 1e-3, "once": once}, "too small to matter") for once in (5e-3, 0.02)),
    *((21, {key: nan}, "only runs whose truth") for key in ("twice", "once")),
    (22, {}, "at least 97 %"), (22, {"shares": (1.0, 1.0, 0.94)}, "outside for 6 %"),
    *((22, {"origin": "synthetic", "shares": (share,) * 3}, "cannot confirm a model") for share in (0.5, 1.0)),
    (23, {}, "-110.0 to -90.0 mHz"), (23, CASES[23][1], "quicker: +100.0 to +200.0 mHz"),
    *((23, {"upper": 0.01, "frequency": one}, "holds zero: -110.0 to +10.0") for one in (1.9, 2.1)),
    *((23, {"origin": "synthetic", **other}, "cannot confirm") for other in ({}, CASES[23][1], {"upper": 0.01})),
    (24, {}, "the slower pendulum"), (24, {"pairs": 0, "slower_half": 4e-3}, "the slower pendulum"),
    (24, {"slower_half": 4e-3}, "holds zero"),
    (24, {"origin": "synthetic"}, "the runs are synthetic | slower pendulum"),
    (24, {"really": -2.5e-3}, "really differ by -0.25 % | slower pendulum"),
    (24, {"pairs": 0, "really": -2.5e-3, "origin": "synthetic"}, "slower pendulum"),
    *((24, {"slower": 3e-3, "with_mass": mass}, "step quicker with it, by +0.30 %") for mass in (-3e-3, 1e-3)),
    (24, CASES[24][1], "step quicker | length alone quickens | does not outweigh"),
    (24, {"length_alone": 1e-3, "slower": 3e-3}, "step quicker | length alone quickens"),
    (24, {"length_alone": 0.0, "with_mass": 0.0}, "length alone quickens | does not outweigh"),
    (24, {"length_alone": 1e-3}, "length alone quickens | mass alone: -0.40 %"),
    (24, {"length_alone": 1e-3, "with_mass": nan}, "length alone quickens | was not computed"),
    (24, {"length_alone": nan}, "no gait was found"),
    (25, {}, "explain 36 %"), (25, {"correlation": 0.36}, "0.36 is no more than chance gives 30 runs"),
    (25, {"correlation": nan, "pushed": 0}, "no pushes"),
    (25, {"origin": "synthetic", "correlation": nan}, "cannot confirm"),
    (25, {"origin": "synthetic"}, "cannot confirm | does go with"),
    (25, {"origin": "synthetic", "correlation": 0.1}, "cannot confirm | no more than chance"),
    (26, {"held": 0}, "every interval | 0 of 1 intervals"), (26, {"intervals": ()}, "fits many sets"),
    (26, {"origin": "synthetic", **CASES[26][1]}, "the runs are synthetic | outside for hip_mass"),
    (26, {"intervals": (("hip_mass", 0.29, 0.345, 0.316, "kg"),)}, "every interval"),
    (26, {"intervals": (("hip_mass", 0.29, 0.35, 0.316, "kg"),)}, "too wide to decide: hip_mass"),
    (26, {"intervals": (("hip_mass", 0.2, 0.5, 0.316, "kg"), ("foot_mass", 0.3, 0.32, 0.335, "kg"))},
     "outside for foot_mass"),
]  # fmt: skip


def names(cases):
    return [case[0].about.id for case in cases]


def of(measured, **changes):
    return dataclasses.replace(measured, numbers={**measured.numbers, **changes})


def reason(claim):
    """The causes without their numbers."""
    return re.sub(r"[-+]?\d[\d.e+-]*", "#", " ".join(claim.causes))


def test_a_claim_without_the_results_it_is_judged_by_says_which_one_is_missing():
    names = {field.name for field in dataclasses.fields(Inputs)} - {"missing", "closer"}
    nothing = Inputs(**dict.fromkeys(names), missing={name: f"no {name}" for name in names})
    for one in judge.STATEMENTS.values():
        found = one.measured(Evidence(PARAMETERS, nothing))
        assert not found.numbers and found.why in nothing.missing.values()


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


@pytest.mark.parametrize(("changes", "words"), [
    pytest.param({"trailing": inf}, "pull the trailing foot", id="would have to pull"),
    pytest.param({"landing": 2.0}, "on the landing", id="landing"),
    pytest.param({"friction": 0.0, "trailing": 24.0}, "the ground has no friction", id="none")])
def test_friction_that_the_ground_has_not_is_not_told_without_a_number(changes, words):
    """Under friction: none the stage ended with a division by zero."""
    claim = judged(PARAMETERS, of(ROLLING, **changes))
    said = " ".join([claim.measured, *claim.causes])
    assert claim.verdict == FAILS and words in said and not re.search(r"\binf\b|needs at the trailing foot", said)


@pytest.mark.parametrize(("holding", "change", "words"), UNDECIDED, ids=names(UNDECIDED))
def test_what_cannot_be_decided_stays_open_with_a_reason(holding, change, words):
    claim = judged(PARAMETERS, of(holding, **change))
    assert claim.verdict == OPEN and words in " ".join(claim.causes)
    assert not re.search(r"\bnan\b", " ".join([claim.measured, *claim.causes]))


def test_only_a_verdict_with_a_condition_has_one():
    for holding, change in [*CASES, *((case[0], case[1]) for case in [*CONDITIONS, *UNDECIDED]),
                            *((CASES[place][0], changes) for place, changes, _ in NAMED)]:
        claim = judged(PARAMETERS, of(holding, **change))
        assert bool(claim.condition) == (claim.verdict == HOLDS_IF)


def test_the_causes_named_are_those_that_are_true():
    """At limits too, and where a claim is not decided: no cause beside those, and each with its numbers."""
    for place, changes, words in NAMED:
        causes, expected = judged(PARAMETERS, of(CASES[place][0], **changes)).causes, words.split(" | ")
        assert len(causes) == len(expected), (place, changes, causes)
        for cause, said in zip(causes, expected, strict=True):
            assert said in cause, (place, changes)


@pytest.mark.parametrize(("place", "changes", "said"), [
    (0, {}, "at a hip error of 1e-07 m a step takes 600 evaluations with constraints, 5000"), (3, {}, "0.6400 in"),
    (4, {}, "grow 4.5 times; the last tightening takes the hip's error from 1.0e-12 to 2.0e-12 m"),
    (9, {}, "by up to +0.2 % at half and -0.3 % at twice the"), (9, {"turning": 1.4}, "1 % at a factor of 1.4"),
    (12, {}, "in the limit 2.7 mm/s over one step and 3.4 mm/s over a settled stride; with ground.yaml's set 3.9 mm/s"),
    (13, {}, "integration moves the hip by 1e-01 mm of 0.20 mm over one step; other effects explain 90 %"),
    (15, {}, "11 sets 161.0 mm apart need 1.69 m; on them the twin's feet roll over 42 mm and come no farther than 24"),
    (15, {"reach": nan, "rolls": nan}, "11 sets 161.0 mm apart need 1.69 m; the twin walks over fewer"),
    (18, {}, "2.0718 Hz, -0.39 %"), (19, {"above": 2e-3}, "2.0 ms a step (0.4 %) lie above 4 g, with peaks of 3 g"),
    (21, {}, "200.00 mm off after 1.70 m (12 %); one of the rate, with the foot that rolls, has errors of 2.00 %"),
    (21, {}, "Their steps are 160.00 mm long, each with a standard error of 1.00 mm, the twin's 161.00 mm, the"),
    (23, {}, "1.9000 Hz, twin 2.0000 Hz over the same steps, -5.00 %"), (25, {}, "pushes explain 36 % of its variance"),
    (25, {"correlation": nan, "pushed": 0}, "the pushes of the measured runs are not known"),
    (25, {"correlation": nan, "runs": 2, "pushed": 2, "origin": "synthetic"}, "2 synthetic runs are too few to"),
    (25, {"correlation": nan, "origin": "synthetic"}, "the synthetic runs do not differ in push, or not in frequency"),
    (24, {}, "2.0 mm of outsole without mass change the step frequency by -0.10 %, by -0.30 % with the 10.0 g of"),
    (24, {}, "the leg is 2.00 ± 0.40 mm longer and the step frequency changes by -0.30 % ± 0.10 %"),
])  # fmt: skip
def test_what_is_measured_has_its_units(place, changes, said):
    assert said in judged(PARAMETERS, of(CASES[place][0], **changes)).measured


@pytest.mark.parametrize(("place", "unit"), [(17, "m/s"), (26, "kg")])
def test_numbers_in_rows_have_the_unit_of_their_row(place, unit):
    numbers = judged(PARAMETERS, CASES[place][0]).numbers
    assert {number.unit for number in numbers if "." in number.name} == {unit}


@pytest.mark.parametrize("key", BIPED)
def test_another_biped_or_slope_is_not_judged_as_the_papers(key):
    """Each of Table 1's values, legs, slope and gravity alone makes claims on that biped not apply, and is named."""
    file, name = key.split(".")
    section, printed = {"biped": "biped", "ground": "slope"}[file], BIPED[key][0]
    value = "rigid" if isinstance(printed, str) else 1.01 * printed + 1e-3
    parameters = changed(PARAMETERS, **{section: dataclasses.replace(getattr(PARAMETERS, section), **{name: value})})
    claim = judged(parameters, CASES[18][0])
    assert claim.verdict == DOES_NOT_APPLY and f"{key} is " in claim.causes[0] and BIPED[key][1] in claim.causes[0]
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
    scaled = dataclasses.replace(PARAMETERS.slope, gravity=9.81 * (1.0 - 1e-15))
    assert judge.another_biped(changed(PARAMETERS, slope=scaled)) == (), "it was 9.81 m/s^2 where the paper has 9.81"
    for words in ("ground.contact_stiffness 200000 N/mm^e", "ground.stiction_velocity 0.1 m/s",  # as the paper has it
                  "multibody.tolerance 1e-08 (paper: 1e-06, section 3.5)"):  # fmt: skip
        assert words in claim.rests_on
    other = changed(PARAMETERS, hip_mass=0.4)  # to which the parts are fitted; what follows from others is not told
    assert judge.rests_on(other, ("twin.parts", "campaign.outsole", "imu.of_a_lab")) == (
        f"twin.parts ({other.twin.bill_rule(other.biped)})", "imu.of_a_lab")
    assert judge.rests_on(PARAMETERS, ("twin.parts",)) == ("twin.parts",)


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


def test_one_claim_holds_and_two_hold():
    verdicts = [HOLDS_IF, OPEN, OPEN]
    claims = [shown.Claim("a", "1", "b", "c", "d", verdict, "", [], []) for verdict in verdicts]
    assert shown.Claims(claims).counted() == "3 claims: 1 holds on a condition, 2 are open."
    assert counted(verdicts) == "of 3 claims 1 holds on a condition, 2 stay open"


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


@pytest.mark.parametrize(("twins", "words"), [
    (0.66, "grows to 1.25 of its size with each step; the twin of it is stable, with 0.66 in the plane."),
    (1.1, "grows to 1.25 of its size with each step."), (nan, "grows to 1.25 of its size with each step.")])
def test_a_headline_does_not_call_unstable_what_the_twin_walks_without_a_word(twins, words):
    biped = dataclasses.replace(BipedSummary(*[nan] * 18), multiplier=1.25, twin_multiplier=twins)
    assert headlines(biped, {}, [])[1] == f"Its gait is unstable: a small disturbance {words}"


def test_a_headlines_per_cent_are_digits():
    frequencies = {name: Determinants(step_frequency=each) for name, each in (("one", 2.843), ("other", 3.707))}
    assert "differ by at most 30 %: one 2.843 Hz, other" in headlines(BipedSummary(*[nan] * 18), frequencies, [])[2]


def test_a_multibody_model_without_a_cycle_leaves_stability_open():
    multibody = SimpleNamespace(cycle=SimpleNamespace(largest_multiplier=nan))
    leading = CASES[3][0].numbers["constraint"]
    analytic = SimpleNamespace(gait=SimpleNamespace(largest_multiplier=leading))
    evidence = SimpleNamespace(results=SimpleNamespace(multibody=multibody, analytic=analytic))
    claim = judged(PARAMETERS, judge.STATEMENTS["stable_gait"].measured(evidence))
    assert claim.verdict == OPEN and "no multibody gait" in claim.measured


def test_an_interval_beside_table_1_decides_whatever_others_leave_open():
    wide, off = ("hip_mass", 0.2, 0.5, 0.316, "kg"), ("foot_mass", 0.2, 0.3, 0.335, "kg")
    assert judged(PARAMETERS, of(CASES[26][0], intervals=(wide, off))).verdict == FAILS
    claim = judged(PARAMETERS, of(CASES[26][0], intervals=(wide, ("foot_mass", 0.33, 0.34, 0.335, "kg"))))
    assert claim.verdict == OPEN and claim.causes[-1].endswith("too wide to decide: hip_mass")


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
