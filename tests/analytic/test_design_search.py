import dataclasses
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.derivatives.numbers import sensitive_names
from stages.analytic.design.goals import GOALS
from stages.analytic.design.search import Problem, meeting, search_design
from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_report import record_steps, report_gait
from stages.analytic.gait.gait_search import describe
from stages.analytic.gait.poincare import by_stability, fixed_point
from stages.analytic.parameters import Settings
from stages.analytic.walk.recording import in_single_stance
from stages.ground.slope import Slope
from stages.model_error.questions import design as design_question
from tests.analytic.designs import FRICTION, SLOPE, TABLE_1, found_gait, gait_beside
from tests.analytic.differences import extrapolated
from tests.analytic.test_detailed import LAME
from tests.asking import Asking

DESIGN = DesignPoint(TABLE_1, SLOPE)
TOLERANCE = 1e-8


@pytest.fixture(scope="module")
def start():
    return found_gait(TABLE_1)[1].z


def within(share, *names):
    return {name: ((1 - share) * DESIGN.value(name), (1 + share) * DESIGN.value(name)) for name in names}


def test_the_search_beats_every_design_of_a_grid(start):
    bounds = within(0.1, "biped.foot_com", "biped.damping")
    found = search_design(DESIGN, start, bounds, tolerance=TOLERANCE)[0]
    problem = Problem(DESIGN, bounds, {}, TOLERANCE)
    grid = [
        problem.candidate(np.array([x, y]), start) for x in np.linspace(0.9, 1.1, 5) for y in np.linspace(0.9, 1.1, 5)
    ]
    best = min(candidate.largest_multiplier for candidate in grid if candidate is not None)
    assert found.converged
    assert found.best.largest_multiplier <= best + 1e-6
    assert found.best.largest_multiplier < found.start.largest_multiplier - 0.01


def test_a_number_below_zero_has_a_range_and_ends_at_the_bound_that_is_said(start):
    """Its range was refused, since "its value is 0"; of its own bounds the lower one was called upper."""
    name, design = "biped.foot_offset", DESIGN.with_value("biped.foot_offset", -1e-4)
    bounds = dict([design_question.bounds_of(design, name, 0.2, [name])])
    assert bounds[name] == pytest.approx((-1.2e-4, -0.8e-4), rel=1e-12)
    (found,) = search_design(design, start, bounds, tolerance=TOLERANCE, goal="speed")
    reached = bounds[name].index(pytest.approx(found.best.design.value(name), rel=1e-9))
    assert found.bounds == {name: ("lower", "upper")[reached]} and found.gain == pytest.approx(0.0, abs=1e-12)


def test_an_optimum_inside_the_bounds_is_one(start):
    """Leg length alone: two multipliers cross inside the bounds, so the optimum is a kink."""
    bounds = within(0.05, "biped.leg_length")
    found = search_design(DESIGN, start, bounds, tolerance=TOLERANCE)[0]
    assert found.ending == "kink" and not found.bounds
    problem = Problem(DESIGN, bounds, {}, TOLERANCE)
    x = np.array([found.best.design.value("biped.leg_length") / DESIGN.value("biped.leg_length")])
    for step in (-1e-3, 1e-3):
        beside = problem.candidate(x + step, found.best.point.z)
        assert beside is None or beside.largest_multiplier >= found.best.largest_multiplier - 1e-7


@pytest.mark.parametrize(("goal", "sign", "multipliers", "meet"), [
    ("multiplier", 1, [0.6, -0.5, 0.1], False), ("multiplier", 1, [0.6, 0.59, 0.1], True),
    ("multiplier", 1, [0.6, 0.2, 0.199], False), ("multiplier", -1, [0.6, 0.59], False),
    ("speed", 1, [0.6, 0.59], False)])  # fmt: skip
def test_multipliers_that_meet_end_the_search_that_makes_the_largest_small(goal, sign, multipliers, meet):
    point = SimpleNamespace(floquet_multipliers=np.array(multipliers))
    assert meeting(SimpleNamespace(goal=GOALS[goal], sign=sign), SimpleNamespace(point=point)) == meet


@pytest.mark.parametrize(("goal", "maximise"), [("multiplier", False), ("speed", True)])
def test_limits_of_a_target_bind_only_where_the_goal_would_cross_them(start, goal, maximise):
    """The faster design stands on the upper limit of a speed, a wide limit of scuffing changes nothing."""
    bounds = within(0.15, "biped.foot_com", "biped.foot_radius")
    given = {"tolerance": TOLERANCE, "goal": goal, "maximise": maximise}
    free = search_design(DESIGN, start, bounds, **given)[0]
    scuff = GOALS["scuff"].parts(free.best.walker, free.best.point, TOLERANCE).max()
    wide = search_design(DESIGN, start, bounds, targets={"scuff": (0.0, 2 * scuff)}, **given)[0]
    assert wide.met and wide.best.value == pytest.approx(free.best.value, rel=1e-9)
    speed, own = free.best.gait.speed_m_s, free.start.gait.speed_m_s
    most = (speed + own) / 2
    limits = (0.5 * own, most) if speed > own else (most, 2 * own)
    held = search_design(DESIGN, start, bounds, targets={"speed_m_s": limits, "scuff": (0.0, 2 * scuff)}, **given)[0]
    assert held.met and held.best.gait.speed_m_s == pytest.approx(most, rel=1e-6)
    assert (held.best.value < free.best.value) == maximise
    assert held.best.held == pytest.approx([held.best.gait.speed_m_s, GOALS["scuff"].parts(
        held.best.walker, held.best.point, TOLERANCE).max()])


def test_a_target_is_missed_by_a_share_of_the_limit_that_is_crossed(start):
    """Of .1 to .3 m/s the middle is .2, of which .33 m/s is another share."""
    bounds, held = within(1e-3, "biped.foot_com"), {"speed_m_s": (0.1, 0.3)}
    searches = search_design(DESIGN, start, bounds, targets=held, tolerance=TOLERANCE)
    best = searches[0].best.gait.speed_m_s
    said = " ".join(design_question.in_words(searches, bounds, held, GOALS["multiplier"], 1, held))
    assert not searches[0].met and f"misses speed_m_s by {100 * (best / 0.3 - 1):.3g} %" in said
    assert "(target 0.1 to 0.3)" in said
    moved = design_question.in_words(searches, bounds, held, GOALS["multiplier"], 1, {"speed_m_s": (0.09, 0.29)})
    assert "(target 0.1 to 0.3, as the twin's is 0.09 to 0.29)" in " ".join(moved)


def test_where_two_multipliers_meet_nothing_is_said_to_be_left_to_gain(start):
    """Of a rigid robot's least multiplier, confirmed by a search without derivatives, "1 of the start's value" was."""
    bounds = within(1e-3, "biped.foot_com")
    search, = search_design(DESIGN, start, bounds, tolerance=TOLERANCE)
    for ending, left in (("coalescence", False), ("minimum", True)):
        ended = [dataclasses.replace(search, ending=ending)]
        said = " ".join(design_question.in_words(ended, bounds, {}, GOALS["multiplier"], 1, {}))
        assert ("Left to gain" in said) == left


@pytest.mark.parametrize("name", ["friction", "scuff"])
def test_what_the_ground_is_asked_for_is_held_at_a_value(start, name):
    bounds = within(0.15, "biped.foot_com", "biped.foot_radius")
    other = DESIGN.with_values({"biped.foot_com": 0.106, "biped.foot_radius": 0.086}).walker()
    value = GOALS[name].parts(other, fixed_point(other, start, TOLERANCE), TOLERANCE).max()
    found = search_design(DESIGN, start, bounds, targets={name: (value, value)}, tolerance=TOLERANCE)[0]
    best = found.best
    assert found.met and GOALS[name].parts(best.walker, best.point, TOLERANCE).max() == pytest.approx(value, rel=2e-6)


def test_what_the_best_is_compared_with_is_the_design_itself_whichever_start_led_there(start):
    """Cut off at once, the search that began fastest is best: not the design's own."""
    bounds = within(0.2, "biped.foot_com")
    searches = search_design(DESIGN, start, bounds, tolerance=TOLERANCE, goal="speed", maximise=True, starts=4,
                             iterations=0)  # fmt: skip
    speed = describe(*found_gait(TABLE_1)).speed_m_s
    assert sum(search.own for search in searches) == 1 and not searches[0].own
    plain = design_question.as_plain(searches, bounds, {}, GOALS["speed"])
    assert plain["goal"]["start"] == pytest.approx(speed, rel=1e-7) != searches[0].start.value
    assert plain["parameters"]["biped.foot_com"]["start"] == TABLE_1.foot_com
    first, *_ = design_question.in_words(searches, bounds, {}, GOALS["speed"], 4, {})
    assert first.startswith(f"speed {speed:.6g} -> ") and "from another start" in first


def test_a_design_without_a_gait_cannot_start_a_search():
    flat = DESIGN.with_value("ground.slope_deg", 0.0)
    with pytest.raises(ValueError, match="no gait"):
        search_design(flat, np.array([-0.2, 1.0, 1.0, 0.4, 0.0]), within(0.1, "biped.foot_com"), tolerance=TOLERANCE)


RUBBING = dataclasses.replace(TABLE_1, frame_mass=0.01, frame_com=0.02, hip_friction=2e-3)
RUBBING_LAME, RIGID = dataclasses.replace(LAME, hip_friction=1e-3), {"legs": "rigid"}
NUMBERS = ("biped.foot_radius", "biped.foot_com", "biped.leg_length", "biped.foot_mass", "ground.slope_deg")
SPRUNG = (*NUMBERS, "biped.stiffness", "biped.damping")
DETAILS = ("biped.frame_com", "biped.foot_com", "biped.hip_friction", "biped.other_foot_mass")
#: Designs of every kind, the numbers that derivatives are by, and shares and tolerance of differences by them.
WALKERS = {
    "rolling": (DESIGN, SPRUNG, 1e-3, 1e-6),
    "limited": (DesignPoint(TABLE_1, SLOPE, FRICTION), SPRUNG, 1e-3, 1e-6),
    "rigid": (DesignPoint(dataclasses.replace(TABLE_1, **RIGID), SLOPE), NUMBERS, 1e-3, 1e-6),
    **{name: (DesignPoint(biped, SLOPE), DETAILS, 4e-4, 1e-5) for name, biped in {
        "limps": LAME, "rubs": dataclasses.replace(RUBBING, hip_friction=1e-3),
        "rubs, rigid": dataclasses.replace(RUBBING, hip_friction=1e-3, **RIGID),
        "limps and rubs, rigid": dataclasses.replace(RUBBING_LAME, **RIGID)}.items()},
}  # fmt: skip


@pytest.fixture(scope="module", params=WALKERS)
def varied_gait(request):
    """A walker's gait with derivatives, the change of its gait with its parameters, and what differences may be off."""
    design, names, share, allowed = WALKERS[request.param]
    _, point = found_gait(dataclasses.replace(design.biped, hip_friction=0.0), design.friction)
    if design.biped.hip_friction:
        _, point = gait_beside(design.biped, point.z)
    there = tuple(name for name in names if name in sensitive_names(design))
    gait = gait_derivatives(design, point, there, 1e-12)
    return gait, gaits_beside(design, gait), share, allowed


def gaits_beside(design, gait):
    """Of a design all of whose named parameters are changed by some share, each with a sign of its own: the signs, and
    what tells walker and gait by the share, each found once.
    """
    signs = np.random.default_rng(1).choice([-1.0, 1.0], len(gait.changes.names))

    @cache
    def beside(share):
        there = {name: design.value(name) * (1 + sign * share) for name, sign in zip(gait.changes.names, signs)}
        walker = design.with_values(there).walker()
        return walker, fixed_point(walker, gait.point.z, 1e-12)

    return signs, beside


@pytest.mark.parametrize("goal", GOALS)
def test_gradients_of_every_goal_agree_with_extrapolated_differences(varied_gait, goal):
    """Of a goal's large parts: over both steps of a stride, and over every phase that a turn of the hip begins."""
    gait, (signs, there), share, allowed = varied_gait
    if goal == "sensitivity_norm" and not gait.walker.rolls:
        with pytest.raises(StepFailed, match="its feet do not roll"):
            GOALS[goal].parts(gait.walker, gait.point, 1e-12)
        return
    parts = GOALS[goal].parts(gait.walker, gait.point, 1e-12)
    large = parts > 0.05 * parts.max()
    wanted = extrapolated(lambda h: GOALS[goal].parts(*there(h), 1e-12)[large], share, 3)
    slopes = GOALS[goal].slopes(gait, 1e-12)[large]
    assert slopes @ signs == pytest.approx(wanted, rel=0, abs=allowed * max(np.abs(wanted).max(), parts.max()))


@pytest.mark.parametrize("goal", ["friction", "scuff"])
def test_the_largest_of_a_gait_is_what_the_report_samples(varied_gait, goal):
    gait, p = varied_gait[0], varied_gait[0].walker.p
    validity = report_gait(gait.walker, gait.point, 1e-12, 0.5).validity
    sampled = {"friction": validity.friction_single_stance, "scuff": validity.deepest_scuff}[goal]
    parts = GOALS[goal].parts(gait.walker, gait.point, 1e-12)
    assert sampled <= parts.max() + 1e-12
    assert sampled == pytest.approx(parts.max(), rel=1e-3, abs=1e-6)  # of scuff a micrometre
    phases = sum(map(in_single_stance, record_steps(gait.walker, gait.point, 1e-12)))
    turns = getattr(p, "tau_h", 0.0) > 0.0 and not gait.walker.rigid  # rigid legs turn but at its ends
    assert len(parts) == 3 * phases and (phases > len(gait.point.steps)) == turns


@pytest.mark.parametrize(
    ("goal", "maximise", "starts", "bounds"),
    [
        ("speed", False, 2, {"biped.leg_length": (0.97, 1.3)}),
        ("friction", True, 1, {"biped.foot_com": (0.95, 1.95), "biped.foot_radius": (0.9, 1.6)}),
    ],
)
def test_a_smooth_optimum_inside_the_bounds_has_no_gradient(start, goal, maximise, starts, bounds):
    bounds = {name: tuple(DESIGN.value(name) * limit for limit in limits) for name, limits in bounds.items()}
    searches = search_design(
        DESIGN, start, bounds, tolerance=TOLERANCE, goal=goal, maximise=maximise, starts=starts)
    for found in searches:
        assert found.ending == ("maximum" if maximise else "minimum") and not found.bounds
        assert found.gain < 1e-6
        assert found.best.value == pytest.approx(searches[0].best.value, rel=1e-9)
    best = searches[0].best
    gait = gait_derivatives(best.design, best.point, tuple(bounds), TOLERANCE)
    parts = GOALS[goal].parts(best.walker, best.point, TOLERANCE)
    assert np.abs(GOALS[goal].slopes(gait, TOLERANCE)[parts.argmax()]).max() < 2e-6 * best.value


def test_a_search_that_runs_out_of_steps_says_so(start):
    bounds = within(0.2, "biped.foot_radius", "biped.foot_com", "biped.stiffness")
    found = search_design(DESIGN, start, bounds, tolerance=TOLERANCE, iterations=1)[0]
    assert found.ending == "unfinished" and not found.converged and found.gain > 1e-3


def test_a_search_ends_on_the_fold_of_the_family():
    """With damping 300 the long steps of steeper slopes turn back near 2.1038 degrees, see test_gait_search."""
    design = DesignPoint(dataclasses.replace(TABLE_1, damping=300.0), Slope(slope_deg=2.3, gravity=9.81))
    point = fixed_point(design.walker(), np.array([-0.2655, 1.0029, 0.9942, 0.4258, -0.1524]), 1e-10)
    found = search_design(
        design, point.z, {"ground.slope_deg": (1.9, 2.5)}, tolerance=1e-10, goal="scuff")[0]
    assert found.ending == "fold"
    assert found.best.design.slope.slope_deg == pytest.approx(2.10382, abs=1e-5)


def test_more_starts_are_never_worse(start):
    bounds = within(0.3, "biped.foot_com", "biped.stiffness")
    searches = search_design(DESIGN, start, bounds, tolerance=TOLERANCE, goal="scuff", starts=3)
    values = [found.best.value for found in searches]
    assert len(values) == 3 and (np.diff(values) > -1e-12 * values[0]).all()  # of two alike the design's own is first
    assert values[-1] == pytest.approx(values[0], rel=1e-6)
    assert all(found.path.shape == (len(found.history), 2) for found in searches)


def test_legs_that_hardly_differ_have_the_goal_of_legs_alike(start):
    """Their multipliers are of two steps: a target of .5 was met by .71 a step."""
    parts = []
    for other in (None, TABLE_1.foot_mass * (1 + 1e-7)):
        walker, point = gait_beside(dataclasses.replace(TABLE_1, other_foot_mass=other), start)
        parts.append((GOALS["multiplier"].parts(walker, point, 1e-10).max(), by_stability(point)))
    assert parts[1] == pytest.approx(parts[0], abs=1e-5) and parts[0][0] == parts[0][1]


def test_a_search_makes_a_gait_that_limps_more_stable():
    """The target is held by the mean of both steps."""
    design = DesignPoint(LAME, SLOPE)
    walker, point = found_gait(LAME)
    speed = describe(walker, point).speed_m_s
    bounds = {name: (0.97 * design.value(name), 1.03 * design.value(name))
              for name in ("biped.other_foot_com", "biped.frame_com", "biped.hip_damping")}
    found = search_design(design, point.z, bounds, targets={"speed_m_s": (speed, speed)}, tolerance=TOLERANCE,
                          iterations=12)[0]  # fmt: skip
    assert len(found.best.point.steps) == 2 and found.met
    assert found.best.gait.speed_m_s == pytest.approx(speed, rel=1e-6)
    assert all(low - 1e-12 <= found.best.design.value(name) <= high + 1e-12 for name, (low, high) in bounds.items())
    assert found.best.largest_multiplier < found.start.largest_multiplier - 1e-3


@pytest.mark.parametrize("biped", [LAME, RUBBING])
def test_the_deepest_scuff_of_a_stride_or_a_rubbing_hip_is_lessened(biped):
    parameters = SimpleNamespace(biped=biped, slope=SLOPE, friction=FRICTION, analytic=Settings(1e-8, 1, 100.0))
    options = design_question.Options(vary=("biped.foot_com=0.098:0.102",), goal="scuff", iterations=4)
    answer = design_question.ask(parameters, options, Asking())
    assert answer.plain["goal"]["best"] < answer.plain["goal"]["start"]
