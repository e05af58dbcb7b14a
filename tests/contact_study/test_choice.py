"""The criterion chooses what it says it chooses."""

import dataclasses

import numpy as np
import pytest

from stages.contact_study.result import TOO_DEAR
from stages.contact_study.rigid_limit import NOT_SOUGHT, choose, grid, unmeasured
from stages.planar.run import STEP_FLOOR
from tests.contact_study.made_up import make_distance

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


def test_the_nearest_set_that_keeps_the_cost_wins(parameters, default):
    search = Search(parameters, default, {0.01: (1e-4, 151), 0.02: (2e-4, 150), 0.03: (3e-4, 120), 0.05: (4e-4, 90)})
    assert search.chosen.law.stiction_velocity == 0.02
    assert search.solved == [0.02, 0.03], "the two best over a step"
    assert search.tried.outcome == (TOO_DEAR, "completed", "completed", "completed")
    assert np.isinf(search.tried.score[0]) and np.isfinite(search.tried.score[1:]).all()


def test_cycles_decide_between_the_best_over_a_step(parameters, default):
    sets = {0.03: (3.0e-4, 120), 0.05: (3.1e-4, 90), 0.06: (9e-4, 80)}
    search = Search(parameters, default, sets, cycles={0.03: 9.0, 0.05: 2.0, 0.06: 0.0})
    assert [one.law.stiction_velocity for one in search.finalists] == [0.05, 0.03]
    assert search.chosen is search.finalists[0]


def test_a_set_without_a_cycle_is_chosen_only_if_none_has_one(parameters, default):
    sets = {0.03: (3e-4, 120), 0.05: (9e-4, 90)}
    assert Search(parameters, default, sets, cycles={0.03: np.inf}).chosen.law.stiction_velocity == 0.05
    both = Search(parameters, default, sets, cycles={0.03: np.inf, 0.05: np.inf})
    assert both.chosen.law.stiction_velocity == 0.03, "then the step decides"


def test_what_is_too_dear_or_does_not_walk_is_not_chosen(parameters, default):
    sets = {0.01: (1e-4, 140), 0.02: (1e-4, 140), 0.03: (STEP_FLOOR, 151), 0.05: (3e-4, 120), 0.06: ("fell", 80)}
    search = Search(parameters, default, sets)
    assert search.walked == list(sets)
    assert search.tried.outcome == ("completed", "completed", TOO_DEAR, "completed", "fell")
    assert search.tried.evaluations.tolist() == [140, 140, 151, 120, 80]
    assert search.chosen.law.stiction_velocity == 0.01


def test_if_none_is_left_the_starting_set_is_chosen(parameters, default):
    search = Search(parameters, default, {0.03: ("fell", 80), 0.05: (1e-4, 200)})
    assert search.chosen.law == default and search.finalists == ()


def test_the_grid_holds_the_starting_set_and_every_combination(parameters, default):
    laws = list(grid(default, parameters.settings))
    assert default in laws and len(set(laws)) == len(laws) == 3 * 2 * 3 * 5
    assert {law.contact_exponent for law in laws} == {default.contact_exponent}


def test_scores_are_infinite_where_nothing_is_known(default):
    assert unmeasured(default, "fell", 0).score == np.inf
    assert make_distance(default, 1e-3).score == pytest.approx(20.0)
