from __future__ import annotations

import numpy as np
import pytest

from stages.biped.between_steps import IMPACT_RATE, SPIKE_RATE, refined_times, uniform_times

#: As that of a leg of a third of a metre [s].
PENDULUM_TIME = 0.18


def test_even_times_reach_the_end_in_spite_of_rounding():
    times = uniform_times(0.3, 10.0)  # 0.3 * 10 is a little less than 3
    assert times == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert times[-1] <= 0.3


def test_heel_strikes_are_sampled_densely_and_nothing_else_is():
    times = refined_times(2.0, 100.0, np.array([0.5, 1.9999]), PENDULUM_TIME)
    spacing = np.diff(times)
    assert (spacing > 0).all()
    assert times[0] == 0.0 and times[-1] <= 2.0
    near = (times[:-1] > 0.4995) & (times[1:] < 0.508)
    assert spacing[near].max() <= 1.01 * PENDULUM_TIME / IMPACT_RATE
    spike = (times[:-1] >= 0.5) & (times[1:] < 0.50017)
    assert spacing[spike].max() <= 1.01 * PENDULUM_TIME / SPIKE_RATE and spike.sum() >= 36
    far = (times[:-1] > 0.6) & (times[1:] < 1.9)
    assert spacing[far] == pytest.approx(0.01)


def test_without_heel_strikes_the_times_are_even():
    assert refined_times(1.0, 50.0, np.zeros(0), PENDULUM_TIME) == pytest.approx(uniform_times(1.0, 50.0))
