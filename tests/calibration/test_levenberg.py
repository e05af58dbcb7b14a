"""Least squares rest where what is left to gain is a small part of what the residuals say that they do not know."""

import numpy as np

from stages.calibration.estimation.fit import ENOUGH, Point, least_squares


def valley(spread):
    """Half the squares of Rosenbrock's residuals, `spread` times a noise of which each is one."""

    def evaluate(x):
        residuals = np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])
        jacobian = np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]])
        cost, matrix, right = 0.5 * float(residuals @ residuals), jacobian.T @ jacobian, -jacobian.T @ residuals
        return Point(x, cost, matrix, right, None, spread)

    return least_squares(evaluate, np.array([-1.2, 1.0]), np.ones(2), np.full(2, -np.inf))


def test_a_fit_whose_residuals_are_larger_rests_where_as_small_a_part_is_left():
    exact, coarse = valley(1.0), valley(1e3)
    assert exact.converged and exact.point.cost < ENOUGH
    assert coarse.converged and coarse.evaluations < exact.evaluations
    assert exact.point.cost < coarse.point.cost
    assert valley(0.01).evaluations == exact.evaluations  # no more is asked of residuals that are small
