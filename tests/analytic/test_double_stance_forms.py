"""Double stance in two other index forms is the compiled one, and differentiating the constraints loses nothing."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stages.analytic.integration.readable import accelerations, terms
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.walk.recording import states_at


@pytest.fixture(scope="module")
def start(table_1_gait, table_1_step):
    walker, _ = table_1_gait
    double = table_1_step[0]
    duration = 0.9 * double.duration
    expected = states_at(double.phase, double.times, double.states, np.array([duration]), walker.p)[0]
    return walker, double.states[0], duration, expected


def test_velocity_level_of_the_paper(start):
    """The system the paper solves, by IDA: same motion and same contact forces."""
    walker, y, duration, expected = start
    found, force = velocity_level(walker, y, duration, 1e-10)
    assert np.abs(found - expected).max() <= 1e-7
    assert np.abs(force - accelerations(walker, expected, True)[1]).max() <= 1e-3


def test_motion_along_what_the_constraints_leave_free(start):
    walker, y, duration, expected = start
    found = free_directions(walker, y, duration, 1e-12)
    assert np.abs(found - expected).max() <= 1e-9
    assert np.abs(terms("compliant").constraint_jacobian(found, walker.p).T @ found[4:]).max() <= 1e-10


# --- Double stance in forms that must agree.


def velocity_level(walker: Walker, y: Vector, duration: float, tolerance: float) -> tuple[Vector, Vector]:
    """State and lambda after `duration` with the constraints differentiated once: the paper's form, by IDA.

    Unknowns (q, qd, lambda): dq/dt = qd, M dqd/dt = Q - C qd + Pi lambda, Pi^T qd = 0.
    """
    from sksundae.ida import IDA

    t = terms("compliant")

    def residual(_: float, state: Vector, rate: Vector, out: Vector) -> None:
        here = state[:8]
        pi = t.constraint_jacobian(here, walker.p)
        out[:4] = rate[:4] - state[4:8]
        out[4:8] = t.mass(here, walker.p) @ rate[4:8] - t.force(here, walker.p).ravel() - pi @ state[8:]
        out[8:] = pi.T @ state[4:8]

    qdd, force = accelerations(walker, y, True)
    start, slope = np.concatenate([y, force]), np.concatenate([y[4:], qdd, np.zeros(2)])
    # lambda stays out of the error test: at index 2 its local error is of lower order and would stall the step size
    scale = np.full(10, tolerance)
    scale[8:] = 1e3
    solver = IDA(residual, rtol=tolerance, atol=scale, algebraic_idx=[8, 9], max_num_steps=100_000, first_step=1e-9)
    solution = solver.solve(np.array([0.0, duration]), start, slope)
    if not solution.success:
        raise ArithmeticError(f"IDA: {solution.message}")
    return solution.y[-1, :8], solution.y[-1, 8:]


def free_directions(walker: Walker, y: Vector, duration: float, tolerance: float) -> Vector:
    """State after `duration` of the motion along the null space of Pi^T: velocity constraints hold by construction.

    qd = N u, N^T M N du/dt = N^T (Q - C qd - M (dN/dt) u) with N^T N = 1; the two missing equations for the
    acceleration are the constraints' own, so no lambda appears.
    """
    t = terms("compliant")

    def rate(_: float, state: Vector) -> Vector:
        here = np.concatenate([state[:4], state[4:]])
        pi = t.constraint_jacobian(here, walker.p)
        orthogonal = np.linalg.qr(pi, mode="complete")[0]
        along, null = orthogonal[:, :2], orthogonal[:, 2:]
        qd = null @ (null.T @ state[4:])
        here = np.concatenate([state[:4], qd])
        mass, force = t.mass(here, walker.p), t.force(here, walker.p).ravel()
        # part of the acceleration that turns the free directions, from Pi^T qdd = -dPi^T/dt qd
        turning = along @ np.linalg.solve(pi.T @ along, -t.constraint_bias(here, walker.p).ravel())
        free = null @ np.linalg.solve(null.T @ mass @ null, null.T @ (force - mass @ turning))
        return np.concatenate([qd, turning + free])

    solution: Any = solve_ivp(rate, (0.0, duration), y, method="DOP853", rtol=tolerance, atol=tolerance)
    state: Vector = solution.y[:, -1]
    return state
