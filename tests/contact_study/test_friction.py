"""How the gait answers to the transition velocities of friction."""

import dataclasses
import math

import numpy as np
import pytest

from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.contact_study.result import FrictionVariation, changes, crossing
from stages.contact_study.run import laws_of, vary_friction
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings, simulate
from stages.planar.run import rolling_state
from stages.planar.sampling import find_events
from stages.planar.section import NoLimitCycle


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


@pytest.mark.parametrize("tolerance", [1e-8, 1e-7, 1e-6])
def test_a_looser_solver_finds_the_same_gaits(rows, parameters, default, tolerance):
    """A poor derivative led the search at 1e-7 to legs that stand side by side, and to a gait of 4e-11 s."""
    walker, point = find_gait(parameters.biped, parameters.slope, 1e-9)
    walk, upright = walk_from_mid_stance(walker, point.z, 1, 1e-9, 2000.0)

    def on(law):
        start = rolling_state(parameters.biped, law, upright, walk.standing_force)
        return PenaltyStepper(parameters.biped, parameters.slope, law, start, Settings(tolerance))

    found = vary_friction(default, on)
    for name in ("period_s", "step_length_m"):
        exact = [getattr(one, name) for one in rows]
        np.testing.assert_allclose([getattr(one, name) for one in found], exact, rtol=30 * tolerance)


def test_legs_that_stand_side_by_side_take_no_step(default, stepper):
    numbers = np.array([0.3325, 0.0494, 0.3325, 0.3326, 0.956, -0.0441, -2.88, -3.374, -0.044, 0.05])
    with pytest.raises(NoLimitCycle, match="no leg swings"):
        stepper(default).step(numbers)


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
