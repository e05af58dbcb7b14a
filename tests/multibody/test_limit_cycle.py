"""The multibody model's own gait: a fixed point that a long walk runs into, at the rate of its multipliers."""

import dataclasses

import numpy as np
import pytest

from stages.planar.limit_cycle import gait_near
from stages.planar.sampling import sample
from stages.planar.section import NoLimitCycle


def test_a_start_that_falls_is_refused(scene, start):
    pushed_back = dataclasses.replace(start, hip_velocity=(-0.6, 0.0), leg_rate=(2.0, 0.0))
    with pytest.raises(NoLimitCycle, match="fell"):
        cycle_of(scene.but(tolerance=1e-6, largest_step=2e-3), pushed_back)


@pytest.mark.slow
def test_forward_differences_cost_ten_steps_less_and_leave_a_thousandth(scene, start):
    coarse = scene.but(tolerance=1e-7)
    central, forward = (cycle_of(coarse, start, difference=5e-4, central=which) for which in (True, False))
    assert central.steps_walked - forward.steps_walked == 10
    np.testing.assert_allclose(forward.section_state, central.section_state, rtol=0, atol=1e-7)  # the steps' tolerance
    off = np.hypot(*(forward.floquet_multipliers - central.floquet_multipliers)[:2].T)
    assert 0.0 < off.max() < 2e-3


@pytest.mark.slow
def test_a_long_walk_runs_into_the_fixed_point(scene, start):
    cycle = cycle_of(scene.but(tolerance=1e-10, largest_step=1e-3), start)
    run = scene.walk(start, steps=40)
    periods = np.diff(sample(run.trajectory, scene.biped, scene.slope, 500.0).heel_strike_time)
    assert periods[-1] == pytest.approx(cycle.period_s, abs=1e-7)
    largest = np.hypot(*cycle.floquet_multipliers[0])
    assert largest < 1.0
    approach = np.abs(periods - cycle.period_s)
    assert (approach[20] / approach[8]) ** (1 / 12) == pytest.approx(largest, abs=0.05)


def cycle_of(scene, start, difference=1e-4, **how):
    return gait_near(scene.walker(start, difference), start, **how)
