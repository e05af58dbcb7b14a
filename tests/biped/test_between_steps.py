"""Positions and velocities between a solver's steps."""

import numpy as np
import pytest

from stages.biped.between_steps import BLOCK, hermite, hermite_from

STEPS = np.array([0.0, 0.3, 0.4, 1.0])
TIME = np.linspace(0.0, 1.0, 2 * BLOCK + 7)  # more than two blocks


def rows(degree):
    """Two polynomials of a degree at the steps, with rates and their rates, and what they are at `TIME`."""
    rng = np.random.default_rng(degree)
    powers = [np.polynomial.Polynomial(rng.normal(size=degree + 1)) for _ in range(2)]
    at = [np.column_stack([power.deriv(order)(STEPS) for power in powers]) for order in range(3)]
    return at, [np.column_stack([power.deriv(order)(TIME) for power in powers]) for order in range(2)]


@pytest.mark.parametrize(("degree", "bent"), [(5, True), (3, False)])
def test_polynomials_of_its_own_degree_are_met_exactly(degree, bent):
    (place, rate, bend), wanted = rows(degree)
    for found, true in zip(hermite(STEPS, place, rate, bend if bent else None, TIME), wanted, strict=True):
        assert found == pytest.approx(true, abs=1e-12)


def test_one_time_or_many_or_one_step_alone_give_the_same():
    (place, rate, bend), _ = rows(7)
    many = hermite(STEPS, place, rate, bend, TIME)
    for row in (0, 1, 2):
        alone = hermite_from(row, STEPS, place, rate, bend)
        for number in np.flatnonzero((STEPS[row] <= TIME) & (STEPS[row + 1] > TIME))[::97]:
            one = hermite(STEPS, place, rate, bend, TIME[number : number + 1])
            for k, exact in enumerate(alone(float(TIME[number]))):
                assert np.array_equal(one[k][0], many[k][number]) and np.array_equal(exact, one[k][0])
        assert np.array_equal(alone(STEPS[row + 1])[0], place[row + 1])
