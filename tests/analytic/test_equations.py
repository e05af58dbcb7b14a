"""The generated and compiled equations are the derivation's, unedited."""

import numpy as np
import pytest
import sympy as sp

from stages.analytic.model import derivation as d
from stages.analytic.model.kinds import present
from stages.analytic.phases.motion import (
    DOUBLE_STANCE,
    RIGID,
    SINGLE_STANCE,
    accelerations,
    flow,
)
from tests.analytic.designs import HEAVY_LEGS, TABLE_1_RIGID, changed, double_stance_states, random_states, walker_of

COMPLIANT = walker_of(HEAVY_LEGS)
RIGID_LEGS = walker_of(changed(TABLE_1_RIGID, leg_inertia=2e-3))


@pytest.mark.parametrize("walker", [COMPLIANT, RIGID_LEGS], ids=["compliant", "rigid"])
def test_compiled_acceleration_equals_the_derivation_solved_by_numpy(walker):
    equations = d.derive("rigid" if walker.rigid else "compliant")
    symbols = [list(equations.coordinates) + list(equations.rates), [d.PARAMETERS[name] for name in present(walker.p)]]
    force = equations.applied_force - equations.coriolis * equations.rates
    terms = sp.lambdify(symbols, [equations.mass, force], "numpy")
    numbers = [getattr(walker.p, name) for name in present(walker.p)]
    for y in random_states(walker, 100):
        mass, right = terms(y, numbers)
        expected = np.linalg.solve(mass, right.ravel())
        found, _ = accelerations(RIGID if walker.rigid else SINGLE_STANCE, y, walker.p)
        assert np.allclose(found[:: 2 if walker.rigid else 1], expected, rtol=1e-12, atol=1e-12)


def test_compiled_double_stance_equals_the_bordered_system_solved_by_numpy():
    equations = d.derive("compliant")
    q, qd = equations.coordinates, equations.rates
    jacobian = equations.constraint_jacobian
    bias = d.time_derivative(jacobian, q, qd).T * qd
    force = equations.applied_force - equations.coriolis * qd
    arguments = [list(q) + list(qd), [d.PARAMETERS[name] for name in present(COMPLIANT.p)]]
    terms = sp.lambdify(arguments, [equations.mass, jacobian, force, bias], "numpy")
    numbers = [getattr(COMPLIANT.p, name) for name in present(COMPLIANT.p)]
    for y in double_stance_states(COMPLIANT, 50):
        mass, pi, right, rate = terms(y, numbers)
        bordered = np.block([[mass, -pi], [pi.T, np.zeros((2, 2))]])
        expected = np.linalg.solve(bordered, np.concatenate([right.ravel(), -rate.ravel()]))
        qdd, loads = accelerations(DOUBLE_STANCE, y, COMPLIANT.p)
        assert np.allclose([*qdd, *loads[:2]], expected, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("phase", [RIGID, SINGLE_STANCE, DOUBLE_STANCE])
def test_variations_are_the_derivative_of_the_flow(phase):
    """The rate of a variation equals the change of the rate of the state, by central differences."""
    walker = RIGID_LEGS if phase == RIGID else COMPLIANT
    states = double_stance_states(walker, 20) if phase == DOUBLE_STANCE else random_states(walker, 20)
    size, h = walker.size, 1e-6
    directions = np.random.default_rng(3).normal(size=(20, size))
    for y, direction in zip(states, directions, strict=True):
        both, plus, minus = np.empty(2 * size), np.empty(size), np.empty(size)
        flow(phase, np.concatenate([y, direction]), walker.p, both)
        flow(phase, y + h * direction, walker.p, plus)
        flow(phase, y - h * direction, walker.p, minus)
        expected = (plus - minus) / (2 * h)
        assert np.abs(both[size:] - expected).max() <= 1e-7 * max(1.0, np.abs(expected).max())
