"""The path and its contributions, with made-up outcomes whose parts are known."""

import numpy as np
import pytest

from stages.error_budget.path import Limits, contributions, switched
from stages.error_budget.result import (
    CONTACT,
    CREEP,
    EACH,
    EFFECTS,
    IMPACT,
    INTEGRATION_CONSTRAINT,
    INTEGRATION_PENALTY,
    POSITION,
    SLIP,
    UNEXPLAINED,
    VELOCITY,
    Split,
    telescoped,
)
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import friction_coefficient, static_penetration

LAW = ContactLaw(3e5, 2.2, 3e4, 1e-4, 1.1, 1.0, 0.03, 1.0)
CURVE = np.random.default_rng(1).normal(size=(20, 4))
EVERYWHERE = np.ones(len(CURVE), dtype=bool)


def limits(bend=0.0, interaction=0.0, cube=0.0):
    """Outcomes made of creep ~ v_s (with higher orders), impact ~ penetration, and both at once."""

    def outcome(law, tolerance):
        creep = law.stiction_velocity / LAW.stiction_velocity
        give = static_penetration(law, 10.0) / static_penetration(LAW, 10.0)
        powers = creep + bend * creep**2 + cube * creep**3
        return (5.0 + tolerance + powers + 2.0 * give + interaction * creep * give) * CURVE

    return Limits(LAW, 0.1, outcome, 1e-3, 1e-3)


def split(path):
    both = path.at(frozenset(CONTACT)) - 0.001 * CURVE
    return Split(*contributions(1.0 * CURVE, 1.1 * CURVE, 4.0 * CURVE, path, both), EVERYWHERE)


def test_contributions_add_up_to_the_difference_of_the_models():
    found = split(limits(bend=0.3, interaction=0.7, cube=0.2))
    expected = pytest.approx((5.001 + 1.5 + 2.0 + 0.7 - 1.0) * CURVE, rel=1e-12)
    assert found.total == expected and len(found.parts) == len(EFFECTS)
    assert all(parts.sum(axis=0) == expected for parts in found.orders)


def test_effects_that_do_not_act_on_each_other_are_told_apart_without_a_rest():
    found = split(limits(bend=0.3))
    expected = {
        INTEGRATION_CONSTRAINT: 0.1, SLIP: 2.9, UNEXPLAINED: 1.001, CREEP: 1.3 - 0.0005, IMPACT: 2.0 - 0.0005,
        INTEGRATION_PENALTY: 0.001,
    }  # fmt: skip
    for effect, size in expected.items():
        assert found.part(effect) == pytest.approx(size * CURVE, abs=1e-12), effect


def test_the_third_order_stays_in_the_rest():
    """(8 f(s) - 6 f(2 s) + f(4 s)) / 3 of s^3 is 8 s^3."""
    rest = split(limits(cube=0.3)).part(UNEXPLAINED) - split(limits()).part(UNEXPLAINED)
    assert rest == pytest.approx(8 * 0.1**3 * 0.3 * CURVE, rel=1e-9)


def test_an_interaction_is_halved_and_widens_the_interval():
    """Switched on in either order, one after the other, the effects come out at the interval's ends."""
    path, plain = limits(interaction=0.7), split(limits())
    found = split(path)
    for effect in CONTACT:
        assert found.part(effect) - plain.part(effect) == pytest.approx(0.35 * CURVE, abs=1e-12)
    neither, whole = path.at(frozenset()), path.at(frozenset(CONTACT)) - 0.001 * CURVE
    for parts, first in zip(found.orders, CONTACT):
        last = next(effect for effect in CONTACT if effect != first)
        steps = telescoped([neither, path.at(frozenset({first})), whole])
        for effect, step in zip((first, last), steps):
            assert parts[EFFECTS.index(effect)] == pytest.approx(step, abs=1e-12)
            low, high = found.interval(effect)
            assert np.all((low <= step + 1e-12) & (step <= high + 1e-12))
            assert high - low == pytest.approx((0.7 - 0.001) * np.abs(CURVE), rel=1e-9)


def test_order_and_last_share_are_those_of_the_outcomes():
    """An effect of first order: order 1, the last share foretold; one that bends: not, by 2 s^2 of the bend."""
    for bend, missed in ((0.0, 0.0), (0.3, 0.3 * (0.1**2 - 1.5 * 0.2**2 + 0.5 * 0.4**2))):
        path = limits(bend=bend)
        split(path)
        found = path.convergence(lambda outcome: outcome, EVERYWHERE)
        expected = np.log2((0.2 + 0.12 * bend) / (0.1 + 0.03 * bend))
        assert found.order[2] == pytest.approx(np.full(4, expected)), "creep off"
        assert found.missed[2] == pytest.approx(missed * np.sqrt((CURVE**2).mean(axis=0)), abs=1e-12)
        assert found.order[1] == pytest.approx(np.ones(4)), "impact off"
        assert found.missed[1] == pytest.approx(np.zeros(4), abs=1e-12)


def test_shares_are_those_of_the_unexplained_rest():
    parts = np.zeros((len(EFFECTS), 3, 4))
    parts[EFFECTS.index(SLIP)] = [[3.0, 4.0, 0.0, 9.0], [3.0, 4.0, 0.0, 9.0], [3.0, 4.0, 99.0, 9.0]]
    parts[EFFECTS.index(UNEXPLAINED), :, 0] = 1.0
    found = Split(parts, np.zeros((3, 4)), np.array([True, True, False]))
    assert found.explained(POSITION) == pytest.approx(1 - 1 / np.hypot(4, 4))
    assert found.explained(VELOCITY) == 1.0 and found.peak(found.total, VELOCITY) == 9.0
    assert [found.explained(column) for column in EACH[:2]] == pytest.approx([0.75, 1.0])
    assert found.along(found.part(SLIP), POSITION) == pytest.approx((3 * 4 + 4 * 4) / np.hypot(4, 4))
    assert sum(found.along(part, POSITION) for part in parts) == pytest.approx(np.hypot(4, 4))


def test_all_effects_on_is_the_law_itself():
    assert switched(LAW, CONTACT, 0.1) == LAW
    assert switched(LAW, (CREEP,), 0.1).contact_stiffness > LAW.contact_stiffness
    assert switched(LAW, (IMPACT,), 0.1).stiction_velocity < LAW.stiction_velocity


@pytest.mark.parametrize("share", (0.2, 0.1, 0.01))
def test_an_effect_that_is_off_keeps_its_share(share):
    off, slip = switched(LAW, (), share), 1e-7
    assert static_penetration(off, 10.0) == pytest.approx(share * static_penetration(LAW, 10.0), rel=1e-9)
    assert friction_coefficient(off, share * slip) == pytest.approx(friction_coefficient(LAW, slip), rel=1e-4)
    assert off.friction_velocity == 2 * off.stiction_velocity
