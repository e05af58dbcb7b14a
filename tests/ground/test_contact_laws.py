"""Properties of the contact laws, over the whole register: limits, continuity, oddness, sign of the losses."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.integrate import solve_ivp

from stages.biped.quantity import faults
from stages.ground.contact_law import ContactLaw, family_member, with_creep, with_impact
from stages.ground.friction import (
    ARRAYS,
    SCALARS,
    friction_coefficient,
    friction_slope,
    normal_force,
    static_penetration,
)
from stages.ground.laws import FRICTIONS, NORMAL_FORCES, damping_factor

ADAMS = ContactLaw(
    contact_stiffness=1e5,
    contact_exponent=2.2,
    contact_damping=1e4,
    damping_depth=1e-4,
    static_friction=1.1,
    dynamic_friction=1.0,
    stiction_velocity=0.1,
    friction_velocity=1.0,
)
NORMAL_LAWS = [dataclasses.replace(ADAMS, normal_force=name) for name in NORMAL_FORCES]
FRICTION_LAWS = [dataclasses.replace(ADAMS, friction=name) for name in FRICTIONS]
all_normal = pytest.mark.parametrize("law", NORMAL_LAWS, ids=lambda law: law.normal_force)
all_friction = pytest.mark.parametrize("law", FRICTION_LAWS, ids=lambda law: law.friction)


def adams_step(x, x0, h0, x1, h1):
    """STEP as the Adams manual writes it, piece by piece."""
    s = (x - x0) / (x1 - x0)
    return np.where(x <= x0, h0, np.where(x >= x1, h1, h0 + (h1 - h0) * s**2 * (3 - 2 * s)))


def test_the_step_is_the_cubic_of_adams():
    s = np.linspace(-0.5, 1.5, 4001)
    assert np.allclose(ARRAYS.step(s, 1.0, 1.0), adams_step(s, 0, 0, 1, 1), atol=4e-16, rtol=0)
    assert SCALARS.step(0.0, 1.0, 1.0) == 0.0 and SCALARS.step(1.0, 1.0, 1.0) == 1.0
    assert [SCALARS.rise(u, 1.0, 1.0) for u in (-1.0, 0.0, 1.0)] == [-1.0, 0.0, 1.0]


def test_stiffness_in_si_units():
    assert ADAMS.stiffness_si == pytest.approx(3.98107e11, rel=1e-6)
    one_millimetre = dataclasses.replace(ADAMS, contact_damping=0.0)
    assert normal_force(one_millimetre, 1e-3, 0.0) == pytest.approx(1e5, rel=1e-12)


def test_impact_is_the_formula_of_the_paper_where_it_does_not_pull():
    depth = np.linspace(1e-6, 3e-4, 200)[:, None]
    rate = np.linspace(-0.4, 0.4, 81)[None, :]
    raw = ADAMS.stiffness_si * depth**2.2 + adams_step(depth, 0, 0, 1e-4, 1e4) * rate
    assert np.allclose(normal_force(ADAMS, depth, rate), np.maximum(raw, 0.0), rtol=1e-12, atol=1e-10)
    assert raw.min() < -1000.0  # the maximum matters on this grid


def test_stribeck_is_the_piecewise_law_of_adams():
    slip = np.linspace(-2.0, 2.0, 8001)
    speed = np.abs(slip)
    creeping = adams_step(slip, -0.1, -1.1, 0.1, 1.1)
    sliding = np.sign(slip) * adams_step(speed, 0.1, 1.1, 1.0, 1.0)
    expected = np.where(speed < 0.1, creeping, sliding)
    assert np.allclose(friction_coefficient(ADAMS, slip), expected, atol=1e-15, rtol=0)


@all_normal
@settings(max_examples=100, deadline=None)
@given(gap=st.floats(0.0, 1.0), rate=st.floats(-5.0, 5.0))
def test_no_force_out_of_contact(law, gap, rate):
    assert normal_force(law, -gap, rate, SCALARS) == 0.0


@all_normal
@settings(max_examples=100, deadline=None)
@given(depth=st.floats(0.0, 1e-2), rate=st.floats(-5.0, 5.0))
def test_the_ground_never_pulls_and_its_damping_never_gives_energy(law, depth, rate):
    force = normal_force(law, depth, rate, SCALARS)
    elastic = law.stiffness_si * depth**law.contact_exponent
    assert force >= 0.0
    assert (force - elastic) * rate >= -1e-12 * elastic * abs(rate)


@all_normal
def test_normal_force_grows_with_depth_and_rate(law):
    depth, rate = np.linspace(0.0, 5e-4, 400), np.linspace(0.0, 1.0, 50)
    force = normal_force(law, depth[:, None], rate[None, :])
    assert np.all(np.diff(force, axis=0) > 0.0)
    assert np.all(np.diff(force, axis=1) >= 0.0) and np.all(np.diff(force[1:], axis=1) > 0.0)


@all_normal
@pytest.mark.parametrize("rate", [-0.5, 0.0, 0.5])
def test_normal_force_is_continuous(law, rate):
    depth = np.linspace(-1e-5, 3e-4, 200_001)
    jumps = np.abs(np.diff(normal_force(law, depth, np.full_like(depth, rate))))
    slope = law.stiffness_si * law.contact_exponent * 3e-4 ** (law.contact_exponent - 1) * 20 + 1.5 * 1e4 / 1e-4
    assert jumps.max() < slope * (depth[1] - depth[0])


@all_normal
@pytest.mark.parametrize("force", [1e-3, 10.0, 500.0])
def test_static_penetration_carries_the_force(law, force):
    assert normal_force(law, static_penetration(law, force), 0.0) == pytest.approx(force, rel=1e-12)


@all_friction
def test_friction_is_odd_bounded_and_against_the_slip(law):
    slip = np.concatenate([np.logspace(-12, 2, 3000), [0.05, 0.1, 0.55, 1.0]])
    forward, backward = friction_coefficient(law, slip), friction_coefficient(law, -slip)
    assert np.array_equal(forward, -backward)
    assert friction_coefficient(law, 0.0) == 0.0
    assert np.all(forward * slip >= 0.0) and forward.max() <= law.static_friction


def test_friction_limits():
    stribeck, coulomb, none = (dataclasses.replace(ADAMS, friction=name) for name in ("stribeck", "coulomb", "none"))
    assert friction_coefficient(stribeck, 0.1) == 1.1 and friction_coefficient(stribeck, 7.0) == 1.0
    assert friction_coefficient(coulomb, 7.0) == 1.1
    assert friction_coefficient(none, 7.0) == 0.0
    assert friction_coefficient(stribeck, 1e-6) / 1e-6 == pytest.approx(1.5 * 1.1 / 0.1, rel=1e-6)


@all_friction
def test_the_rigid_limit_has_what_is_left_of_the_law_without_creep(law):
    slip, almost = np.logspace(-9, 1, 30_000), with_creep(law, 1e-6)
    found = friction_coefficient(almost, slip)
    assert found.max() == pytest.approx(law.coefficients.static_friction, rel=1e-4)
    assert found[-1] == law.coefficients.dynamic_friction


def test_a_rule_between_numbers_that_a_law_does_not_use_is_none():
    """Coulomb's law of one coefficient was refused for a dynamic friction above it, which it does not have."""
    wrong = {"static_friction": 0.5, "dynamic_friction": 0.9, "friction_velocity": 0.01}
    keys = {name: [one.key for one in dataclasses.replace(ADAMS, friction=name, **wrong).broken_rules()]
            for name in FRICTIONS}  # fmt: skip
    assert keys == {"stribeck": ["dynamic_friction", "stiction_velocity"], "coulomb": [], "none": []}


@all_friction
def test_friction_is_continuous_and_steepest_at_rest(law):
    slip = np.linspace(-1.5, 1.5, 300_001)
    change = np.abs(np.diff(friction_coefficient(law, slip)))
    assert change.max() <= 1.5 * 1.1 / 0.1 * (slip[1] - slip[0]) * (1 + 1e-9)


@all_friction
@settings(max_examples=100, deadline=None)
@given(angle=st.floats(0.0, 6.3), speed=st.floats(0.0, 3.0))
def test_friction_in_two_directions_points_along_the_slip(law, angle, speed):
    x, z = speed * np.cos(angle), speed * np.sin(angle)
    slope = friction_slope(law.numbers, x, z, SCALARS)
    assert slope * speed == pytest.approx(friction_coefficient(law, speed, SCALARS), abs=1e-9)


@all_friction
def test_friction_in_two_directions_is_finite_at_rest(law):
    at_rest, creeping = (friction_slope(law.numbers, x, 0.0, SCALARS) for x in (0.0, 1e-6))
    assert np.isfinite(at_rest) and at_rest == pytest.approx(creeping, rel=1e-6)


@pytest.mark.parametrize("key", ["normal_force", "friction"])
def test_an_unknown_law_is_refused_by_its_name(key):
    (fault,) = faults(dataclasses.replace(ADAMS, **{key: "glue"}))
    assert (fault.key == key and "restitution" in fault.allowed) or "coulomb" in fault.allowed
    with pytest.raises(KeyError, match="glue"):
        _ = dataclasses.replace(ADAMS, **{key: "glue"}).numbers


@settings(max_examples=100, deadline=None)
@given(restitution=st.floats(0.05, 1.0), speed=st.floats(0.01, 10.0))
def test_restitution_factor_solves_its_equation(restitution, speed):
    x = damping_factor(restitution, speed) * speed
    y = restitution * x
    assert x - np.log1p(x) == pytest.approx(-y - np.log1p(-y), rel=1e-7, abs=1e-12)


@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.9, 1.0])
@pytest.mark.parametrize("mass", [0.3, 30.0])
def test_a_ball_bounces_back_with_the_restitution(restitution, mass):
    law = dataclasses.replace(ADAMS, normal_force="restitution", restitution=restitution, impact_speed=0.3)
    assert dropped(law, mass, 0.3)[1] == pytest.approx(restitution * 0.3, rel=1e-4)


def test_feet_that_share_a_law_act_as_it():
    half = ADAMS.shared_by(2)
    assert 2 * normal_force(half, 3e-5, 0.1) == pytest.approx(normal_force(ADAMS, 3e-5, 0.1), rel=1e-14)
    assert half.static_friction == ADAMS.static_friction


# --- What is left of an effect is the share: a foot that lands sinks in and rebounds as much less.


LAW = ContactLaw(3e5, 2.2, 3e4, 1e-4, 1.1, 1.0, 0.03, 1.0)
MASS, SPEED = 0.335, 0.264  # of Table 1's leg, and of its landing foot


def dropped(law, mass=MASS, speed=SPEED):
    """Largest depth [m] of a mass that lands, and the speed [m/s] at which it leaves the ground, or 0 if it stays."""

    def rate(_, state):
        return state[1], -float(normal_force(law, state[0], state[1])) / mass

    def leaves(_, state):
        return state[0] + 1e-12

    leaves.terminal, leaves.direction = True, -1
    run = solve_ivp(rate, (0.0, 1.0), (0.0, speed), events=leaves, rtol=1e-9, atol=1e-14, method="LSODA")
    return run.y[0].max(), -run.y[1, -1]


def orders(values):
    """Orders in the share of values at shares that halve."""
    return np.log2(np.array(values[:-1]) / np.array(values[1:]))


def test_without_damping_depth_falls_as_e_over_e_plus_one():
    """So does the depth to which contact of stiffness s^(-e) k_c is pressed if damping plays no part."""
    law, exponent = dataclasses.replace(LAW, contact_damping=0.0), LAW.contact_exponent
    depths = [dropped(dataclasses.replace(law, contact_stiffness=law.contact_stiffness * s**-exponent))[0]
              for s in (0.4, 0.2, 0.1)]  # fmt: skip
    assert orders(depths) == pytest.approx(np.full(2, exponent / (exponent + 1.0)), abs=1e-4)


@pytest.mark.parametrize("normal", ("impact", "restitution"))
def test_depth_and_rebound_of_an_impact_fall_with_its_share(normal):
    """Damped by e/(e+1) only, the mass would leave as fast however hard the contact is: no limit that is plastic."""
    law, exponent = dataclasses.replace(LAW, normal_force=normal), LAW.contact_exponent
    depths, rebounds = zip(*(dropped(with_impact(law, share)) for share in (0.4, 0.2, 0.1)))
    assert orders(depths) == pytest.approx([1.0, 1.0], abs=0.05)
    assert np.all(orders(rebounds) > 0.9)
    alike = []
    for share in (0.4, 0.1):
        depth = share ** (exponent / (exponent + 1.0))
        alike.append(dropped(dataclasses.replace(
            law, contact_stiffness=law.contact_stiffness * share**-exponent,
            contact_damping=law.contact_damping / depth, damping_depth=law.damping_depth * depth))[1])  # fmt: skip
    assert alike[1] == pytest.approx(alike[0], rel=0.05)


def test_stiffness_alone_throws_the_foot_back():
    stiff = dataclasses.replace(LAW, contact_stiffness=LAW.contact_stiffness * 100)
    assert dropped(stiff)[1] > 2 * dropped(LAW)[1]


def test_a_member_has_the_share_of_static_penetration_and_of_creep_at_a_given_friction():
    slip = np.linspace(-0.02, 0.02, 101)
    assert static_penetration(with_impact(LAW, 0.25), 9.4) == pytest.approx(0.25 * static_penetration(LAW, 9.4))
    assert friction_coefficient(with_creep(LAW, 0.25), 0.25 * slip) == pytest.approx(friction_coefficient(LAW, slip))
    assert family_member(LAW, 0.5) == with_creep(with_impact(LAW, 0.5), 0.5)
    assert family_member(family_member(LAW, 0.5), 2.0) == LAW
