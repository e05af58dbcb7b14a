"""The stage's questions: each answers what the model says, in words and as plain values, or refuses in a sentence."""

import dataclasses
import json
from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest

from stages.analytic.derivatives.numbers import sensitive_names
from stages.analytic.design.search import TARGETS
from stages.analytic.errors import NoGait
from stages.analytic.gait.continuation import TURNING_POINT, Branch, BranchPoint
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.parameters import DesignDigits, Parameters, Settings, SlopeDigits
from stages.analytic.questions import basin, continue_gait, gait, sensitivity
from stages.analytic.walk.on_a_ramp import DOES_NOT
from stages.biped.quantity import faults
from stages.biped.question import WrongOption, elasticity, interval
from stages.model_error.questions import design
from tests.analytic.designs import FRICTION, RUBBER, SLOPE, TABLE_1
from tests.asking import Asking

SETTINGS = Settings(tolerance=1e-10, steps=2, sampling_rate_hz=100.0)
PARAMETERS = Parameters(TABLE_1, SLOPE, FRICTION, RUBBER, SETTINGS)
OF_DESIGN = SimpleNamespace(biped=TABLE_1, slope=SLOPE, friction=FRICTION, analytic=SETTINGS)


def answered(question, **options):
    """The answer, which must be plain, and what was said on the way."""
    asking = Asking()
    given = question.Options(**options)
    assert not list(faults(given))
    answer = question.ask(OF_DESIGN if question is design else PARAMETERS, given, asking)
    json.dumps(answer.plain)
    return answer, asking


@pytest.fixture(scope="module")
def found():
    return find_gait(TABLE_1, SLOPE, 1e-10)


@pytest.mark.parametrize(("law", "there_is"), [("stribeck", 1.1), ("coulomb", 1.1), ("none", 0.0)])
def test_a_gait_is_judged_by_the_friction_that_the_law_of_the_ground_has(law, there_is):
    ground = dataclasses.replace(FRICTION, friction=law)
    given = gait.ask(dataclasses.replace(PARAMETERS, friction=ground), gait.Options(), Asking()).plain
    assert given["validity"]["friction_there_is"] == there_is
    assert (given["on_a_ramp"]["verdict"] == DOES_NOT) == (there_is == 0.0)


def test_elasticities_are_by_the_coefficients_that_the_law_has():
    for law, names in (("stribeck", {"static_friction", "dynamic_friction"}), ("coulomb", {"static_friction"}),
                       ("none", set())):  # fmt: skip
        found = sensitive_names(DesignPoint(TABLE_1, SLOPE, dataclasses.replace(FRICTION, friction=law)))
        assert {name.partition(".")[2] for name in found if "friction" in name} == names


def test_gait_tells_the_gait_of_the_search(found):
    walker, point = found
    answer, _ = answered(gait)
    assert answer.plain["period_s"] == pytest.approx(point.steps[0].period * walker.time, rel=1e-12)
    assert answer.plain["stable"] and {"energy", "validity"} <= set(answer.plain)
    assert any(line.startswith("duration of one step") and line.endswith(" s") for line in answer.lines)


def test_all_gaits_hold_the_most_stable_one_and_an_unstable_one():
    answer, _ = answered(gait, every=True)
    stable, *others = answer.plain["gaits"]
    assert stable == answered(gait)[0].plain
    assert others and not others[-1]["stable"] and answer.plain["cycle"] is None
    assert answer.lines[0] == f"gait 1 of {1 + len(others)}, stable"


def test_continue_follows_the_gait_to_both_limits_and_says_how_far_it_is(found):
    answer, asking = answered(continue_gait, parameter="ground.slope_deg", limits=(1.9, 2.1))
    values = [point["value"] for point in answer.plain["branches"][0]["points"]]
    assert (values[0], values[-1]) == pytest.approx((1.9, 2.1)) and values == sorted(values)
    here = next(point for point in answer.plain["branches"][0]["points"] if point["value"] == 2.0)
    assert here["section"] == pytest.approx(found[1].z.tolist(), abs=1e-8)
    assert asking.fractions and all(0 < fraction <= 1 for fraction in asking.fractions)


@pytest.mark.parametrize(("heavier", "parameter", "limits", "steps"), [
    (0.0, "ground.slope_deg", (1.99, 2.01), 1),
    (1e-4, "ground.slope_deg", (1.99, 2.01), 2),
    (0.0, "biped.other_foot_mass", (0.335, 0.3351), 2)])
def test_a_familys_period_over_its_steps_is_that_of_a_step(heavier, parameter, limits, steps, found, monkeypatch):
    """Of legs that differ it said a cycle of 1, beside the duration of two steps; of legs that are alike at the limit
    too, where the gait stood twice, and nothing was drawn.
    """
    other = dataclasses.replace(TABLE_1, other_foot_mass=TABLE_1.foot_mass * (1.0 + heavier))
    monkeypatch.setitem(globals(), "PARAMETERS", dataclasses.replace(PARAMETERS, biped=other))
    answer, _ = answered(continue_gait, parameter=parameter, limits=limits)
    period, drawn = found[1].period * found[0].time, []
    answer.draw(drawn.append)
    values = [row["value"] for row in answer.rows]
    assert drawn and sorted(set(values)) == values
    assert answer.lines[0].startswith(f"cycle of {steps}: ") and {row["cycle"] for row in answer.rows} == {steps}
    for branch in answer.plain["branches"]:
        assert all(point["period_s"] / branch["cycle"] == pytest.approx(period, rel=2e-3) for point in branch["points"])


@pytest.mark.parametrize(
    ("question", "options", "words"),
    [
        (continue_gait, {"parameter": "ground.slope", "limits": (1.0, 3.0)},
         "ground.slope: not a number of the design; known are biped.hip_mass"),
        (continue_gait, {"parameter": "ground.slope_deg", "limits": (3.0, 4.0)},
         "LIMITS 3:4 do not hold the design's ground.slope_deg = 2"),
        (continue_gait, {"parameter": "biped.hip_mass", "limits": (-1.0, 1.0)},
         "LIMITS: biped.hip_mass = -1 is not allowed; allowed is >= 0"),
        (design, {"vary": ("biped.legs",)}, "biped.legs: not a number of the design"),
        (design, {"vary": ("biped.hip_mass=-1:1",)}, "--vary biped.hip_mass: -1 is not allowed; allowed is >= 0"),
        (design, {"vary": ("biped.hip_mass=1",)}, "--vary biped.hip_mass: '1' is not two numbers LOW:HIGH"),
        (design, {"vary": ("biped.leg_inertia",)},
         "its value is 0, so its range needs bounds, as biped.leg_inertia=0:0.001"),
        (design, {"vary": ("biped.hip_friction=0:1",)}, "this gait has no such number; it has biped.hip_mass"),
        (design, {"target": ("speed_m_s=-1",)}, "--target 'speed_m_s=-1' is not MEASURE=VALUE with a positive value"),
        (design, {"target": ("pace=1",)}, "measures are multiplier, friction, scuff, speed, step_length"),
        (sensitivity, {"parameters": ("ground.static_friction",)},
         r"ground\.static_friction: this gait has no such number; it has biped\.hip_mass"),
    ],
)
def test_what_cannot_be_followed_searched_or_differentiated_is_refused(question, options, words):
    with pytest.raises(WrongOption, match=words):
        answered(question, **options)


def test_a_special_point_of_a_family_is_neither_stable_nor_unstable():
    """A multiplier there is on the unit circle, inside or outside of it by round-off."""
    answer, _ = answered(continue_gait, parameter="ground.slope_deg", limits=(1.0, 2.2))
    (branch,) = answer.plain["branches"]
    assert branch["special"] and {point["stable"] for point in branch["special"]} == {None}
    for point in branch["special"]:
        assert abs(np.abs([complex(*value) for value in point["floquet_multipliers"]]) - 1.0).min() < 1e-6
    assert {point["stable"] for point in branch["points"]} <= {True, False}


def test_a_family_reaches_as_far_as_its_turning_points():
    """It was said to reach as far as the last gait before them."""
    points = [BranchPoint(value, np.zeros(1), np.zeros(1), 1.0, np.zeros(2)) for value in (1.0, 2.0, 1.5, 2.1)]
    branch = Branch("ground.slope_deg", 1, 1, tuple(points[:3]), ((TURNING_POINT, points[3]),), "here")
    assert next(continue_gait.branch_lines(branch)).startswith("cycle of 1: ground.slope_deg 1 to 2.1, 3 gaits, ")


def test_basin_counts_the_starts_that_reach_the_gait(found):
    walker, point = found
    angle, rate = -point.z[0], point.z[3] / walker.time
    answer, asking = answered(basin, angle=(angle, 1.2 * angle), rate=(0.1, rate), points=2)
    reached = np.array(answer.plain["gait_reached"])
    assert reached[0, 1] == 0, "the gait itself"
    assert answer.plain["share_reached"] == (reached == 0).mean()
    assert f"2 x 2 starts: {100 * (reached == 0).mean():.2f} % reach the gait" in answer.lines[0]
    assert asking.fractions[-1] == 1.0
    ends = Counter(row["ending"] for row in answer.rows)
    said = [line.split("%  ") for line in answer.lines[2:]]  # of the others, and of those that there are
    assert {words: float(share) for share, words in said} == pytest.approx(
        {words: 100 * count / 4 for words, count in ends.items() if words != answer.plain["endings"][0]})


def test_beside_an_unstable_gait_there_is_a_stable_cycle_and_no_basin():
    """At 4.8 degrees a start near the gait walks on in a cycle of two; a walk that passes by it does not reach it."""
    steep = dataclasses.replace(PARAMETERS, slope=dataclasses.replace(PARAMETERS.slope, slope_deg=4.8))
    said = gait.ask(steep, gait.Options(), Asking()).plain["on_a_ramp"]["because"]
    assert said[0] == "a step enlarges what disturbs it; there is a stable cycle of 2 steps"
    with pytest.raises(NoGait, match="the gait is unstable: no start stays with it"):
        basin.ask(steep, basin.Options(points=2, steps=1), Asking())


def test_the_rates_of_a_basin_follow_the_pace_of_the_robot():
    """A robot on the moon steps 2.5 times as slowly; rates of Table 1's would begin near where its own end."""
    on_the_moon = dataclasses.replace(PARAMETERS, slope=dataclasses.replace(PARAMETERS.slope, gravity=1.62))
    found = basin.ask(on_the_moon, basin.Options(points=2, steps=1), Asking()).plain
    pace = (1.62 / 9.81) ** 0.5
    assert found["stance_rate_rad_s"] == pytest.approx([0.5 * pace, 6.0 * pace])


def test_design_leaves_the_parameters_of_the_best_gait_it_found():
    """Also details that the design has not: a mass beside the leg's line."""
    units = {"biped.foot_com": "m", "biped.damping": "N s/m", "biped.foot_offset": "m"}
    answer, asking = answered(design, iterations=2, vary=(
        "biped.foot_com", "biped.damping=50:60", "biped.foot_offset=-0.001:0.001"))  # fmt: skip
    told, best = answer.plain["largest_multiplier"], answer.plain["parameters"]
    assert told["best"] < told["start"] and len(asking.said) == answer.plain["iterations"] > 0
    assert asking.said[-1].split(":")[1] == f" largest multiplier {told['best']:.6g}", "without the unit 1"
    assert best["biped.foot_com"]["bounds"] == pytest.approx([0.08, 0.12])
    assert best["biped.damping"]["bounds"] == [50, 60]
    assert best["biped.foot_offset"]["best"] < 0
    assert answer.parameters == {name: {"value": best[name]["best"], "unit": unit} for name, unit in units.items()}


def test_design_says_where_it_ended_and_what_its_gait_asks_of_the_ground():
    answer, _ = answered(design, vary=("biped.foot_radius",), goal="speed", maximise=True, starts=2)
    assert answer.plain["ending"] == "bound" and answer.plain["parameters"]["biped.foot_radius"]["at_bound"] == "upper"
    assert len(answer.plain["starts"]) == 2
    assert 0 < answer.plain["ground"]["friction_single_stance"] < answer.plain["ground"]["friction_there_is"]
    assert any("biped.foot_radius (upper)" in line for line in answer.lines)


def test_design_holds_a_multiplier_and_measures_by_either_name():
    answer, _ = answered(design, goal="speed", maximise=True, vary=("biped.foot_com", "biped.foot_radius"),
                         target=("multiplier=0.6",))
    assert not answer.no and answer.plain["targets"] == {"multiplier": 0.6}
    assert answer.plain["largest_multiplier"]["best"] == pytest.approx(0.6, rel=1e-6)
    assert answer.plain["goal"]["best"] > answer.plain["goal"]["start"]
    assert design.target_of("speed=0.3", TARGETS) == design.target_of("speed_m_s=0.3", TARGETS) == (
        "speed_m_s", (0.3, 0.3))
    assert design.target_of("scuff=0:0.004", TARGETS) == ("scuff", (0.0, 0.004))


def test_design_says_no_where_a_target_is_missed():
    answer, _ = answered(design, vary=("biped.foot_com",), target=("speed_m_s=0.9",), iterations=4)
    reached = answer.plain["measures"]["speed_m_s"]
    assert answer.no and not answer.plain["met"] and not answer.plain["converged"] and reached < 0.5
    assert f"misses speed_m_s by {100 * (1 - reached / 0.9):.3g} %" in " ".join(answer.lines)
    assert "optimum" not in " ".join(answer.lines)


def test_sensitivity_tells_elasticities_and_derivatives_that_agree():
    answer, _ = answered(sensitivity)
    measures, entries = answer.plain["gait"], answer.plain["parameters"]
    assert next(iter(entries)) == "biped.hip_mass" and list(entries)[-1] == "ground.gravity"
    assert answer.plain["left_by_dimensions"] < 1e-8 and answer.plain["refused"] == []
    entry = entries["biped.foot_com"]
    for name, share in entry["elasticities"].items():
        if name != "multipliers":
            assert share == pytest.approx(entry["derivatives"][name] * entry["value"] / measures[name], rel=1e-12)
    for share, derivative, multiplier in zip(
            entry["elasticities"]["multipliers"], entry["derivatives"]["multipliers"], answer.plain["multipliers"]):
        assert share == pytest.approx(derivative[0] * entry["value"] / multiplier[0], rel=1e-12)
    assert entries["biped.leg_inertia"]["elasticities"] is None
    assert entries["biped.leg_inertia"]["derivatives"]["step_frequency_hz"] < -100
    assert max(map(len, answer.lines)) <= 80 and answer.plain["uncertainties"] == []
    lines = [line.split() for line in answer.lines]  # in words the same numbers
    assert [float(lines[0][at]) for at in (1, 5, 7)] == pytest.approx(
        [measures[name] for name in ("step_frequency_hz", "step_length_m", "speed_m_s")], rel=1e-4)
    printed = next(line[1:] for line in lines if line[:1] == ["biped.foot_com"])
    of_gait = [entry["elasticities"][name] for name in sensitivity.HEADS]
    assert [float(one) for one in printed] == pytest.approx([*of_gait, *entry["elasticities"]["multipliers"]], abs=6e-5)
    zero = next(at for at, line in enumerate(answer.lines) if line.startswith("biped.leg_inertia is 0;"))
    slopes = entries["biped.leg_inertia"]["derivatives"]
    for name, slope, _ in lines[zero + 1 : zero + len(slopes)]:
        assert float(slope) == pytest.approx(slopes[name], rel=1e-3)


@pytest.mark.parametrize(("mass", "steps", "head"), [(None, 1, "leading multipliers: "), (
    1.04 * TABLE_1.foot_mass, 2, "leading multipliers of two steps: ")])
def test_sensitivity_says_of_how_many_steps_its_multipliers_are(mass, steps, head):
    biped = dataclasses.replace(TABLE_1, other_foot_mass=mass)
    answer = sensitivity.ask(dataclasses.replace(PARAMETERS, biped=biped), sensitivity.Options(("biped.hip_mass",)),
                             Asking())
    assert answer.lines[1].startswith(head) and answer.plain["multiplier_steps"] == steps


def test_sensitivity_tells_which_digit_decides():
    design = DesignDigits({"foot_com": 5e-4, "leg_length": 5e-4, "hip_friction": 0.002})
    slope = SlopeDigits({"slope_deg": 0.5})
    rounded = dataclasses.replace(PARAMETERS, design_digits=design, slope_digits=slope)
    answer = sensitivity.ask(rounded, sensitivity.Options(), Asking())
    own = next(one for one in answer.plain["uncertainties"] if one["name"] == "step_frequency_hz")
    by = {name: abs(entry["derivatives"]["step_frequency_hz"]) for name, entry in answer.plain["parameters"].items()}
    assert own["decisive"] == "biped.foot_com" and own["decisive_part"] == pytest.approx(5e-4 * by["biped.foot_com"])
    assert own["worst"] == pytest.approx(5e-4 * (by["biped.foot_com"] + by["biped.leg_length"]))
    assert own["slope_least"] < own["value"] - 0.02
    assert max(map(len, answer.lines)) <= 80
    assert any(line.startswith("step_frequency_hz") and "  foot_com  " in line for line in answer.lines)
    assert answer.lines[-1] == "biped.hip_friction: +- 0.002 not counted, as there is no derivative by it at 0"


def test_sensitivity_carries_and_shows_only_what_is_asked_for_and_draws_it(tmp_path):
    answer, _ = answered(sensitivity, parameters=("ground.slope_deg", "biped.hip_mass"))
    assert list(answer.plain["parameters"]) == ["ground.slope_deg", "biped.hip_mass"]
    assert answer.plain["left_by_dimensions"] is None
    drawn = []
    answer.draw(drawn.append)
    axes = drawn[0].axes
    assert [label.get_text() for label in axes[0].get_yticklabels()] == ["slope", "hip mass"]
    widths = [bar.get_width() for bar in axes[0].patches]
    expected = [entry["elasticities"]["step_frequency_hz"] for entry in answer.plain["parameters"].values()]
    assert widths == pytest.approx(expected) and len(axes) == 3 + 2


@pytest.mark.parametrize("text", ["1", "1:", "2:1", "1:1", "nan:2", "1:inf", "a:b", "1:2:3"])
def test_an_interval_is_two_finite_numbers_in_order(text):
    with pytest.raises(WrongOption, match="is not two numbers LOW:HIGH with LOW < HIGH"):
        interval(text, "--range")
    assert interval("-1e-3:2", "--range") == (-0.001, 2.0)


def test_columns_of_elasticities_stay_apart():
    """By -139 % for 1 % of a leg's length, as multipliers of two legs that differ: numbers ran together."""
    row = "".join(elasticity(value, 8) for value in (0.0747, -139.1513, -13915.13, 10.5, float("nan")))
    assert row.split() == ["+0.0747", "-139.15", "-13915", "+10.5", "-"]
