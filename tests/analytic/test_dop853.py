"""The explicit and the implicit Runge-Kutta step: tableaus, orders, damping of stiff motion, the choice of steps."""

import numpy as np
import pytest

from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.poincare import poincare_derivative, poincare_map
from stages.analytic.integration.dop853_tableau import A as EXPLICIT
from stages.analytic.integration.dop853_tableau import B
from stages.analytic.integration.integrator import DOP853, STAGES, step_factor
from stages.analytic.integration.radau import A_INVERSE, A, C, error_norm, jacobian, take_step
from stages.analytic.integration.readable import take_step as readable_step
from stages.analytic.model.stiffness import axial_rates
from stages.analytic.phases.motion import SINGLE_STANCE, flow
from tests.analytic.designs import FRICTION, TABLE_1, changed, random_states, stiff_gait, walker_of


def fixed_steps(walker, y, duration, count, *, take_step=DOP853.take_step):
    """State after `count` equal steps of single stance."""
    stages, new, y = np.empty((STAGES, y.size)), np.empty(y.size), y.copy()
    for _ in range(count):
        flow(SINGLE_STANCE, y, walker.p, stages[0])
        take_step(SINGLE_STANCE, y, duration / count, walker.p, stages, new)
        y[:] = new
    return y


def test_tableau_meets_the_conditions_of_quadrature_to_order_eight():
    nodes = EXPLICIT.sum(axis=1)[:12]
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


# --- The implicit step: its coefficients, its order, its damping of stiff motion, and that it is taken where it
# pays.


STATE = np.array([-0.2, 0.995, -0.25, 1.001, 0.4, -0.1, -0.3, 0.05])
#: Designs at the stiff end: a damper alone, and a damped spring.
STIFF = [
    changed(TABLE_1, damping=1e4),
    changed(TABLE_1, damping=1e5),
    changed(TABLE_1, stiffness=1e8, damping=1.1e4),
    changed(TABLE_1, stiffness=1e10, damping=1e5),
]


def test_tableau_integrates_polynomials_as_collocation_does():
    """Weights (the last row of A) to degree 12, that is order 13; every stage to degree 6."""
    for power in range(13):
        assert abs(A[-1] @ C**power - 1 / (power + 1)) <= 1e-15
    for power in range(7):
        np.testing.assert_allclose(A @ C**power, C ** (power + 1) / (power + 1), atol=1e-15)
    assert C[-1] == 1.0


def test_stability_function_vanishes_at_infinity():
    """R(z) = 1 + z b (I - z A)^-1 1 tends to zero, and is at most one on the imaginary axis and left of it."""

    def growth(z):
        return abs(1 + z * (A[-1] @ np.linalg.solve(np.eye(7) - z * A, np.ones(7))))

    assert growth(-1e8) <= 1e-6
    for angle in np.linspace(np.pi / 2, np.pi, 7):
        for size in (0.1, 1.0, 10.0, 100.0):
            assert growth(size * np.exp(1j * angle)) <= 1 + 1e-12
    np.testing.assert_allclose(A_INVERSE @ A, np.eye(7), atol=1e-12)


def test_jacobian_is_that_of_the_rates():
    walker = walker_of(changed(TABLE_1, leg_inertia=1e-3))
    for y in random_states(walker, 4):
        found = jacobian(SINGLE_STANCE, y, walker.p)
        for i in range(8):
            ahead, behind = np.empty(8), np.empty(8)
            step = 1e-5 * np.eye(8)[i]
            flow(SINGLE_STANCE, y + step, walker.p, ahead)
            flow(SINGLE_STANCE, y - step, walker.p, behind)
            np.testing.assert_allclose(found[:, i], (ahead - behind) / 2e-5, rtol=1e-7, atol=1e-6)


def test_single_stance_converges_with_order_thirteen():
    """The stages of soft legs: 13 in the limit, at least the stage order plus one on the way there."""
    walker = walker_of(changed(TABLE_1, stiffness=300.0, damping=5.0))
    best = fixed_steps(walker, STATE, 1.2, 320)
    errors = np.array([np.abs(fixed_steps(walker, STATE, 1.2, n, take_step=take_step) - best).max() for n in (2, 3, 4)])
    orders = np.log(errors[:-1] / errors[1:]) / np.log([3 / 2, 4 / 3])
    assert errors[-1] > 1e-13, "the finest step must still show its error"
    assert 11.0 < orders[-1] < 15.0, (errors, orders)


def test_estimate_is_not_smaller_than_the_error():
    walker = walker_of(STIFF[0])
    for step in (2e-4, 1e-3, 5e-3):
        stages, new = np.empty((STAGES, 8)), np.empty(8)
        flow(SINGLE_STANCE, STATE, walker.p, stages[0])
        take_step(SINGLE_STANCE, STATE, step, walker.p, stages, new)
        estimate = error_norm(STATE, new, step, walker.p, stages, 1.0)
        error = np.abs(new - fixed_steps(walker, STATE, step, 4000)).max() / 2
        assert error <= estimate + 1e-13


@pytest.mark.parametrize("design", STIFF, ids=lambda d: f"k {d.stiffness:g}, b {d.damping:g}")
def test_stiff_legs_take_implicit_steps_and_few_of_them(design):
    walker, point = stiff_gait(design, 1e-9)
    assert walker.stiff
    assert point.residual <= max(1e-10, np.finfo(float).eps * walker.p.k)  # the spring force's round-off
    assert abs(report_gait(walker, point, 1e-9, FRICTION.static_friction).energy.residual) <= 1e-7
    rate, _ = axial_rates(walker.p)
    stability_limit = point.steps[0].period * rate / 6 * STAGES  # what explicit steps would need at least
    assert poincare_map(walker, point.z, 1e-9).evaluations < stability_limit


def test_step_of_no_length_stays_where_it_is():
    """Event location asks for it where the event is the start of a step."""
    walker, stages, new = walker_of(STIFF[0]), np.empty((STAGES, 8)), np.empty(8)
    flow(SINGLE_STANCE, STATE, walker.p, stages[0])
    take_step(SINGLE_STANCE, STATE, 0.0, walker.p, stages, new)
    np.testing.assert_array_equal(new, STATE)


def test_table_1_takes_explicit_steps():
    assert not walker_of().stiff
    assert not walker_of(changed(STIFF[1], legs="rigid")).stiff


def test_variations_through_implicit_steps_are_the_derivative():
    walker, point = stiff_gait(STIFF[0], 1e-12)
    _, derivative = poincare_derivative(walker, point.z, 1e-12)
    for i, size in enumerate((1e-4, 1e-6, 1e-6, 1e-4, 1e-4)):
        step = size * np.eye(5)[i]
        images = [poincare_map(walker, point.z + factor * step, 1e-12).z for factor in (2, 1, -1, -2)]
        difference = (-images[0] + 8 * images[1] - 8 * images[2] + images[3]) / (12 * size)
        np.testing.assert_allclose(derivative[:, i], difference, atol=1e-6)


def test_implicit_path_agrees_with_an_integrator_of_another_make():
    """SciPy's on lambdified equations, with events of its own."""
    walker, point = stiff_gait(changed(TABLE_1, damping=1.5e3), 1e-11)
    assert walker.stiff
    other = readable_step(walker, point.z, 1e-10)
    np.testing.assert_allclose(other.z, point.z, atol=2e-8)
    assert other.period == pytest.approx(point.steps[0].period, abs=2e-8)
