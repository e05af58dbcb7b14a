"""The order in which effects vanish with their share: of a mass that lands, and of the walker against its limit."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stages.error_budget.path import switched
from stages.error_budget.result import EACH, ORDER, Convergence, Shares, Split, rms_of_columns
from stages.ground.friction import normal_force

MASS, SPEED = 0.335, 0.264  # of Table 1's leg, and of its landing foot


def landing(law):
    """Largest depth [m] of a mass that lands, and the speed [m/s] with which it leaves the ground again."""

    def motion(time, state):
        return [state[1], -float(normal_force(law, state[0], state[1])) / MASS]

    def leaves(time, state):
        return state[0] + 1e-12

    leaves.terminal, leaves.direction = True, -1
    found = solve_ivp(motion, (0.0, 1.0), [0.0, SPEED], "LSODA", events=leaves, rtol=1e-9, atol=1e-14)
    return float(found.y[0].max()), float(-found.y[1, -1])


def orders(values):
    """Orders in the share of values at shares that halve."""
    return np.log2(np.array(values[:-1]) / np.array(values[1:]))


def test_without_damping_depth_falls_as_e_over_e_plus_one(parameters):
    """So does the depth to which contact of stiffness s^(-e) k_c is pressed if damping plays no part."""
    law = dataclasses.replace(parameters.contact, contact_damping=0.0)
    exponent = law.contact_exponent
    depths = [landing(dataclasses.replace(law, contact_stiffness=law.contact_stiffness * s**-exponent))[0]
              for s in (0.4, 0.2, 0.1)]  # fmt: skip
    assert orders(depths) == pytest.approx(np.full(2, exponent / (exponent + 1.0)), abs=1e-4)


@pytest.mark.parametrize("normal", ("impact", "restitution"))
def test_depth_and_rebound_of_an_impact_that_is_off_fall_with_its_share(parameters, normal):
    """Damped by e/(e+1) only, the mass would leave as fast however hard the contact is: no limit that is plastic."""
    law = dataclasses.replace(parameters.contact, normal_force=normal)
    exponent = law.contact_exponent
    depths, rebounds = zip(*(landing(switched(law, (), share)) for share in (0.4, 0.2, 0.1)))
    assert orders(depths) == pytest.approx(np.full(2, float(ORDER)), abs=0.05)
    assert np.all(orders(rebounds) > 0.9)
    alike = []
    for share in (0.4, 0.1):
        depth = share ** (exponent / (exponent + 1.0))
        alike.append(landing(dataclasses.replace(
            law, contact_stiffness=law.contact_stiffness * share**-exponent,
            contact_damping=law.contact_damping / depth, damping_depth=law.damping_depth * depth))[1])  # fmt: skip
    assert alike[1] == pytest.approx(alike[0], rel=0.05)


@pytest.fixture(scope="module")
def approach(parameters, scene):
    """The walker's hip over a step with both effects off, for shares that halve, and the limit that is expected."""
    law = parameters.contact
    hips = [scene.penalty(switched(law, (), share), 1e-7) for share in (0.4, 0.2, 0.1, 0.05)]
    return hips, scene.coarse_or_fine(1e-12, coulomb=True), scene.compared()


def test_the_walkers_order_and_its_last_share(approach):
    """The first three shares show the order and foretell the fourth, to 2 % of the way that three of them made."""
    hips, _, compared = approach
    found = Convergence.of(0.1, [Shares(*hips[:3])], compared)
    assert found.order[0, 1] == pytest.approx(ORDER, abs=0.1), found.order
    assert found.order[0, 3] == pytest.approx(ORDER, abs=0.15), found.order
    last = rms_of_columns(hips[3] - Shares(hips[1], hips[2], hips[3]).predicted, compared)
    way = rms_of_columns(hips[3] - hips[0], compared)
    assert np.all(last[[1, 3]] < 0.02 * way[[1, 3]]) and np.all(last < 0.2 * way), last / way


def test_the_limit_is_the_constraint_model_with_coulomb_friction(approach, scene):
    """The difference falls with every share, and three shares foretell the limit better than the last of them is."""
    hips, coulomb, compared = approach
    away = [rms_of_columns(hip - coulomb, compared) for hip in hips]
    assert all(np.all(near < far) for far, near in pairwise(away))
    limit = rms_of_columns(Shares(*hips[1:]).limit - coulomb, compared)
    assert np.all(limit < 0.5 * away[-1]), limit / away[-1]
    rolling = rms_of_columns(scene.coarse_or_fine(1e-12) - coulomb, compared)
    assert limit[0] < 0.03 * rolling[0] and limit[2] < 0.03 * rolling[2]


def test_a_share_explained_is_a_share_of_the_rms(approach):
    """1 - rms(left) / rms(whole), each column for itself: the walker's own curves as the only contribution."""
    hips, coulomb, compared = approach
    parts = np.zeros((6, *coulomb.shape))
    parts[2], parts[3] = Shares(*hips[1:]).limit - coulomb, hips[0] - Shares(*hips[1:]).limit
    split = Split(parts, np.zeros_like(coulomb), compared)
    expected = 1.0 - rms_of_columns(parts[2], compared) / rms_of_columns(hips[0] - coulomb, compared)
    assert [split.explained(column) for column in EACH] == pytest.approx(expected, rel=1e-12)
