"""Compliant legs as their stiffness grows.

The limit is a walker with rigid legs, but not the one whose trailing foot leaves the ground without an impulse: in the
compliant model both feet keep rolling through the impact (model.md, trap 4), and only then do the legs stop their axial
motion. That limit is composed here from the two impacts, and the compliant gaits tend to it with first order in
1 / sqrt(stiffness) when the damping ratio is kept.
"""


import numpy as np
import pytest

from stages.analytic.gait.poincare import fixed_point
from stages.analytic.integration.phase import EVENT, NO_NODES, integrate
from stages.analytic.model import terms as eq
from stages.analytic.phases.impact import heel_strike_reset
from stages.analytic.phases.motion import RIGID
from tests.analytic.designs import TABLE_1, TABLE_1_RIGID, changed, walker_of


def limit_reset(y):
    """Both feet rolling through the landing, legs free along themselves; then the new stance foot alone rolls and
    the legs become rigid: axial velocities vanish, angular momenta of both legs' motions are kept."""
    full = np.array([y[0], 1.0, y[1], 1.0, y[2], 0.0, y[3], 0.0])
    p = walker_of(TABLE_1).p  # stiffness and damping do not enter an impact
    heel_strike_reset(full, p)
    t = eq.compliant_terms(*full[:4], 0.0, 0.0, 0.0, 0.0, p)
    mass = np.zeros((4, 4))
    mass[np.triu_indices(4)] = t[:10]
    mass += np.triu(mass, 1).T
    angles = [0, 2]
    rates = np.linalg.solve(mass[np.ix_(angles, angles)], (mass @ full[4:])[angles])
    return np.array([full[0], full[2], *rates])


def limit_step(walker, z):
    y = np.array([z[0], -abs(z[0]), z[1], z[2]])
    status, period, *_ = integrate(RIGID, y, walker.p, 1e-12, 30.0, 10_000, 0.02, NO_NODES)
    assert status == EVENT
    after = limit_reset(y)
    return after[[0, 2, 3]], period


@pytest.fixture(scope="module")
def limit():
    """Stance angle, and period, of the limit's gait: a stable gait, reached by walking."""
    walker = walker_of(TABLE_1_RIGID)
    z = np.array([-0.277, 0.42, -0.31])
    for _ in range(120):
        z, period = limit_step(walker, z)
    assert np.abs(limit_step(walker, z)[0] - z).max() <= 1e-11
    return z[0], period


def stiffened(count):
    """Gaits from 1e5 N/m on, stiffness times ten each, damping ratio kept."""
    z = np.array([-0.2769, 1.000066, 0.99987, 0.47385, -0.2048])
    gaits = []
    for stiffness in 1e5 * 10.0 ** np.arange(count):
        damping = 58.35 * np.sqrt(stiffness / 2800.0)
        walker = walker_of(changed(TABLE_1, stiffness=stiffness, damping=damping))
        z[1:3] = 1 + np.array([walker.p.m, -(walker.p.M + walker.p.m) / 2]) / walker.p.k
        point = fixed_point(walker, z, 1e-9)
        assert point is not None
        gaits.append(point)
        z = point.z.copy()
    return gaits


def test_compliant_gait_tends_to_the_rigid_limit_with_its_order(limit):
    angle, period = limit
    gaits = stiffened(4)
    errors = np.array([abs(point.steps[0].period - period) for point in gaits])
    orders = np.log10(errors[1:-1] / errors[2:]) * 2  # in powers of 1 / sqrt(k)
    assert errors[-1] <= 1e-4
    assert orders[-1] == pytest.approx(1.0, abs=0.35), (errors, orders)
    assert abs(gaits[-1].z[0] - angle) <= 1e-5


def test_the_limit_is_not_the_gait_without_impulse_on_the_trailing_foot(limit, rigid_gait):
    """Stated so that nobody takes the one rigid model for the limit of the compliant one: 0.4% in period."""
    _, free = rigid_gait
    assert 2e-3 < abs(limit[1] / free.steps[0].period - 1) < 1e-2


def test_stiff_dampers_have_the_same_limit(limit):
    walker = walker_of(changed(TABLE_1, damping=1e5))
    point = fixed_point(walker, np.array([-0.2772, 0.99843, 0.99836, 0.475, -0.2054]), 1e-9)
    assert point is not None
    # the legs stand a little shorter than natural: compare in their own lengths
    assert point.z[0] == pytest.approx(limit[0], abs=2e-4)
