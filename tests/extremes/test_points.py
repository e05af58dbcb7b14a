"""The map covers what it claims to cover, and a verdict calls an unannounced error wrong."""

import dataclasses
from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest

from stages.analytic.gait.gait_search import find_gait
from stages.analytic.model.walker import build_walker
from stages.biped.design import Biped
from stages.biped.quantity import faults
from stages.extremes import constraint_points, penalty_points, run as stage
from stages.extremes.parameters import (
    COMPILED,
    COULOMB,
    CRASHED,
    DERIVATIVES,
    DETAILED,
    ENGINES,
    ESTIMATE,
    FAILED,
    GAIT,
    INACCURATE,
    JOINTS,
    KNOWING_DETAILS,
    LIMIT,
    MARCH,
    OF_A_GAIT,
    REFUSED,
    RIGHT,
    STEP,
    TOGETHER,
    TREE,
    TWIN,
    UNCONFIRMED,
    WRONG,
)
from stages.extremes.points import AXES, BLOCK, KINDS, SIZE, Point, changes, detailed_draw, points
from stages.extremes.result import Finding, judged
from stages.extremes.run import as_result, evaluate
from tests.analytic.test_detailed import LAME, LAME_RIGID
from tests.changed import changed
from tests.similar import similar
from tests.study import parameters_of


@pytest.fixture(scope="module")
def parameters():
    return parameters_of("extremes")


@pytest.fixture(scope="module")
def full(parameters):
    return points(changed(parameters, resolution="full"))


def test_the_full_map_has_its_points_and_its_ranges(full):
    assert len(full) >= 1500 and len(set(full)) == len(full)
    assert {point.engine for point in full} == set(ENGINES)
    wanted = {
        "biped.stiffness": (1e2, 1e10), "biped.damping": (0.0, 1e5), "friction": (0.0, 5.0),
        "ground.stiction_velocity": (1e-6, 1.0), "ground.slope_deg": (0.0, 80.0), "analytic.tolerance": (1e-14, 1e-2),
        "multibody.tolerance": (1e-14, 1e-2), "hip to foot mass": (1e-4, 1e4), "leg length": (1e-3, 10.0),
        "ground.gravity": (1.62, 24.79),
    }  # fmt: skip
    for axis, span in wanted.items():
        values = [point.value for point in full if point.axis == axis]
        assert (min(values), max(values)) == pytest.approx(span, rel=1e-3), axis
    assert max(point.value for point in full if point.engine == MARCH) == 1e5


def test_the_coarse_map_is_part_of_the_full_one(full, parameters):
    coarse = points(parameters)
    few = points(changed(parameters, resolution="few"))
    assert set(few) < set(coarse) < set(full)
    assert {point.engine for point in coarse} == set(ENGINES) - {JOINTS, *OF_A_GAIT}


def test_every_point_is_what_it_says(full, parameters):
    for point in full[::7]:
        here = parameters.changed(point.changes)
        for name, value in point.changes:
            owners = [s for s in vars(here).values() if name.split(".")[0] == s.FILE and hasattr(s, name.split(".")[1])]
            assert owners and all(getattr(owner, name.split(".")[1]) == value for owner in owners)
        if point.axis == "hip to foot mass":
            assert here.biped.hip_mass / here.biped.foot_mass == pytest.approx(point.value)
            assert here.biped.total_mass == pytest.approx(parameters.biped.total_mass)


def test_similar_bipeds_keep_their_dimensionless_numbers(full, parameters):
    own, *others = (np.array(build_walker(biped, parameters.slope).p[:10]) for biped in (
        parameters.biped,
        *(parameters.changed(point.changes).biped for point in full if point.axis == "size, similar")))  # fmt: skip
    assert others and all(other == pytest.approx(own, rel=1e-13) for other in others)


@pytest.mark.parametrize(("error", "audit", "asked", "status"), [
    (1e-5, 1e-12, 1e-10, RIGHT), (1e-3, 1e-12, 1e-10, WRONG), (np.nan, np.nan, 1e-10, WRONG),
    (1e-3, 1e-2, 1e-10, INACCURATE),  # its own audit tells
    (1e-3, 1e-12, 1e-4, INACCURATE),  # such accuracy was asked for
])
def test_an_error_that_nothing_tells_is_wrong(error, audit, asked, status):
    assert judged(error, audit, asked, 1e-4, "").status == status


@pytest.mark.parametrize("engine", [GAIT, COULOMB, STEP])
def test_the_study_s_own_point_is_right(parameters, engine):
    finding = evaluate(parameters, Point(engine, "none", 0.0, ()))
    assert (finding.status, finding.reason) == (RIGHT, "") and finding.error < 1e-7


def off_gait(honest):
    """A gait that is off, although its search claims convergence and its audit nearly closes."""
    def off(*arguments):
        walker, point = honest(*arguments)
        return walker, dataclasses.replace(point, z=point.z + np.array([2e-4, 0.0, 0.0, 0.0, 0.0]))

    return off


def off_step(honest):
    """A step whose period is off."""
    def off(*arguments):
        step = honest(*arguments)
        return dataclasses.replace(step, period=step.period * 1.001)

    return off


def off_exchange(honest):
    """The legs called the other way round, on other springs."""
    return property(lambda biped: dataclasses.replace(honest.fget(biped), stiffness=2900.0))


def test_how_far_a_gait_is_from_the_fixed_point_of_another_map():
    """Of a linear map: whole, also where a coordinate is no coordinate of the section and stays zero."""
    matrix, fixed = np.array([[0.6, 0.3, 0.0], [-0.2, 0.5, 0.0], [0.0, 0.0, 1.0]]), np.array([0.2, 0.9, 0.0])
    z = fixed + [1e-3, -4e-3, 0.0]
    point = SimpleNamespace(z=z, monodromy_matrix=matrix, steps=(None, None), period=0.5)
    after = fixed + matrix @ (z - fixed)
    assert constraint_points.distance(point, after, 1.0) == pytest.approx(4e-3, rel=1e-9)
    assert constraint_points.distance(point, after, 1.02) == pytest.approx(0.01, rel=1e-9), "its period is farther off"


@pytest.mark.parametrize(("engine", "changes", "where", "what", "off"), [
    (GAIT, (), constraint_points, "find_gait", off_gait),
    (DETAILED, (("biped.other_foot_mass", 0.336),), constraint_points, "find_gait", off_gait),
    (DETAILED, (("biped.other_foot_mass", 0.336),), Biped, "exchanged", off_exchange),
    (STEP, (), constraint_points, "poincare_map", off_step),
])
def test_a_wrong_answer_is_found_out(parameters, monkeypatch, engine, changes, where, what, off):
    """By the reference, or by the same machine whose legs are called the other way round."""
    monkeypatch.setattr(where, what, off(getattr(where, what)))
    finding = evaluate(parameters, Point(engine, "none", 0.0, changes))
    assert finding.status == WRONG or (engine != STEP and finding.status == INACCURATE)
    assert finding.error > 1e-4


def test_detailed_points_have_every_detail_and_kind(full, parameters):
    detailed = [point for point in full if point.engine == DETAILED]
    axes = [row for row in AXES if DETAILED in row[4]]
    assert len(detailed) >= 200 and len({point.axis for point in detailed}) == len(axes) + 1
    changed = {name.removeprefix("biped.") for point in detailed for name, _ in point.changes}
    assert changed >= {"frame_mass", "frame_com", "frame_offset", "frame_inertia", "foot_offset", "hip_stiffness",
                       "hip_rest_angle", "hip_damping", "hip_friction", "hip_gravity_mass", "other_leg_length",
                       "other_foot_mass", "other_foot_radius", "other_stiffness", "other_frame_mass"}  # fmt: skip
    for point in detailed:
        biped = parameters.changed(point.changes).biped
        assert not list(faults(biped)) and (biped.detailed or point.axis == TOGETHER)


def test_the_compiled_penalty_walker_is_asked_of_a_detailed_design(parameters):
    given = changed(parameters, frame_mass=0.03, frame_com=0.04, frame_inertia=1e-4, hip_damping=5e-4)
    found = evaluate(given, next(point for point in points(given) if point.engine == COMPILED))
    assert found.status == RIGHT and "tree" in found.reference


#: Of each kind of walker, draws that have a gait, and one that has none where that is soon found.
DRAWN = (((10,), ()), ((0,), ()), ((5, 6), (9,)), ((8, 12), (0,)), ((8,), ()))
MORE_DRAWN = (((12,), (5,)), ((2,), ()), ((4, 12), ()), ((5, 6), ()), ((11,), ()))
ALL_DRAWN = [*enumerate(DRAWN), *(pytest.param(*each, marks=pytest.mark.slow) for each in enumerate(MORE_DRAWN))]


@pytest.mark.parametrize(("kind", "drawn"), ALL_DRAWN)
def test_detailed_draws_are_right_or_have_no_gait(parameters, kind, drawn):
    """Those with a gait are all as near to the reference."""
    assert len(DRAWN) == len(KINDS)
    walking, others = drawn
    found = [evaluate(parameters, Point(DETAILED, TOGETHER, draw, detailed_draw(parameters.biped, kind * BLOCK + draw)))
             for draw in (*walking, *others)]  # fmt: skip
    assert [finding.status for finding in found] == [RIGHT] * len(walking) + [REFUSED] * len(others)
    assert all("no periodic gait" in each.reason for each in found[len(walking) :])
    assert all(each.error < 1e-6 and each.audit < 1e-6 for each in found[: len(walking)])


@pytest.fixture(scope="module")
def lame(parameters):
    """The stage's parameters of a study whose own design has details and legs that differ."""
    return dataclasses.replace(parameters, biped=LAME)


def test_a_detailed_design_is_asked_of_the_models_that_know_it(lame):
    assert {point.engine for point in points(changed(lame, resolution="full"))} == set(KNOWING_DETAILS)


def test_a_detailed_design_of_another_size_walks_alike(lame):
    """All that has a unit grows with it, the details too."""
    own = find_gait(lame.biped, lame.slope, 1e-10)
    large = lame.changed(changes(lame.biped, SIZE, 3.0 * lame.biped.leg_length))
    walker, point = find_gait(large.biped, large.slope, 1e-10)
    assert point.period == pytest.approx(own[1].period, rel=1e-8)
    assert walker.time == pytest.approx(np.sqrt(3.0) * own[0].time)


@pytest.mark.parametrize("engine", [GAIT, STEP, MARCH, ESTIMATE])
def test_a_detailed_design_s_own_point_is_right(lame, engine):
    finding = evaluate(lame, Point(engine, "none", 4.0, ()))
    assert (finding.status, finding.reason.startswith("the last step")) == (RIGHT, engine == MARCH)


@pytest.mark.parametrize(("own", "status"), [
    ({"frame_mass": 0.01, "hip_stiffness": 0.02}, RIGHT), ({"biped": LAME_RIGID}, UNCONFIRMED)])
def test_derivatives_of_a_detailed_design_are_confirmed_but_beside_a_fold(parameters, own, status):
    """Differences of two parts in a thousand are too wide for legs that differ by as much as the lame design's."""
    finding = evaluate(changed(parameters, **own), Point(DERIVATIVES, "none", 4.0, ()))
    assert finding.status == status and ("do not settle" in finding.reason) == (status == UNCONFIRMED)


@pytest.mark.parametrize(("values", "statuses", "words"), [
    ({"legs": "rigid", "feet_retract": True, "strike_time": 0.485}, {GAIT: RIGHT, DERIVATIVES: RIGHT, TREE: REFUSED},
     "does not know strike_time"),
    ({"hip_friction": 1e-3}, {GAIT: RIGHT, MARCH: RIGHT, COULOMB: REFUSED},
     "together with a trailing foot that may slip"),
    ({"legs": "rigid", "hip_friction": 1e-3}, {GAIT: RIGHT, MARCH: RIGHT, COULOMB: RIGHT}, ""),
], ids=["timed feet", "rubbing hip", "rubbing hip of rigid legs"])
def test_what_a_model_does_not_know_is_refused_with_a_sentence(parameters, values, statuses, words):
    """What lands by itself in Exudyn is another machine than one whose feet are put down at a given time."""
    own = changed(parameters, **values)
    for engine, status in statuses.items():
        finding = evaluate(own, Point(engine, "none", 4.0, ()))
        assert finding.status == status and (status == RIGHT or words in finding.reason)


def test_the_time_of_feet_put_down_grows_with_the_size(parameters):
    biped = dataclasses.replace(parameters.biped, legs="rigid", feet_retract=True, strike_time=0.485)
    large = changed(parameters, biped=biped).changed(changes(biped, SIZE, 4.0 * biped.leg_length)).biped
    assert large.strike_time == pytest.approx(2.0 * 0.485) and large.feet_retract is True


@pytest.mark.slow
def test_all_detailed_points_are_right_or_have_no_gait(full, parameters):
    found = [evaluate(parameters, point) for point in full if point.engine == DETAILED]
    statuses = [finding.status for finding in found]
    assert set(statuses) <= {RIGHT, REFUSED, UNCONFIRMED} and statuses.count(RIGHT) >= 150


@pytest.mark.parametrize(("stiffness", "status", "reference"), [
    (2800.0 * 300.0, WRONG, "tighter tolerance"), (1e9, UNCONFIRMED, "looser tolerance")])
def test_a_rerun_never_has_the_tolerance_of_the_answer(parameters, monkeypatch, stiffness, status, reference):
    """It is tighter, or, where round-off forbids that, looser, and then it confirms or does not, but never refutes."""
    honest, asked = constraint_points.poincare_map, []

    def off(walker, z, tolerance):
        asked.append(tolerance)
        return (honest if asked[1:] else off_step(honest))(walker, z, tolerance)

    monkeypatch.setattr(constraint_points, "poincare_map", off)
    finding = evaluate(parameters, Point(STEP, "none", 0.0, (("biped.stiffness", stiffness),)))
    answer, rerun = asked
    assert rerun >= 10 * answer if status == UNCONFIRMED else rerun <= answer / 10
    assert (finding.status, finding.reference) == (status, reference)


@pytest.mark.parametrize(("share", "status"), [(0.9, RIGHT), (1.1, WRONG)])
def test_what_is_round_off_of_a_path_is_a_share_of_the_legs_length(parameters, monkeypatch, share, status):
    """Of an estimate that is a quarter of the true error."""
    true = share * constraint_points.ROUND_OFF * parameters.biped.leg_length
    said = SimpleNamespace(given=True, hip_position=true / 4.0)
    monkeypatch.setattr(constraint_points, "estimate_errors", lambda *_: said)
    monkeypatch.setattr(constraint_points, "walk_differences", lambda *_: {"hip_position_m": true})
    assert evaluate(parameters, Point(ESTIMATE, "none", 0.0, ())).status == status


def test_an_exception_of_no_one_s_making_is_a_crash(parameters, monkeypatch):
    monkeypatch.setattr(constraint_points, "find_gait", lambda *_: 1 / 0)
    assert evaluate(parameters, Point(GAIT, "none", 0.0, ())).status == CRASHED


def test_the_compiled_walker_s_tolerance_is_in_leg_lengths_and_exudyn_s_in_metres(parameters, monkeypatch):
    """Of a leg of 33 mm the compiled walker was forgiven errors thirty times as large as were requested."""
    small = 0.1 * parameters.biped.leg_length
    found = {}
    for engine in (COMPILED, TREE):
        times = np.linspace(0.0, 1.0, 10)
        answers = iter([penalty_points.Answer(True, "", times, np.full((10, 2), 5e-3 * small * shift), 0.0)
                        for shift in (1, 0)])  # fmt: skip
        monkeypatch.setattr(penalty_points, "answer_of", lambda *_, answers=answers: next(answers))
        point = Point(engine, SIZE, small, changes(parameters.biped, SIZE, small))
        found[engine] = evaluate(changed(parameters, penalty_tolerance=1e-5), point).status
    assert found == {COMPILED: WRONG, TREE: INACCURATE}


@pytest.mark.parametrize("scale", [(8.0, 4.0, 2.0), (1.0, 1.0, 2.0)], ids=["four times", "gravity a quarter"])
def test_the_rigid_limit_of_similar_robots_is_alike_and_no_step_is_compared_beyond_its_end(parameters, scale):
    """Of Table 1's softest contact .0071 was of a step that had ended, drawn on; it is .0017."""
    point = Point(LIMIT, "stiffer contact", 1.0, ())
    one, other = (evaluate(each, point) for each in (parameters, similar(parameters, scale)))
    assert one.error == pytest.approx(other.error, rel=0.01) and 1e-3 < one.error < 2e-3


SLOW = [pytest.param(engine, marks=pytest.mark.slow) for engine in (JOINTS, TWIN)]


@pytest.mark.parametrize("engine", [COMPILED, TREE, *SLOW])
def test_a_penalty_model_s_own_point_is_right_and_a_shifted_one_wrong(parameters, engine, monkeypatch):
    loose = changed(parameters, penalty_tolerance=1e-6)
    point, honest, calls = Point(engine, "none", 0.0, ()), penalty_points.answer_of, []

    def off(*arguments):
        answer = honest(*arguments)
        calls.append(answer)
        return dataclasses.replace(answer, hip=answer.hip + 1e-3) if len(calls) == 1 else answer

    monkeypatch.setattr(penalty_points, "answer_of", off)
    assert evaluate(loose, point).status == WRONG
    limit, tolerance = loose.settings.right_within, np.nan if engine == JOINTS else 1e-6
    assert penalty_points.compared(*calls, loose.biped, tolerance, limit, "").status == RIGHT
    # a walker that falls where its reference walks is wrong, and no solver that gives up
    fallen = iter((dataclasses.replace(calls[0], completed=False, outcome="fell: the walker fell"), calls[1]))
    monkeypatch.setattr(penalty_points, "answer_of", lambda *_: next(fallen))
    finding = evaluate(loose, point)
    assert finding.status == (FAILED if engine == JOINTS else WRONG) and "the reference" in finding.reason


@pytest.mark.parametrize(("engine", "name", "value", "status", "reason"), [
    *(pytest.param(engine, "ground.stiction_velocity", 1e-6, FAILED, "within its steps", id=f"{engine} crawls")
      for engine in (COMPILED, TREE, TWIN)),
    pytest.param(GAIT, "analytic.tolerance", 1e-2, REFUSED,
                 "analytic.tolerance = 0.01 is not allowed; allowed: >= 1e-14 and <= 0.001", id="not allowed"),
])
def test_a_solver_that_crawls_is_given_up_and_what_is_not_allowed_is_refused(
    parameters, engine, name, value, status, reason
):
    finding = evaluate(changed(parameters, most_solver_steps=1000), Point(engine, "none", 0.0, ((name, value),)))
    assert finding.status == status and reason in finding.reason


def test_the_result_counts_and_says_its_spans(full):
    asked = full[1:4]
    found = [Finding(RIGHT, 1e-9, 1e-12, "other"), Finding(WRONG, 1.0, reason="why"), Finding(REFUSED, reason="no")]
    result = as_result("full", asked, found)
    assert result.summary() == "3 points (full): 1 right, 1 refused, 1 wrong"
    (_, columns, rows), (_, _, spans) = result.tables()
    assert columns == ["engine", "right", "refused", "wrong", "all"] and rows == [["gait", "1", "1", "1", "3"]]
    assert spans[0][3].startswith("1 of 3")


# --- The usual parameters are looked at once, while the code is compiled, and every point gets its own verdict.


@pytest.mark.parametrize("resolution", ["few", "coarse", "full"])
def test_each_point_has_its_own_verdict(monkeypatch, resolution):
    parameters, usual = parameters_of("extremes", f"extremes.resolution={resolution}"), Counter()

    def evaluate(_, point):
        usual[point.engine] += not point.changes
        return Finding(RIGHT, reason=told(point))

    def told(point):
        return f"{point.engine} {point.value if point.engine == LIMIT else ''} {point.changes}"

    monkeypatch.setattr(stage, "evaluate", evaluate)
    monkeypatch.setattr(stage, "compute", lambda evaluate, common, points, **_: [evaluate(common, p) for p in points])
    assert stage.run(parameters).reason == tuple(told(point) for point in stage.points(parameters))
    assert len(usual) > 2
    assert {number for engine, number in usual.items() if engine != LIMIT} <= {0, 1}
