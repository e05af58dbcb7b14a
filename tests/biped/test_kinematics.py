"""Kinematics of points on the biped against finite differences of their positions."""

import numpy as np
import pytest

from stages.biped.kinematics import (
    Coordinate,
    constant,
    hip_motion,
    polar_motion,
    rolling_centre,
    shifted,
    stance_mass_motion,
    swing_point_motion,
)

H = 1e-4
TIMES = np.linspace(0.0, 2.0, 41)


def angle(t):
    return 0.3 * np.sin(1.7 * t + 0.2)


def other_angle(t):
    return 0.4 * np.cos(2.1 * t)


def length(t):
    return 0.333 + 0.01 * np.sin(3 * t)


def sampled(function, t=TIMES, h=1e-3):
    """The coordinate with its rates by Richardson-extrapolated central differences."""
    def first(step):
        return (function(t + step) - function(t - step)) / (2 * step)

    def second(step):
        return (function(t + step) - 2 * function(t) + function(t - step)) / step**2

    return Coordinate(function(t), (4 * first(h / 2) - first(h)) / 3, (4 * second(h / 2) - second(h)) / 3)


RADIUS, COM = 0.083, 0.1
MOTIONS = {
    "polar": lambda t: polar_motion(sampled(length, t), sampled(angle, t)),
    "rolling centre": lambda t: rolling_centre(sampled(angle, t), RADIUS, np.full_like(t, 0.5)),
    "hip": lambda t: hip_motion(sampled(angle, t), sampled(length, t), RADIUS, np.full_like(t, 0.5)),
    "stance mass": lambda t: stance_mass_motion(sampled(angle, t), COM, RADIUS, np.full_like(t, 0.5)),
    "swing mass": lambda t: swing_point_motion(
        hip_motion(sampled(angle, t), sampled(length, t), RADIUS, np.full_like(t, 0.5)),
        sampled(other_angle, t), shifted(sampled(length, t), COM)),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_velocity_and_acceleration_are_the_derivatives_of_position(name):
    motion, before, after = (MOTIONS[name](TIMES + shift) for shift in (0.0, -H, H))
    velocity = (after.position - before.position) / (2 * H)
    acceleration = (after.velocity - before.velocity) / (2 * H)
    assert np.abs(motion.velocity - velocity).max() <= 1e-7
    assert np.abs(motion.acceleration - acceleration).max() <= 1e-6


def test_hip_of_eq_7_and_8():
    """Against the paper's formulas as printed."""
    theta, stance = sampled(angle), sampled(length)
    hip = hip_motion(theta, stance, RADIUS, np.full_like(TIMES, 0.7))
    arm = stance.value - RADIUS
    sin, cos = np.sin(theta.value), np.cos(theta.value)
    position = np.column_stack((0.7 + RADIUS * theta.value + arm * sin, RADIUS + arm * cos))
    velocity = np.column_stack((RADIUS * theta.rate + stance.rate * sin + theta.rate * arm * cos,
                                stance.rate * cos - theta.rate * arm * sin))  # fmt: skip
    assert np.allclose(hip.position, position, atol=1e-15) and np.allclose(hip.velocity, velocity, atol=1e-14)


def test_rolling_foot_does_not_slip():
    """The contact point, at the bottom of the foot, is at rest: centre velocity = radius times the leg's rate."""
    theta = sampled(angle)
    foot = rolling_centre(theta, RADIUS, np.zeros_like(TIMES))
    assert np.allclose(foot.velocity[:, 0] - RADIUS * theta.rate, 0, atol=1e-15)
    assert (foot.position[:, 1] == RADIUS).all() and (foot.velocity[:, 1] == 0).all()


def test_foot_bottom_is_one_leg_length_from_the_hip():
    theta, leg = sampled(angle), constant(0.333, sampled(angle))
    hip = hip_motion(theta, leg, RADIUS, np.zeros_like(TIMES))
    mass = stance_mass_motion(theta, COM, RADIUS, np.zeros_like(TIMES))
    assert np.allclose(np.linalg.norm(hip.position - mass.position, axis=1), 0.333 - COM, atol=1e-15)
