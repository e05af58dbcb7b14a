"""Orders of convergence, references that other integrators confirm, fronts, and the kept tables against a rerun."""

import dataclasses
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.study import Study
from stages.analytic.errors import StepFailed
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.recording import crossing_state
from stages.biped.accuracy.tolerances import LEVELS
from stages.biped.design import BeyondModel
from stages.tradeoff import penalty_ways
from stages.tradeoff.result import Errors, Result, Row, cells, cost_at, front, gain
from stages.tradeoff.run import Plan, constraint_plans, measure, penalty_plans, plans, projected_plan, row_of, scene
from stages.tradeoff.way import Walked, Way
from tests.analytic.test_detailed import LAME, LAME_RIGID
from tests.changed import changed

NAN = math.nan
#: A rerun may differ by this factor: errors of adaptive steps change with the last bits, as on another machine.
FACTOR = 5.0


@pytest.fixture(scope="session")
def kept(repository):
    return json.loads((repository / "benchmarks/ways.json").read_text())


@pytest.fixture(scope="session")
def constraint(parameters, analytic):
    return [measure(with_some(plan)) for plan in constraint_plans(parameters, analytic)]


@pytest.mark.parametrize(("resolution", "grounds"), [("few", 1), ("coarse", 1), ("full", 4)])
def test_other_grounds_are_measured_in_full_alone(parameters, analytic, resolution, grounds):
    whole = dataclasses.replace(parameters, settings=dataclasses.replace(parameters.settings, resolution=resolution))
    assert len([*penalty_plans(whole, analytic)]) == grounds


#: Tolerances at which the quick tests measure the compiled way: both ends of its order, and the study's own.
SOME = (1e-4, 1e-10, 1e-12)


def with_some(plan):
    """The plan with each of its ways, the compiled one at a few tolerances, without the paper's, which is the longest,
    and without SciPy's multipliers: each takes ten steps. Those of rigid legs, and of all legs in slow tests, remain.
    """
    ways = [way if way.name == "compiled" else dataclasses.replace(way, multiplier=None) for way in plan.ways
            if way.mark != "paper" and (way.name != "compiled" or way.setting["tolerance"] in SOME)]
    independent = dataclasses.replace(plan.independent, multiplier=None)
    return dataclasses.replace(plan, ways=tuple(ways), independent=independent)


@pytest.mark.slow
def test_no_way_contradicts_the_kept_table(kept, parameters, analytic):
    """Of the constraint model; all tolerances, where the quick test below has a few."""
    rows, references = [], []
    for plan in constraint_plans(parameters, analytic):
        ways = tuple(way for way in plan.ways if way.mark != "paper")
        reference, found = measure(dataclasses.replace(plan, ways=ways))
        references.append(reference)
        rows += found
    assert all(row.completed for row in rows)
    assert references[0].independent_differs.multiplier < 1e-5, "central differences"
    rows += penalty_and_twin_rows(parameters, analytic, tolerances=(1e-3, 1e-4, 1e-6))
    assert compared_with(kept, rows) == len(rows) >= 25


@pytest.mark.slow
def test_the_papers_way_does_not_contradict_the_kept_table(kept, parameters, analytic):
    plan = next(iter(constraint_plans(parameters, analytic)))
    [way] = [way for way in plan.ways if way.mark == "paper"]
    _, [row] = measure(dataclasses.replace(plan, ways=(way,)))
    assert compared_with(kept, [row]) == 1


def test_references_are_confirmed_by_an_integrator_that_shares_no_step_and_no_event_search(constraint):
    for reference, rows in constraint:
        assert all(row.completed for row in rows)
        assert reference.second_differs.hip_position < 1e-12
        assert reference.independent_differs.hip_position < 1e-9, "1e-10 relative tolerance over four steps"
        assert reference.independent_differs.period < 1e-10
    assert constraint[0][0].period == pytest.approx(constraint[1][0].period, rel=0.01)
    assert constraint[0][0].period != constraint[1][0].period


def test_rigid_legs_are_walked_once_and_confirmed(parameters):
    """No friction changes their step; SciPy's multiplier by differences is that of the variational equations."""
    stiff = changed(parameters, legs="rigid", slope_deg=0.8, walked_steps=2)
    walker, point = find_gait(stiff.biped, stiff.slope, 1e-12)
    upright = walker.stance_state(crossing_state(walker, point.z, 1e-12))
    np.testing.assert_allclose(walker.stance_state(walker.from_stance(upright)).swing_rate, upright.swing_rate)
    [plan] = constraint_plans(stiff, SimpleNamespace(mid_stance=upright))
    reference, rows = measure(dataclasses.replace(with_some(plan), independent=plan.independent))
    assert all(row.completed for row in rows)
    assert reference.period == pytest.approx(point.period * walker.time, rel=1e-9)
    assert reference.independent_differs.hip_position < 1e-9
    assert reference.independent_differs.multiplier < 1e-5, "central differences"


def test_the_second_setting_is_another_walk_however_stiff_the_legs(parameters, analytic):
    """With weak dampers round-off ends at 1.7e-13: at 1e-14 and 1e-13 the walk was one, and its error nothing."""
    plan = next(constraint_plans(changed(parameters, damping=25.0, walked_steps=2), analytic))
    reference, _ = measure(dataclasses.replace(plan, ways=()))
    assert 1e-15 < reference.second_differs.hip_position < 1e-11


@pytest.mark.parametrize("biped", [LAME, LAME_RIGID])
def test_a_study_s_own_detailed_design_is_measured_by_the_constraint_model_alone(parameters, biped):
    """As its own reference at two tolerances, and beside SciPy on readable equations."""
    [plan] = plans(dataclasses.replace(parameters, biped=biped), None)
    ways = tuple(way for way in plan.ways
                 if way.setting["tolerance"] in ((1e-4, 1e-8) if way.name == "compiled" else (1e-4,)))  # fmt: skip
    reference, rows = measure(dataclasses.replace(plan, ways=ways))
    assert {row.way for row in rows} == {"compiled", "SciPy DOP853"}
    assert reference.model == "detailed constraint model" and all(row.completed for row in rows)
    assert reference.second_differs.hip_position < 1e-11 and reference.independent_differs.hip_position < 1e-9
    found = {(row.way, row.tolerance): row.errors.hip_position for row in rows}
    assert found["compiled", 1e-8] < 1e-3 * found["compiled", 1e-4]


@pytest.mark.parametrize(("values", "words"), [
    ({"hip_friction": 1e-3}, "do not know hip_friction"),
    ({"legs": "rigid", "feet_retract": True, "strike_time": 0.5}, "does not know strike_time")])
def test_what_no_way_knows_is_said(parameters, values, words):
    with pytest.raises(BeyondModel, match=words):
        next(plans(changed(parameters, **values), None))


def test_a_stride_of_a_detailed_design_is_confirmed_and_converges(parameters):
    """The twin as it projects into the plane: its steps alternate, and the readable path knows it."""
    plan = projected_plan(changed(parameters, walked_steps=2))
    ways = tuple(way for way in plan.ways if way.name == "compiled" and way.setting["tolerance"] in (1e-4, 1e-12))
    reference, rows = measure(dataclasses.replace(plan, ways=ways))
    assert reference.independent_differs.hip_position < 1e-10 and reference.second_differs.hip_position < 1e-12
    assert reference.independent_differs.period < 1e-10 and math.isnan(reference.independent_differs.multiplier)
    loose, tight = rows
    assert (loose.tolerance, tight.tolerance) == (1e-4, 1e-12)
    for name in ("hip_position", "period", "multiplier"):
        assert math.log10(getattr(loose.errors, name) / getattr(tight.errors, name)) > 5.0, name


def test_errors_of_the_compiled_way_fall_with_its_order(constraint):
    """Order 8: ten times the tolerance is 10^(1/8) of the step, so the error falls about with the tolerance."""
    for _, rows in constraint:
        compiled = {row.tolerance: row for row in rows if row.way == "compiled"}
        loose, tight = compiled[1e-4], compiled[1e-12]
        for name in ("hip_position", "period", "multiplier"):
            fall = math.log10(getattr(loose.errors, name) / getattr(tight.errors, name))
            assert 5.5 < fall < 10.0, name
        growth = math.log10(tight.evaluations / loose.evaluations)
        assert 0.4 < growth < 1.1, "8 decades cost about one decade at order 8"


def test_a_rerun_does_not_contradict_the_kept_table(kept, parameters, analytic, constraint):
    rows = [row for _, found in constraint for row in found] + penalty_and_twin_rows(parameters, analytic)
    assert compared_with(kept, rows) == len(rows)
    assert {row.way for row in rows} == {"compiled", "SciPy DOP853", "SciPy RK45", "Exudyn tree, DOPRI5",
                                         "Exudyn tree in space, DOPRI5"}  # fmt: skip


def compared_with(kept, rows):
    """How many of these rows the kept table has; none contradicts it."""
    compared = 0
    for row in rows:
        then = next((old for old in kept["rows"] if (old["model"], old["way"], old["setting"])
                     == (row.model, row.way, row.setting)), None)  # fmt: skip
        if then is None:
            continue
        compared += 1
        assert row.outcome == then["outcome"]
        assert row.evaluations == pytest.approx(then["evaluations"], rel=0.05)
        now, before = row.errors.hip_position, then["errors"]["hip_position"]
        floor = 3e-9 if row.way != "compiled" else 1e-13  # what the references of a coarse rerun are good for
        assert now <= FACTOR * before + floor and before <= FACTOR * now + floor, row
    return compared


def penalty_and_twin_rows(parameters, analytic, tolerances=(1e-6,)):
    """Rows of Exudyn's ways; the reference of those in the plane is the compiled walker, which is quicker."""
    four = changed(parameters, walked_steps=4)
    at, twin = (scene(model, four, analytic) for model in (penalty_ways.PENALTY, penalty_ways.TWIN))
    tree, space = penalty_ways.tree_way, penalty_ways.twin_way
    pairs = (
        (penalty_ways.penalty_way(at, 1e-10), [tree(at, tolerance, 2e-3) for tolerance in tolerances]),
        (space(twin, 1e-6, 2e-3), [space(twin, 1e-4, 2e-3)]),
    )
    return [row_of(way, truth, NAN) for best, ways in pairs for truth in (best.walk(),) for way in ways]


def test_a_way_that_falls_is_a_row_with_the_reason(parameters, analytic):
    slow = dataclasses.replace(analytic.mid_stance, stance_rate=-0.4, swing_rate=0.0)
    falling = SimpleNamespace(mid_stance=slow, walk=SimpleNamespace(standing_force=9.4))
    at = scene("slow", changed(parameters, walked_steps=2), falling)
    way = penalty_ways.tree_way(at, 1e-5, 2e-3)
    with pytest.raises(StepFailed):
        way.walk()
    row = row_of(way, None, NAN)
    assert not row.completed and math.isnan(row.errors.hip_position)


def test_exudyns_difference_along_the_eigenvector_is_the_compiled_walkers_exact_multiplier(parameters, analytic):
    at = scene(penalty_ways.PENALTY, parameters, analytic)
    exact = penalty_ways.penalty_way(at, 1e-10, multiplier=True).multiplier()
    assert penalty_ways.tree_way(at, 1e-9, 2e-3, multiplier=True).multiplier() == pytest.approx(exact, rel=1e-5)


def made_up(way, mark, error, cost):
    return Row("m", way, "", mark, "completed", Errors(error, NAN, NAN, NAN), cost, NAN, NAN)


def walked(off, peak=10.0):
    return Walked(np.full((2000, 2), 0.5 + off), 1.0, 0.5 + off, peak, 100.0)


def made_up_way(off, tolerance, peak=10.0, multiplier=None):
    return Way("m", f"way {tolerance:g}", {"tolerance": tolerance}, lambda: None, lambda: walked(off, peak), multiplier)


def test_an_error_below_what_the_reference_is_unsure_of_is_shown_as_less_than_that():
    """Of another way where that is as tight; never surer than numbers are spaced, as where all ways give the same."""
    ways = (made_up_way(3e-9, 1e-6, 10.3), made_up_way(1e-12, 1e-9, 10.001))
    second, same = made_up_way(1e-10, 1e-11, 10.02), made_up_way(0.0, 1e-12)
    for tolerance, sure in ((1e-11, 0.07), (1e-9, 0.02)):
        plan = Plan(same, second, made_up_way(1e-11, tolerance, 10.07), ways)
        reference, [loose, tight] = measure(plan)
        assert (loose.doubt.hip_position, loose.doubt.peak_force) == pytest.approx((1e-10, sure))
        assert cells(loose.errors, loose.doubt) == ["3.0e-09", "3.0e-09", "-", "3.0e-01"]
        assert cells(tight.errors, tight.doubt) == ["< 1.0e-10", "< 1.0e-10", "-", f"< {sure:.1e}"]
    result = Result(4, (reference,), (loose, tight))
    assert result.tables()[1][2][1][4] == "< 1.0e-10"
    _, [row] = measure(Plan(same, same, None, (same,)))
    assert cells(row.errors, row.doubt) == ["< 1.1e-16", "< 1.1e-16", "-", "< 1.8e-15"]


def test_the_same_steps_are_walked_at_every_level(repository):
    """Else a level's period would be another step's."""
    levels = [Study(repository, repository / "params", repository / "results", requested=(("accuracy", level),))
              for level in LEVELS]  # fmt: skip
    assert len({study.parameters(("tradeoff",))["tradeoff"].settings.walked_steps for study in levels}) == 1


def test_the_front_holds_what_nothing_beats():
    rows = [made_up("a", "", 1e-3, 1.0), made_up("a", "", 1e-2, 2.0), made_up("a", "", 1e-6, 3.0)]
    assert front(rows, [1.0, 2.0, 3.0], "hip_position") == [0, 2]
    assert front(rows, [1.0, 2.0, 3.0], "period") == []


def test_the_gain_is_taken_at_the_papers_error():
    rows = [made_up(*row) for row in (
        ("ours", "default", 1e-8, 40.0), ("ours", "", 1e-4, 10.0), ("theirs", "paper", 1e-6, 99.0))]  # fmt: skip
    assert gain(rows, "m", [row.evaluations for row in rows]) == pytest.approx(99.0 / 20.0), "half way in logarithms"


@pytest.mark.parametrize(("known", "error", "cost"), [
    ([(1e-8, 40.0), (1e-4, 10.0)], 1e-2, 10.0), ([(1e-8, 40.0)], 1e-9, NAN),
    ([(1e-9, 40.0), (1e-8, 40.1), (1e-4, 10.0)], 1e-6, 40.0 / 4.0**0.6)])
def test_the_cost_at_an_error_is_that_of_the_front(known, error, cost):
    assert cost_at(known, error) == pytest.approx(cost, nan_ok=True)
