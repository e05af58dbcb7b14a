"""What is left of an effect is the share: a foot dropped on the ground sinks in and rebounds as much less."""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stages.ground.contact_law import ContactLaw, family_member, with_creep, with_impact
from stages.ground.friction import friction_coefficient, normal_force, static_penetration

LAW = ContactLaw(3e5, 2.2, 3e4, 1e-4, 1.1, 1.0, 0.03, 1.0)
MASS, SPEED = 0.3, 0.26


def dropped(law):
    """Depth [m] at which a mass is stopped, and the speed [m/s] at which it leaves the ground, or 0 if it stays."""

    def rate(_, state):
        return state[1], -float(normal_force(law, state[0], state[1])) / MASS

    def leaves(_, state):
        return state[0] + 1e-12

    leaves.terminal, leaves.direction = True, -1
    run = solve_ivp(rate, (0.0, 1e-2), (0.0, SPEED), events=leaves, rtol=1e-9, atol=1e-13, method="LSODA")
    return run.y[0].max(), -run.y[1, -1]


@pytest.mark.parametrize("normal", ["impact", "restitution"])
def test_depth_and_rebound_fall_as_the_share(normal):
    law = dataclasses.replace(LAW, normal_force=normal)
    (depth, rebound), (less, slower) = dropped(with_impact(law, 1 / 16)), dropped(with_impact(law, 1 / 32))
    assert rebound / slower == pytest.approx(2.0, rel=0.25)
    assert less < 0.65 * depth


def test_stiffness_alone_throws_the_foot_back():
    stiff = dataclasses.replace(LAW, contact_stiffness=LAW.contact_stiffness * 100)
    assert dropped(stiff)[1] > 2 * dropped(LAW)[1]


def test_a_member_has_the_share_of_static_penetration_and_of_creep_at_a_given_friction():
    slip = np.linspace(-0.02, 0.02, 101)
    assert static_penetration(with_impact(LAW, 0.25), 9.4) == pytest.approx(0.25 * static_penetration(LAW, 9.4))
    assert friction_coefficient(with_creep(LAW, 0.25), 0.25 * slip) == pytest.approx(friction_coefficient(LAW, slip))
    assert family_member(LAW, 0.5) == with_creep(with_impact(LAW, 0.5), 0.5)
    assert family_member(family_member(LAW, 0.5), 2.0) == LAW
