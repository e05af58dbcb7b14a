"""Frames and specific force."""

import numpy as np
import pytest

from stages.biped.kinematics import leg_axes, specific_force
from stages.ground.slope import Slope


def test_axes_are_orthonormal_and_right_handed():
    forward, upward = leg_axes(np.linspace(-1, 1, 11))
    assert np.allclose((forward * upward).sum(axis=1), 0)
    assert np.allclose(forward[:, 0] * upward[:, 1] - forward[:, 1] * upward[:, 0], 1)


def test_leg_with_its_foot_ahead_has_its_upward_axis_from_foot_to_hip():
    _, upward = leg_axes(np.array([0.3]))
    foot_from_hip = np.array([np.sin(0.3), -np.cos(0.3)])
    assert np.allclose(upward[0], -foot_from_hip)


@pytest.mark.parametrize("slope_deg", [0.0, 2.0, 10.0])
def test_sensor_at_rest_feels_gravity_upward(slope_deg):
    """At rest the accelerometer shows g along the true vertical: magnitude g, and all of it up a plumb leg."""
    slope = Slope(slope_deg=slope_deg, gravity=9.81)
    angles = np.array([0.0, 0.2, -0.4, slope.angle])
    felt = specific_force(np.zeros((4, 2)), angles, slope.gravity_vector)
    assert np.allclose(np.hypot(*felt.T), 9.81)
    assert felt[0] == pytest.approx([-9.81 * np.sin(slope.angle), 9.81 * np.cos(slope.angle)])
    assert felt[3] == pytest.approx([0.0, 9.81], abs=1e-12)


def test_free_fall_feels_nothing():
    slope = Slope(slope_deg=3.0, gravity=9.81)
    felt = specific_force(np.tile(slope.gravity_vector, (3, 1)), np.array([0.0, 0.5, -1.0]), slope.gravity_vector)
    assert np.abs(felt).max() == 0.0
