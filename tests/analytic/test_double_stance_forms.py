"""The index forms of double stance agree, and differentiating the constraints twice loses nothing."""

import numpy as np
import pytest

from stages.analytic.integration.readable import accelerations, terms
from stages.analytic.walk.recording import states_at
from tests.analytic.double_stance_forms import (
    acceleration_level,
    free_directions,
    project,
    rates,
    velocity_level,
)


@pytest.fixture(scope="module")
def start(table_1_gait, table_1_step):
    walker, _ = table_1_gait
    double = table_1_step[0]
    duration = 0.9 * double.duration
    expected = states_at(double.phase, double.times, double.states, np.array([duration]), walker.p)[0]
    return walker, double.states[0], duration, expected


def test_acceleration_level_with_projection(start):
    walker, y, duration, expected = start
    assert np.abs(acceleration_level(walker, y, duration, 1e-12) - expected).max() <= 1e-9


def test_velocity_level_of_the_paper(start):
    """The system the paper solves, by IDA: same motion and same contact forces."""
    walker, y, duration, expected = start
    found, force = velocity_level(walker, y, duration, 1e-10)
    assert np.abs(found - expected).max() <= 1e-7
    assert np.abs(force - accelerations(walker, expected, True)[1]).max() <= 1e-3


def test_free_directions(start):
    walker, y, duration, expected = start
    found = free_directions(walker, y, duration, 1e-12)
    assert np.abs(found - expected).max() <= 1e-9
    pi = terms("compliant").constraint_jacobian(found, walker.p)
    assert np.abs(pi.T @ found[4:]).max() <= 1e-10


def test_projection_brings_a_drifted_state_back(start):
    walker, y, _, _ = start
    t = terms("compliant")
    roll = t.constraint(y, walker.p)[1, 0]
    drifted = y + 1e-4 * np.array([1, -1, 0.5, 1, 1, 0.3, -1, 0.2])
    back = project(walker, drifted, roll)
    assert np.abs(t.constraint(back, walker.p).ravel() - [0, roll]).max() <= 1e-14
    assert np.abs(t.constraint_jacobian(back, walker.p).T @ back[4:]).max() <= 1e-14
    assert np.abs(project(walker, y, roll) - y).max() <= 1e-14


def test_twice_differentiated_constraints_keep_rolling_but_let_drift_stand(start):
    """From a consistent start nothing slips; an inconsistent start is carried on, which is what projection is for."""
    walker, y, _, _ = start
    rate = rates(walker, y)
    t, h = terms("compliant"), 1e-5

    def slip(state):
        return (t.constraint_jacobian(state, walker.p).T @ state[4:])[1]

    assert abs(slip(y)) <= 1e-14
    assert abs(slip(y + h * rate) - slip(y - h * rate)) / (2 * h) <= 1e-6
    wrong = y.copy()
    wrong[6] += 0.01
    turned = rates(walker, wrong)
    assert abs(slip(wrong)) > 1e-3
    assert abs(slip(wrong + h * turned) - slip(wrong - h * turned)) / (2 * h) <= 1e-6
