"""Structure of the derived equations: what mechanics demands of M, C, K and the constraints, whatever the numbers."""

from functools import cache

import numpy as np
import pytest
import sympy as sp

from stages.analytic.model import derivation as d
from stages.analytic.model.kinds import present
from tests.analytic.designs import HEAVY_LEGS, TABLE_1_RIGID, changed, random_states, walker_of

LEGS = ("compliant", "rigid")
WALKERS = {"compliant": walker_of(HEAVY_LEGS), "rigid": walker_of(changed(TABLE_1_RIGID, leg_inertia=2e-3))}
each_kind = pytest.mark.parametrize("legs", LEGS)
equations_of = cache(d.derive)


def numeric(legs, expression):
    """A function (state, p) of an expression or matrix."""
    equations = equations_of(legs)
    symbols = list(equations.coordinates) + list(equations.rates)
    names = present(WALKERS[legs].p)
    numbers = [getattr(WALKERS[legs].p, name) for name in names]
    function = sp.lambdify([symbols, [d.PARAMETERS[name] for name in names]], expression, "numpy")
    return lambda y: np.asarray(function(y, numbers), dtype=float)


@each_kind
def test_mass_matrix_is_symmetric_and_positive_definite(legs):
    mass = numeric(legs, equations_of(legs).mass)
    for y in random_states(WALKERS[legs], 200):
        value = mass(y)
        assert np.abs(value - value.T).max() <= 1e-15
        np.linalg.cholesky(value)


@each_kind
def test_coriolis_matrix_makes_mass_rate_minus_twice_it_skew(legs):
    """dM/dt - 2 C is skew, so that C qd does no work: the C of eq. (6) is the right one, not merely the right C qd."""
    equations = equations_of(legs)
    rate = d.time_derivative(equations.mass, equations.coordinates, equations.rates)
    skew = numeric(legs, rate - 2 * equations.coriolis)
    for y in random_states(WALKERS[legs], 50):
        value = skew(y)
        assert np.abs(value + value.T).max() <= 1e-14


@each_kind
def test_equations_of_motion_are_those_of_lagrange(legs):
    """M qdd + C qd - Q equals d/dt dT/dqd - dT/dq + dV/dq + damping for the energies, derived the other way."""
    equations = equations_of(legs)
    kinetic, potential = d.energies(equations)
    q, qd, qdd = equations.coordinates, equations.rates, equations.accelerations
    momentum = sp.Matrix([kinetic]).jacobian(qd).T
    lagrange = momentum.jacobian(q) * qd + momentum.jacobian(qd) * qdd - sp.Matrix([kinetic - potential]).jacobian(q).T
    for length, rate in ((d.L1, d.dL1), (d.L2, d.dL2)):
        if length in list(q):
            lagrange[list(q).index(length)] += d.b * rate
    newton = equations.mass * qdd + equations.coriolis * qd - equations.applied_force
    acceleration = dict(zip(qdd, np.random.default_rng(1).normal(size=len(qdd)), strict=True))
    difference = numeric(legs, (lagrange - newton).subs(acceleration))
    for y in random_states(WALKERS[legs], 30):
        assert np.abs(difference(y)).max() <= 1e-11


@each_kind
def test_constraint_rate_is_the_velocity_of_the_second_foot(legs):
    """Eqs. (3)-(5): Pi^T qd is (rise of the foot's centre, slip of its contact point) by finite differences."""
    walker, equations = WALKERS[legs], equations_of(legs)
    rate = numeric(legs, equations.constraint_jacobian.T * equations.rates)
    radius, size = walker.p.r, walker.size // 2

    def foot(y):
        theta, psi = y[0], y[1 if legs == "rigid" else 2]
        stance, swing = (1.0, 1.0) if legs == "rigid" else (y[1], y[3])
        hip = [radius * theta + (stance - radius) * np.sin(theta), radius + (stance - radius) * np.cos(theta)]
        centre = hip[0] + (swing - radius) * np.sin(psi), hip[1] - (swing - radius) * np.cos(psi)
        return np.array([centre[1], centre[0] + radius * psi])

    h = 1e-6
    for y in random_states(walker, 20):
        step = np.concatenate([y[size:], np.zeros(size)])
        found = (foot(y + h * step) - foot(y - h * step)) / (2 * h)
        assert np.abs(found - rate(y).ravel()).max() <= 1e-9


def test_rigid_terms_are_the_compliant_ones_with_lengths_held():
    q = equations_of("compliant").coordinates
    rows = [list(q).index(d.theta), list(q).index(d.psi)]
    held = {d.L1: d.L_nat, d.L2: d.L_nat, d.dL1: 0, d.dL2: 0}
    for name in ("mass", "coriolis"):
        block = getattr(equations_of("compliant"), name).extract(rows, rows).subs(held)
        assert (block - getattr(equations_of("rigid"), name)).applyfunc(sp.simplify) == sp.zeros(2, 2)
