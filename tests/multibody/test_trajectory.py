"""Interpolation between solver steps, and the kinematics of a foot."""

import dataclasses

import numpy as np
import pytest

from stages.ground.friction import normal_force
from stages.planar.run import Trajectory, foot_kinematics, rolling_state


def polynomial_trajectory(degree, exact):
    time = np.array([0.0, 0.3, 0.4, 1.0])
    shapes = [np.polynomial.Polynomial(np.random.default_rng(column).normal(size=degree + 1)) for column in range(6)]
    rows = [np.column_stack([shape.deriv(order)(time) for shape in shapes]) for order in (0, 1, 2)]
    nothing = np.zeros((4, 2))
    switches = ((0.35, 1, True), (0.6, 0, False))
    return shapes, Trajectory(time, *rows, (True, False), switches, nothing, np.zeros((4, 2, 2)),
                              exact_acceleration=exact)


@pytest.mark.parametrize(("degree", "exact"), [(5, True), (3, False)])
def test_polynomials_are_reproduced_and_one_time_after_another_as_many_at_once(degree, exact):
    shapes, trajectory = polynomial_trajectory(degree, exact)
    time = np.linspace(0.0, 1.0, 101)
    position, velocity = trajectory.at(time)
    assert np.allclose(position, np.column_stack([shape(time) for shape in shapes]), atol=1e-12)
    assert np.allclose(velocity, np.column_stack([shape.deriv()(time) for shape in shapes]), atol=1e-11)
    for row in range(3):
        after, (start, end) = trajectory.after(row), trajectory.time[row : row + 2].tolist()
        for one in np.linspace(start, end, 9)[:-1]:
            assert np.array_equal(after(float(one)), [rows[0] for rows in trajectory.at(np.array([one]))])
        assert np.array_equal(after(end), (trajectory.position[row + 1], trajectory.velocity[row + 1]))


def test_switches_are_kept():
    _, trajectory = polynomial_trajectory(3, False)
    assert trajectory.in_play(np.array([0.0, 0.34, 0.35, 0.7])).tolist() == [
        [True, False],
        [True, False],
        [True, True],
        [False, True],
    ]


def test_rate_of_penetration_is_its_derivative():
    _, trajectory = polynomial_trajectory(5, True)
    time = np.linspace(0.01, 0.99, 20)
    for leg in (0, 1):
        ahead, behind = (foot_kinematics(*trajectory.at(time + step), leg, 0.083)[0] for step in (1e-6, -1e-6))
        rate = foot_kinematics(*trajectory.at(time), leg, 0.083)[1]
        assert np.allclose(rate, (ahead - behind) / 2e-6, atol=1e-7)


def test_the_rolling_state_rolls(biped, contact, rough):
    """No slip at the standing foot, no motion into the ground, and the force asked for."""
    leaning = dataclasses.replace(rough, stance_angle=0.13)
    state = rolling_state(biped, contact, leaning, normal_force=9.4)
    row = np.array([[*state.hip_position, *state.leg_angle, *state.leg_length]])
    motion = np.array([[*state.hip_velocity, *state.leg_rate, *state.leg_length_rate]])
    depth, rate, slip = (value[0] for value in foot_kinematics(row, motion, 0, biped.foot_radius))
    assert abs(rate) < 1e-15 and abs(slip) < 1e-15
    assert normal_force(contact, depth, 0.0) == pytest.approx(9.4, rel=1e-9)
