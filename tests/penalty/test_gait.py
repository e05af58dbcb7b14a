"""The step map of the penalty walker: its exact derivative, its fixed point and multipliers."""

from itertools import pairwise

import numpy as np
import pytest

from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings, simulate
from stages.planar.section import NoLimitCycle, mid_stance_after, section_numbers, section_state
from tests.planar_start import SCALES


@pytest.fixture(scope="module")
def fine(biped, slope, contact, start):
    return PenaltyStepper(biped, slope, contact, start, Settings(1e-12))


def test_the_derivative_is_that_of_the_map(fine, gait):
    """Against central differences of walks, extrapolated to no difference, in directions of all numbers."""
    exact = fine.derivative(gait.section_state)
    for direction in np.random.default_rng(11).normal(size=(4, 10)):
        along = direction * SCALES * np.array([1e-3, 1.0, 1e-3, *[1.0] * 7])  # hardly lifts the standing foot
        slopes = []
        for size in (2e-3, 1e-3):
            ends = [fine.step(gait.section_state + sign * size * along).numbers for sign in (1.0, -1.0)]
            slopes.append((ends[0] - ends[1]) / (2.0 * size))
        expected = (4.0 * slopes[1] - slopes[0]) / 3.0
        assert exact @ along / SCALES == pytest.approx(expected / SCALES, abs=2e-5 * np.abs(expected / SCALES).max())


def test_a_step_from_the_gait_ends_on_it(fine, gait):
    after = fine.step(gait.section_state)
    assert np.abs((after.numbers - gait.section_state) / SCALES).max() < 1e-7
    assert after.duration == pytest.approx(gait.period_s, abs=1e-9)
    assert gait.residual < 1e-9 and gait.steps_walked < 20


def test_walks_approach_the_gait_as_its_multipliers_say(fine, gait, start):
    """Two multipliers remain after a step; distances along their left eigenvectors shrink by them, one by one."""
    values, vectors = np.linalg.eig(gait.monodromy_matrix)
    leading = np.argsort(-np.abs(values))[:2]
    left = np.linalg.inv(vectors)[leading].real
    numbers, distances = gait.section_state + 2e-4 * SCALES * [0, 1, 0, 0, 0, 0, 0, 1, 0, 0], []
    for _ in range(4):
        numbers = fine.step(numbers).numbers
        distances.append(left @ (numbers - gait.section_state))
    for before, after in pairwise(distances):
        assert after / before == pytest.approx(values[leading].real, rel=0.02)
    assert gait.floquet_multipliers[:2] == pytest.approx(np.column_stack([values[leading].real, [0.0, 0.0]]))


def test_the_step_map_is_the_walk(fine, biped, slope, contact, start):
    """The same step read off a recorded walk, as it is of Exudyn's walks."""
    numbers = section_numbers(start)
    read = mid_stance_after(simulate(biped, slope, contact, start, Settings(1e-12), steps=1))
    own = fine.step(numbers)
    assert own.numbers == pytest.approx(read.numbers, abs=1e-9)
    assert (own.duration, own.length) == pytest.approx((read.duration, read.length), abs=1e-10)
    assert np.array_equal(section_numbers(section_state(numbers, start)), numbers)


def test_a_start_that_falls_has_no_step(fine, start):
    numbers = section_numbers(start)
    numbers[4] = -0.6
    with pytest.raises(NoLimitCycle, match="fell"):
        fine.step(numbers)
