"""Fixed point from a few steps of a made-up map with two large multipliers, as the walker has them."""

import numpy as np
import pytest

from stages.planar.plane_cycle import find_cycle, plane_map, step_derivative
from stages.planar.section import SCALES, NoLimitCycle, SectionStep

FIXED = np.linspace(0.2, 1.1, 10)
MULTIPLIERS = np.array([0.64, -0.61, 0.0098, *np.zeros(7)])
BASIS = np.eye(10) + 0.1 * np.random.default_rng(3).normal(size=(10, 10))
MAP = BASIS @ np.diag(MULTIPLIERS) @ np.linalg.inv(BASIS)


def stepper(bend=0.0):
    def step(numbers):
        off = numbers / SCALES - FIXED
        return SectionStep((FIXED + MAP @ off + bend * off**2) * SCALES, None, 0.5, 0.16, 100)

    return step


@pytest.mark.parametrize("bend", (0.0, 0.5))
def test_a_fixed_point_is_found(bend):
    derivative = step_derivative(stepper(bend), FIXED + 1e-2, 5e-3)
    two = np.sort(np.linalg.eigvals(derivative).real)[[-1, 0]]
    assert two == pytest.approx([0.64, -0.61], abs=2e-3 + 5e-2 * bend)
    for guess in (FIXED + 1e-2, FIXED - 3e-2):
        cycle = find_cycle(stepper(bend), guess, 1e-6, derivative)
        assert cycle.state == pytest.approx(FIXED, abs=5e-6) and cycle.residual < 1e-6


def test_three_differences_give_the_map_on_their_plane():
    plane = BASIS[:, :2] @ np.array([1.0, 1.0])
    derivative = plane_map([plane, MAP @ plane, MAP @ MAP @ plane])
    assert derivative @ BASIS[:, 0] == pytest.approx(0.64 * BASIS[:, 0], abs=1e-9)


def test_a_map_without_a_fixed_point_nearby_is_told():
    def drift(numbers):
        return SectionStep(numbers + 0.1 * np.arange(1, 11) * SCALES * np.sin(1e3 * numbers.sum()), None, 0.5, 0.1, 1)

    with pytest.raises(NoLimitCycle, match="no fixed point"):
        find_cycle(drift, FIXED, 1e-12, 0.5 * np.eye(10))
