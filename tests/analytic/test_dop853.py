"""The explicit Runge-Kutta step: its tableau and its order; the choice of steps."""

import numpy as np

from stages.analytic.integration.dop853_tableau import A, B
from stages.analytic.integration.integrator import DOP853, STAGES, step_factor
from stages.analytic.phases.motion import SINGLE_STANCE, flow
from tests.analytic.designs import walker_of


def fixed_steps(walker, y, duration, count, *, take_step=DOP853.take_step):
    """State after `count` equal steps of single stance."""
    stages, new, y = np.empty((STAGES, y.size)), np.empty(y.size), y.copy()
    for _ in range(count):
        flow(SINGLE_STANCE, y, walker.p, stages[0])
        take_step(SINGLE_STANCE, y, duration / count, walker.p, stages, new)
        y[:] = new
    return y


def test_tableau_meets_the_conditions_of_quadrature_to_order_eight():
    nodes = A.sum(axis=1)[:12]
    for power in range(8):
        assert abs(B[:12] @ nodes**power - 1 / (power + 1)) <= 1e-14


def test_single_stance_converges_with_order_eight():
    walker = walker_of()
    y = np.array([-0.2, 0.995, -0.25, 1.001, 0.4, -0.1, -0.3, 0.05])
    counts = np.array([10, 20, 40])
    best = fixed_steps(walker, y, 0.5, 320)
    errors = np.array([np.abs(fixed_steps(walker, y, 0.5, n) - best).max() for n in counts])
    orders = np.log2(errors[:-1] / errors[1:])
    assert errors[-1] > 1e-14, "the finest step must still show its error"
    assert 7.3 < orders[-1] < 9.0, f"errors {errors}, orders {orders}"


def test_not_a_number_is_never_accepted():
    """An error norm of NaN must not pass as small: `err > 1` is false for it."""
    stages = np.full((STAGES, 8), np.nan)
    error = DOP853.error_norm(np.ones(8), np.full(8, np.nan), 0.1, walker_of().p, stages, 1e-10)
    assert not error <= 1.0


def test_step_factor_is_bounded():
    assert step_factor(0.0) == 6.0
    assert step_factor(1e-30) == 6.0
    assert step_factor(1e30) == 0.2
