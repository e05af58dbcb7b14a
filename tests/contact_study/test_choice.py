"""The criterion chooses what it says it chooses."""

import dataclasses
import math

import numpy as np
import pytest

from stages.contact_study.choice import TOO_DEAR, choose, excess, grid, score
from stages.contact_study.result import OneStep
from stages.multibody.walking.scuffing import STEP_FLOOR


def step(law, hip=1e-3, depth=1e-5, cost=100, outcome="completed"):
    """A step as if the hip differed by `hip` [m] in x, without any walking."""
    difference = np.array([hip, 0.0])
    return OneStep(outcome, "", law, difference, 0 * difference, 0 * difference, difference, 0, 0, 9, depth, 0, 0, cost)


def search(parameters, default, steps):
    """Choose among steps given by stiction velocity."""
    settings = dataclasses.replace(
        parameters.settings,
        searched_stiffness=(default.contact_stiffness,),
        searched_damping=(default.contact_damping,),
        searched_depth=(default.damping_depth,),
        searched_stiction_velocity=tuple(steps),
        penetration_limit=1.0,
        cost_limit=1.5,
    )
    chosen, tried = choose(
        step(default), settings, lambda law: dataclasses.replace(steps[law.stiction_velocity], law=law)
    )
    return chosen.stiction_velocity, tried


def test_score_adds_each_difference_in_its_limit(parameters, default):
    settings = dataclasses.replace(parameters.settings, position_limit=1e-3, velocity_limit=1e-2, force_limit=0.1)
    law = step(default, hip=2e-3)
    assert score(law, settings) == pytest.approx(2.0)
    more = dataclasses.replace(law, hip_velocity=np.array([0.01, 0.03]), normal_force=0.05)
    assert score(more, settings) == pytest.approx(2.0 + 3.0 + 0.5)


def test_the_least_difference_wins_among_those_that_keep_the_limits(parameters, default):
    steps = {
        0.01: step(default, hip=1e-4, depth=2e-5),  # too deep
        0.02: step(default, hip=1e-4, cost=200),  # too dear
        0.03: step(default, hip=3e-4),
        0.05: step(default, hip=4e-4),
        0.06: step(default, outcome="fell"),
        0.07: step(default, outcome=STEP_FLOOR),
    }
    chosen, tried = search(parameters, default, steps)
    assert chosen == 0.03
    assert tried.excess[:4] == pytest.approx([1.0, 1 / 3, 0.0, 0.0])
    assert tried.outcome[4:] == ("fell", TOO_DEAR) and np.isinf(tried.score[4:]).all()


def test_if_no_set_keeps_the_limits_the_one_that_breaks_them_least_is_chosen(parameters, default):
    deep, least, dear = step(default, depth=3e-5, hip=1e-5), step(default, depth=1.1e-5), step(default, cost=300)
    steps = {0.01: deep, 0.02: least, 0.03: dear}
    assert search(parameters, default, steps)[0] == 0.02


def test_a_failed_step_breaks_every_limit(parameters, default):
    assert excess(step(default, outcome="fell"), parameters.settings, step(default)) == math.inf


def test_the_grid_holds_the_starting_set_and_every_combination(parameters, default):
    laws = list(grid(default, parameters.settings))
    assert default in laws and len(set(laws)) == len(laws) == 3 * 2 * 3 * 5
    assert {law.contact_exponent for law in laws} == {default.contact_exponent}
