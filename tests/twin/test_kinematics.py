"""Kinematics of points against finite differences, and of sensors against the planar definition."""

import numpy as np
import pytest

from stages.twin.walking.record import pair_axes, point_motion

H = 1e-4


def states(time):
    """A smooth motion of all coordinates and its first two derivatives."""
    k = np.arange(11)
    speed, scale = 1.0 + 0.3 * k, 0.3 / (1.0 + k)
    angle = time[:, None] * speed + k
    return scale * np.sin(angle), scale * speed * np.cos(angle), -scale * speed**2 * np.sin(angle)


@pytest.mark.parametrize(("pair", "slide"), [(0, None), (0, 6), (0, 7), (1, None), (1, 9), (1, 10)])
def test_velocity_and_acceleration_are_derivatives(pair, slide):
    time = np.linspace(0.0, 2.0, 7)
    place = np.array([0.02, -0.2, 0.07])

    def motion(t):
        q, v, a = states(t)
        return point_motion(q, v, a, pair_axes(q, v, a, pair), place, slide)

    now, before, after = motion(time), motion(time - H), motion(time + H)
    assert now.velocity == pytest.approx((after.position - before.position) / (2 * H), abs=1e-7)
    assert now.acceleration == pytest.approx((after.velocity - before.velocity) / (2 * H), abs=1e-6)


@pytest.mark.parametrize("pair", [0, 1])
def test_axes_turn_with_the_spin(pair):
    time = np.linspace(0.0, 2.0, 7)
    now, before, after = (pair_axes(*states(t), pair) for t in (time, time - H, time + H))
    for axis in ("forward", "upward", "lateral"):
        change = (getattr(after, axis) - getattr(before, axis)) / (2 * H)
        assert change == pytest.approx(np.cross(now.spin, getattr(now, axis)), abs=1e-7)
    assert now.spin_rate == pytest.approx((after.spin - before.spin) / (2 * H), abs=1e-6)


def test_planar_pose_has_the_axes_of_the_walk():
    q = np.zeros((1, 11))
    q[0, 5], q[0, 8] = 0.3, -0.5
    for pair, angle in ((0, 0.3), (1, -0.2)):
        axes = pair_axes(q, 0 * q, 0 * q, pair)
        assert axes.forward[0] == pytest.approx([np.cos(angle), np.sin(angle), 0.0])
        assert axes.upward[0] == pytest.approx([-np.sin(angle), np.cos(angle), 0.0])
        assert axes.lateral[0] == pytest.approx([0.0, 0.0, 1.0])
