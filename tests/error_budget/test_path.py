"""The path and its contributions, with made-up outcomes whose parts are known."""

import numpy as np
import pytest

from stages.error_budget.effects import (
    COMPLIANCE,
    CONTACT,
    CREEP,
    EFFECTS,
    INTEGRATION_CONSTRAINT,
    INTEGRATION_PENALTY,
    RAMP,
    SLIP,
    UNEXPLAINED,
    switched,
)
from stages.error_budget.path import Limits, contributions
from stages.error_budget.split import POSITION, VELOCITY, Split
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import friction_coefficient
from stages.ground.normal_force import static_penetration

LAW = ContactLaw(3e5, 2.2, 3e4, 1e-4, 1.1, 1.0, 0.03, 1.0)
CURVE = np.random.default_rng(1).normal(size=(20, 4))


def limits(bend=0.0, interaction=0.0):
    """Outcomes made of creep ~ v_s (with a second order, `bend`), compliance ~ penetration, and both at once."""

    def outcome(law, tolerance):
        creep = law.stiction_velocity / LAW.stiction_velocity
        give = static_penetration(law, 10.0) / static_penetration(LAW, 10.0)
        return (5.0 + tolerance + creep + bend * creep**2 + 2.0 * give + interaction * creep * give) * CURVE

    return Limits(LAW, 0.1, outcome, 1e-3, 1e-3)


def split(path, order=CONTACT):
    found = contributions(
        1.0 * CURVE, 1.1 * CURVE, 4.0 * CURVE, path, path.at(frozenset(CONTACT)) - 0.001 * CURVE, order
    )
    return Split(found, np.ones(len(CURVE), dtype=bool))


@pytest.mark.parametrize("order", (CONTACT, CONTACT[::-1]))
def test_contributions_add_up_to_the_difference_of_the_models(order):
    found = split(limits(bend=0.3, interaction=0.7), order)
    assert found.total == pytest.approx((5.001 + 1.3 + 2.0 + 0.7 - 1.0) * CURVE, rel=1e-12)
    assert len(found.parts) == len(EFFECTS)


def test_effects_of_first_order_are_told_apart_without_a_rest():
    found = split(limits())
    expected = {
        INTEGRATION_CONSTRAINT: 0.1, SLIP: 2.9, UNEXPLAINED: 1.001, CREEP: 1.0, COMPLIANCE: 2.0, RAMP: -0.001,
        INTEGRATION_PENALTY: 0.001,
    }  # fmt: skip
    for effect, size in expected.items():
        assert found.part(effect) == pytest.approx(size * CURVE, abs=1e-12), effect


def test_what_is_left_in_second_order_stays_in_the_rest():
    """2 f(s) - f(2 s) of s^2 is -2 s^2."""
    rest = split(limits(bend=0.3)).part(UNEXPLAINED) - split(limits()).part(UNEXPLAINED)
    assert rest == pytest.approx(-2 * 0.1**2 * 0.3 * CURVE, rel=1e-9)


def test_an_interaction_goes_to_the_effect_switched_on_last():
    forward, backward = (split(limits(interaction=0.7), order) for order in (CONTACT, CONTACT[::-1]))
    assert forward.part(COMPLIANCE) == pytest.approx(2.7 * CURVE, rel=0.03)
    assert backward.part(CREEP) == pytest.approx(1.7 * CURVE, rel=0.03)
    assert backward.part(UNEXPLAINED) == pytest.approx(forward.part(UNEXPLAINED), rel=1e-12)


def test_shares_are_those_of_the_unexplained_rest():
    parts = np.zeros((len(EFFECTS), 3, 4))
    parts[EFFECTS.index(SLIP)] = [[3.0, 4.0, 0.0, 9.0], [3.0, 4.0, 0.0, 9.0], [3.0, 4.0, 99.0, 9.0]]
    parts[EFFECTS.index(UNEXPLAINED), :, 0] = 1.0
    found = Split(parts, np.array([True, True, False]))
    assert found.explained(POSITION) == pytest.approx(1 - 1 / np.hypot(4, 4))
    assert found.explained_peak(POSITION) == pytest.approx(1 - 1 / 4)
    assert found.explained(VELOCITY) == 1.0 and found.peak(found.total, VELOCITY) == 9.0


@pytest.mark.parametrize("share", (0.2, 0.1, 0.01))
def test_an_effect_that_is_off_keeps_its_share(share):
    off = switched(LAW, (), share)
    assert static_penetration(off, 10.0) == pytest.approx(share * static_penetration(LAW, 10.0), rel=1e-9)
    slip = 1e-7
    assert friction_coefficient(off, share * slip) == pytest.approx(friction_coefficient(LAW, slip), rel=1e-4)
    assert off.friction_velocity == 2 * off.stiction_velocity
    assert off.contact_damping * off.damping_depth == pytest.approx(LAW.contact_damping * LAW.damping_depth)


def test_all_effects_on_is_the_law_itself():
    assert switched(LAW, CONTACT, 0.1) == LAW
    assert switched(LAW, (CREEP, RAMP), 0.1).contact_stiffness > LAW.contact_stiffness
    assert switched(LAW, (CREEP, COMPLIANCE), 0.1).damping_depth < LAW.damping_depth
