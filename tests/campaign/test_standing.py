"""The still stand and the push: continuous into the walk, and true to mechanics."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stages.biped.design import Biped
from stages.campaign.twin_run import first_motion, quintic, rolling_leg, stand_and_push
from stages.ground.slope import Slope

BIPED = Biped("compliant", 0.316, 0.335, 0.333, 0.083, 0.1, 2800.0, 58.35, 0.0)
SLOPE = Slope(2.0, 9.81)


@given(st.floats(-0.3, 0.3), st.floats(-3, 3), st.floats(-20, 20), st.floats(0.2, 1.0))
def test_quintic_goes_from_rest_to_its_end(value: float, rate: float, acceleration: float, duration: float) -> None:
    at = quintic(duration, (value, rate, acceleration), np.array([0.0, duration]))
    np.testing.assert_allclose(at[:, 0], 0, atol=1e-12)
    np.testing.assert_allclose(at[:, 1], [value, rate, acceleration], atol=1e-8)


def test_rates_are_the_derivatives() -> None:
    time, leg = stand_and_push(0.01, (0.0, -0.7, 1.5), 0.5, 0.4, 1e-4)
    np.testing.assert_allclose(np.gradient(leg[0], 1e-4)[5:-5], leg[1][5:-5], atol=1e-4)
    np.testing.assert_allclose(np.gradient(leg[1], 1e-4)[5:-5], leg[2][5:-5], atol=1e-2)
    assert time[-1] == pytest.approx(-1e-4)
    assert (leg[0][time < -0.41] == 0.01).all()


def test_at_rest_both_sensors_feel_gravity() -> None:
    time, leg = stand_and_push(np.deg2rad(2.0), (np.deg2rad(2.0), 0.0, 0.0), 0.5, 0.4, 1e-3)
    for sensor in rolling_leg((leg[0], leg[1], leg[2]), BIPED, SLOPE, time):
        np.testing.assert_allclose(sensor.specific_force, np.tile([0, 9.81, 0], (len(time), 1)), atol=1e-12)


def test_specific_force_is_the_second_derivative_of_the_rolling_motion() -> None:
    time = np.arange(0, 0.5, 1e-4)
    phi = 0.2 * np.cos(4 * time)
    leg = (phi, -0.8 * np.sin(4 * time), -3.2 * np.cos(4 * time))
    r, length = BIPED.foot_radius, BIPED.leg_length
    hip = np.stack([-r * phi - (length - r) * np.sin(phi), r + (length - r) * np.cos(phi)], axis=1)
    foot = hip + (length - BIPED.foot_com) * np.stack([np.sin(phi), -np.cos(phi)], axis=1)
    for place, sensor in zip((hip, foot), rolling_leg(leg, BIPED, SLOPE, time)):
        force = np.gradient(np.gradient(place, 1e-4, axis=0), 1e-4, axis=0) - np.array(SLOPE.gravity_vector)
        forward = np.stack([np.cos(phi), np.sin(phi)], axis=1)
        up = np.stack([-np.sin(phi), np.cos(phi)], axis=1)
        expected = np.stack([(force * forward).sum(axis=1), (force * up).sum(axis=1)], axis=1)
        np.testing.assert_allclose(sensor.specific_force[5:-5, :2], expected[5:-5], atol=1e-3)


def test_a_push_does_not_follow_the_blow_in_which_a_rigid_leg_takes_its_load() -> None:
    """The rate jumps by 0.04 rad/s in the first 0.2 ms and falls by 13 rad/s2 from there on."""
    grid, duration = 2e-4, 0.4
    rate = -1.1 - 13.0 * grid * np.arange(200) - 0.04 * (np.arange(200) > 0)
    for blow in (0.0, 0.02):
        end = first_motion(np.full(200, 0.3), rate, grid, blow)
        _, leg = stand_and_push(0.0, end, 0.5, duration, grid)
        assert (np.abs(leg[1]).max() > 3 * abs(end[1])) == (blow == 0.0)
        assert leg[:, -1] == pytest.approx(end, rel=0.2)
