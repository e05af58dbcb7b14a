"""How the gait answers to the transition velocities of friction."""

import dataclasses
import math

import numpy as np
import pytest

from stages.contact_study.result import FrictionVariation, changes, crossing
from stages.contact_study.run import laws_of, vary_friction
from stages.penalty.settings import Settings
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import simulate
from stages.planar.run import rolling_state
from stages.planar.sampling import find_events


def variation(factor, period, length):
    return FrictionVariation("stiction_velocity", factor, period, length)


def test_the_factor_at_which_a_limit_is_crossed_is_interpolated():
    rows = (variation(0.5, 0.5, 0.1605), variation(1.0, 0.5, 0.16), variation(2.0, 0.5, 0.1592),
            variation(4.0, 0.51, 0.1568))  # fmt: skip
    below, above = crossing(rows, "stiction_velocity", 0.0075)
    assert np.isnan(below)  # 0.3 % at the half, and nothing computed beyond
    assert above == pytest.approx(2.0 * 2.0 ** ((0.0075 - 0.005) / (0.02 - 0.005)))
    assert crossing(rows, "stiction_velocity", 0.01)[1] > above
    assert crossing((*rows, variation(0.25, np.nan, np.nan)), "stiction_velocity", 0.0075)[1] == above


@pytest.fixture(scope="module")
def stepper(parameters, stand_in):
    def on(law):
        start = rolling_state(parameters.biped, law, stand_in.mid_stance, 9.4)
        return PenaltyStepper(parameters.biped, parameters.slope, law, start, Settings(1e-9))

    return on


@pytest.fixture(scope="module")
def rows(default, stepper):
    return vary_friction(default, stepper)


def test_halving_the_stiction_velocity_lengthens_the_step_and_doubling_shortens_it(rows, default):
    """From Adams' stiction velocity, by 0.9 % and 1.9 %; the other velocity hardly matters."""
    in_length = {(row.name, row.factor): length for row, _, length in changes(rows)}
    assert in_length["stiction_velocity", 0.5] == pytest.approx(0.009, abs=0.001)
    assert in_length["stiction_velocity", 2.0] == pytest.approx(-0.019, abs=0.001)
    assert abs(in_length["friction_velocity", 2.0]) < 1e-4
    below, above = crossing(rows, "stiction_velocity", 0.01)
    assert 0.25 < below < 0.5 and 1.0 < above < 2.0
    laws = laws_of(default, rows)
    assert len(laws) == len(rows) and laws[0].stiction_velocity == pytest.approx(0.25 * default.stiction_velocity)


def test_a_gait_that_is_solved_for_is_where_a_long_walk_runs_into(rows, parameters, default, stepper):
    doubled = dataclasses.replace(default, stiction_velocity=2 * default.stiction_velocity)
    walker = stepper(doubled)
    run = simulate(
        parameters.biped, parameters.slope, doubled, walker.start, Settings(1e-9), steps=60, signals=())
    strikes = find_events(run.trajectory, parameters.biped.foot_radii).heel_strike_time
    solved = next(row for row in rows if (row.name, row.factor) == ("stiction_velocity", 2.0))
    assert 0.5 * (strikes[-1] - strikes[-3]) == pytest.approx(solved.period_s, rel=1e-6)  # steps alternate around it


def test_ground_on_which_no_gait_is_found_has_empty_rows(default, stepper):
    slippery = dataclasses.replace(default, static_friction=1e-3, dynamic_friction=1e-3)
    rows = vary_friction(slippery, stepper)
    assert rows and all(math.isnan(row.period_s) for row in rows) and laws_of(slippery, rows) == []
