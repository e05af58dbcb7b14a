"""Distance from the rigid limit: errors do not cancel in it, and it falls along a family as its parts' order says."""

import dataclasses

import numpy as np
import pytest

from stages.contact_study import rigid_limit
from stages.contact_study.one_step import constraint_model, measure, take_step
from stages.contact_study.result import TOO_DEAR, search_table
from stages.contact_study.rigid_limit import (
    NOT_SOUGHT,
    choose,
    cycle_score,
    grid,
    hard_limit,
    parts,
    same_set,
    step_score,
    unmeasured,
)
from stages.ground.contact_law import family_member
from stages.planar.run import STEP_FLOOR
from stages.planar.section import NoLimitCycle
from stages.studies.result import COMPLETED
from tests.contact_study.made_up import make_candidates, make_distance

TIME = np.linspace(0.0, 1.0, 101)


def made_up(creep, impact, rest=0.0):
    """Hip (n, 4) of a set, of the same with half its creep and with half its impact, less the limit; effects in m."""
    shape = np.column_stack([TIME, 0.1 * TIME, np.ones(101), 0.1 * np.ones(101)])
    whole, half = creep + impact + rest, (0.5 * creep + impact + rest, creep + 0.5 * impact + rest)
    return whole * shape, half[0] * shape, half[1] * shape


def scored(parameters, *effects):
    split = np.abs(parts(*made_up(*effects))).max(axis=1)
    return step_score(split[:, :2].max(axis=1), split[:, 2:].max(axis=1), parameters.settings)


def test_parts_are_the_effects_and_add_up():
    whole, *halves = made_up(-3e-4, 2e-4, 1e-5)
    split = parts(whole, *halves)
    assert split[:, -1, 0] == pytest.approx([-3e-4, 2e-4, 1e-5]) and split.sum(axis=0) == pytest.approx(whole)


def test_errors_that_cancel_score_worse_than_smaller_ones_that_do_not(parameters):
    """-.5 and +.5 mm leave nothing over a step; -.1 mm alone does, and is five times better or more."""
    tuned, honest = made_up(-5e-4, 5e-4)[0], made_up(-1e-4, 0.0)[0]
    assert np.abs(tuned).max() < 1e-15 < np.abs(honest).max()
    assert scored(parameters, -5e-4, 5e-4) == pytest.approx(10.0 * scored(parameters, -1e-4, 0.0))


@pytest.mark.parametrize("signs", [(1, 1), (1, -1), (-1, -1)])
def test_the_distance_is_the_same_whatever_the_signs(parameters, signs):
    assert scored(parameters, signs[0] * 5e-4, signs[1] * 3e-4) == pytest.approx(scored(parameters, 5e-4, 3e-4))


def test_cycles_count_as_ways_of_the_hip(parameters):
    settings = dataclasses.replace(parameters.settings, position_limit=1e-3)
    assert cycle_score(np.array([1e-3, -2e-3, 0.0]), np.array([0.0, -1e-3, 1e-3]), 0.5, settings) == pytest.approx(3.5)


@pytest.fixture(scope="module")
def family(parameters, ruler):
    return [ruler.over_a_step(family_member(parameters.contact, share)) for share in (1.0, 0.5, 0.25)]


def test_the_distance_falls_along_the_family_at_first_order(family):
    """What is left of both effects is the share, so each half is half as far; the limit itself is at none."""
    lift = [one.hip_position[1] for one in family]
    assert lift[:2] == pytest.approx([2 * one for one in lift[1:]], rel=0.02)
    bounce = [one.hip_velocity[1] for one in family]
    assert 2 * bounce[2] - bounce[1] == pytest.approx(0.0, abs=0.05 * bounce[2]), "extrapolated to the limit"
    scores = [one.step_score for one in family]
    assert np.log2(np.divide(scores[:-1], scores[1:])) == pytest.approx([1.0, 1.0], abs=0.3)


def test_a_set_is_never_farther_from_the_limit_than_its_parts(family):
    for one in family:
        assert one.hip_position.max() <= one.position_parts.sum()
        assert one.hip_velocity.max() <= one.velocity_parts.sum()


def test_a_real_set_that_is_near_because_it_cancels_scores_worse(parameters, ruler, family):
    """Softer and bouncier: half the net difference of the chosen set, from larger parts."""
    tuned = ruler.over_a_step(dataclasses.replace(parameters.contact, contact_stiffness=1e5, contact_damping=1e4))
    assert tuned.hip_position.max() < 0.5 * family[0].hip_position.max()
    assert tuned.step_score > 1.1 * family[0].step_score


def test_differences_from_limit_and_of_the_limit_add_up_to_those_of_figure_8(
    parameters, constraints, beside_rolling, ruler, family
):
    hard = hard_limit(ruler.scene, *constraints)
    step = measure(beside_rolling, parameters.contact, take_step(beside_rolling, parameters.contact))
    assert family[0].end_position + hard.end_position == pytest.approx(step.end_position, abs=1e-9)
    assert family[0].evaluations == pytest.approx(step.evaluations, abs=3)


def test_the_limit_is_where_it_was_found_from_outside(constraints, ruler):
    """By an integrator in maximal coordinates with Moreau impacts: .252 mm, then -.788 ms and +.225 mm a step."""
    hard = hard_limit(ruler.scene, *constraints)
    assert hard.hip_position.max() == pytest.approx(2.52e-4, abs=1e-6)
    assert (hard.period, hard.step_length) == pytest.approx((-7.88e-4, 2.25e-4), abs=1e-6)
    assert hard.limit_period == pytest.approx(0.4818941562, abs=1e-9)


def test_cycles_are_where_they_were_found_from_outside(parameters, default, ruler, family):
    for law, period, length in ((parameters.contact, -3.75e-4, 3.64e-4), (default, 1.14e-3, -1.10e-3)):
        found = ruler.between_cycles(dataclasses.replace(family[0], law=law), split=False)
        assert found.cycle_outcome == COMPLETED
        assert (found.period, found.step_length) == pytest.approx((period, length), abs=6e-6)


def test_a_cycle_that_is_not_found_says_why(ruler, family, monkeypatch):
    def none(*given):
        raise NoLimitCycle("no fixed point")

    monkeypatch.setattr(rigid_limit, "fixed_point", none)
    found = ruler.between_cycles(family[0], split=True)
    assert found.cycle_outcome == "no fixed point" and np.isnan(found.period) and found.score == np.inf


def test_a_set_that_does_not_walk_is_told(ruler, default):
    found = ruler.over_a_step(dataclasses.replace(default, friction="none"))
    assert found.outcome != COMPLETED and np.isnan(found.hip_position).all() and found.step_score == np.inf


def test_rigid_legs_have_no_double_stance_in_which_a_foot_could_slip(parameters, constraints, ruler):
    rigid = dataclasses.replace(parameters.biped, legs="rigid")
    start = constraint_model(rigid, parameters.slope, None, constraints[0].mid_stance, 1e-10, 2000.0).mid_stance
    both = [
        constraint_model(rigid, parameters.slope, friction, start, 1e-10, 2000.0)
        for friction in (None, parameters.contact.coefficients)
    ]
    hard = hard_limit(dataclasses.replace(ruler.scene, walk=both[1].walk, period=both[1].period), *both)
    assert hard.hip_position.max() == hard.period == hard.step_length == 0.0


@pytest.mark.slow
def test_the_family_ends_at_the_limit(parameters, ruler):
    """A thirty-second of both effects is micrometres away: the order holds to the floor of the solver's tolerance."""
    near = ruler.over_a_step(family_member(parameters.contact, 1 / 32), lambda found: False)
    assert near.hip_position.max() < 3e-6 and near.hip_velocity.max() < 3e-4


# --- The criterion chooses what it says it chooses.


FIXED = ("searched_stiffness", "searched_damping", "searched_depth")


class Search:
    """A search among sets that differ in v_s alone, given as {v_s: (hip difference [m], cost, or an outcome)}."""

    def __init__(self, parameters, default, sets, finalists=2, cycles=None):
        fixed = (default.contact_stiffness, default.contact_damping, default.damping_depth)
        self.sets, self.cycles, self.walked, self.solved = sets, cycles or {}, [], []
        self.settings = dataclasses.replace(
            parameters.settings,
            **{key: (value,) for key, value in zip(FIXED, fixed)},
            searched_stiction_velocity=tuple(sets),
            finalists=finalists,
            cost_limit=1.5,
        )
        start = make_distance(default, 1.0, 100)
        self.chosen, self.finalists, self.tried = choose(start, self.settings, self.over_a_step, self.between_cycles)

    def over_a_step(self, law, worth):
        self.walked.append(law.stiction_velocity)
        hip, cost = self.sets[law.stiction_velocity]
        if isinstance(hip, str):
            return unmeasured(law, hip, cost)
        found = dataclasses.replace(make_distance(law, hip, cost), cycle_outcome=NOT_SOUGHT, cycle_score=np.inf)
        return found if worth(found) else dataclasses.replace(found, step_score=np.inf)

    def between_cycles(self, found):
        self.solved.append(found.law.stiction_velocity)
        return dataclasses.replace(found, cycle_score=self.cycles.get(found.law.stiction_velocity, 1.0))


@pytest.mark.parametrize(("sets", "cycles", "outcomes", "finalists"), [
    pytest.param({0.01: (1e-4, 151), 0.02: (2e-4, 150), 0.03: (3e-4, 120), 0.05: (4e-4, 90)}, {},
                 (TOO_DEAR, COMPLETED, COMPLETED, COMPLETED), [0.02, 0.03], id="the nearest that keeps the cost"),
    pytest.param({0.03: (3.0e-4, 120), 0.05: (3.1e-4, 90), 0.06: (9e-4, 80)}, {0.03: 9.0, 0.05: 2.0, 0.06: 0.0},
                 (COMPLETED,) * 3, [0.05, 0.03], id="cycles decide between the two best over a step"),
    pytest.param({0.03: (3e-4, 120), 0.05: (9e-4, 90)}, {0.03: np.inf},
                 (COMPLETED,) * 2, [0.05, 0.03], id="one without a cycle comes last"),
    pytest.param({0.03: (3e-4, 120), 0.05: (9e-4, 90)}, {0.03: np.inf, 0.05: np.inf},
                 (COMPLETED,) * 2, [0.03, 0.05], id="without any cycle the step decides"),
    pytest.param(
        {0.01: (1e-4, 140), 0.02: (1e-4, 140), 0.03: (STEP_FLOOR, 151), 0.05: (3e-4, 120), 0.06: ("fell", 80)}, {},
        (COMPLETED, COMPLETED, TOO_DEAR, COMPLETED, "fell"), [0.01, 0.02], id="too dear or falling"),
    pytest.param({0.03: ("fell", 80), 0.05: (1e-4, 200)}, {}, ("fell", TOO_DEAR), [], id="none is left"),
])
def test_the_best_cycle_of_the_nearest_that_keep_the_cost_wins(parameters, default, sets, cycles, outcomes, finalists):
    search = Search(parameters, default, sets, cycles=cycles)
    assert search.walked == list(sets) and search.solved == sorted(finalists), "those best over a step"
    assert search.tried.outcome == outcomes
    assert search.tried.evaluations.tolist() == [cost for _, cost in sets.values()]
    assert np.isinf(search.tried.score[[outcome != COMPLETED for outcome in outcomes]]).all()
    assert np.isfinite(search.tried.score[[outcome == COMPLETED for outcome in outcomes]]).all()
    assert [one.law.stiction_velocity for one in search.finalists] == finalists
    assert search.chosen is search.finalists[0] if finalists else search.chosen.law == default


def test_the_grid_holds_the_starting_set_and_every_combination(parameters, default):
    laws = list(grid(default, parameters.settings))
    assert default in laws and len(set(laws)) == len(laws) == 3 * 2 * 3 * 5
    assert {law.contact_exponent for law in laws} == {default.contact_exponent}


def test_laws_that_differ_in_what_they_do_not_use_are_one(parameters, default):
    """A law of restitution has no damping of its own; Coulomb friction falls at no velocity."""
    bouncing = dataclasses.replace(default, normal_force="restitution")
    assert len(list(grid(bouncing, parameters.settings))) == 3 * 5
    assert same_set(bouncing, dataclasses.replace(bouncing, contact_damping=1.0, damping_depth=1.0))
    assert not same_set(default, dataclasses.replace(default, contact_damping=1.0))
    assert same_set(default, dataclasses.replace(default, contact_damping=(1 + 1e-14) * default.contact_damping))
    assert not same_set(default, dataclasses.replace(default, friction="coulomb"))
    rubbing = dataclasses.replace(default, friction="coulomb")
    assert same_set(rubbing, dataclasses.replace(rubbing, friction_velocity=7.0))


def test_scores_are_infinite_where_nothing_is_known(default):
    assert unmeasured(default, "fell", 0).score == np.inf
    assert make_distance(default, 1e-3).score == pytest.approx(20.0)


def test_the_best_sets_are_those_that_have_a_score(default):
    """Sets that are too dear, without a number, stood among the twelve best."""
    title, _, rows = search_table(make_candidates(default, 1e-4))
    assert title == "The 2 best of 3 sets searched" and [row[-1] for row in rows] == [0.5, 1.0]
