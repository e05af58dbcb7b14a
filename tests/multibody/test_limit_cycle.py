"""The multibody model's own gait: a fixed point that a long walk runs into, at the rate of its multipliers."""

import dataclasses

import numpy as np
import pytest

from stages.multibody.walking.cycle import limit_cycle
from stages.multibody.walking.walk import simulate
from stages.planar.sampling import sample
from stages.planar.section import NoLimitCycle, section_numbers, section_state


def test_section_numbers_and_state_are_inverse(start):
    numbers = np.linspace(0.1, 1.0, 10)
    assert np.array_equal(section_numbers(section_state(numbers, start)), numbers)


def test_a_start_that_falls_is_refused(biped, slope, contact, start, settings):
    pushed_back = dataclasses.replace(start, hip_velocity=(-0.6, 0.0), leg_rate=(2.0, 0.0))
    coarse = dataclasses.replace(settings, tolerance=1e-6, largest_step=2e-3)
    with pytest.raises(NoLimitCycle, match="fell"):
        limit_cycle(biped, slope, contact, pushed_back, coarse)


@pytest.mark.slow
def test_forward_differences_cost_ten_steps_less_and_leave_a_thousandth(biped, slope, contact, start, settings):
    coarse = dataclasses.replace(settings, tolerance=1e-7)
    central, forward = (
        limit_cycle(biped, slope, contact, start, coarse, 5e-4, central=which) for which in (True, False))
    assert central.steps_walked - forward.steps_walked == 10
    assert np.array_equal(forward.section_state, central.section_state)
    off = np.hypot(*(forward.floquet_multipliers - central.floquet_multipliers)[:2].T)
    assert 0.0 < off.max() < 2e-3


@pytest.mark.slow
def test_a_long_walk_runs_into_the_fixed_point(biped, slope, contact, start, settings):
    fine = dataclasses.replace(settings, tolerance=1e-10, largest_step=1e-3)
    cycle = limit_cycle(biped, slope, contact, start, fine)
    run = simulate(biped, slope, contact, start, settings, steps=40)
    strikes = sample(run.trajectory, biped, slope, 500.0).heel_strike_time
    periods = np.diff(strikes)
    assert periods[-1] == pytest.approx(cycle.period_s, abs=1e-7)
    largest = np.hypot(*cycle.floquet_multipliers[0])
    assert largest < 1.0
    approach = np.abs(periods - cycle.period_s)
    rate = (approach[20] / approach[8]) ** (1 / 12)
    assert rate == pytest.approx(largest, abs=0.05)
