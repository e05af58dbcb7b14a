"""Kinematics of points, frames, and the one definition of what a sensor feels."""

import dataclasses

import numpy as np
import pytest

from stages.biped.kinematics import (
    Coordinate,
    Motion,
    hip_motion,
    polar_motion,
    rolling_centre,
    shifted,
    specific_force,
    stance_mass_motion,
    swing_point_motion,
)
from stages.ground.slope import Slope
from stages.multibody.walking.walk import simulate
from stages.planar.run import PlanarState
from stages.twin.machine.contact import HINGE, PITCH, SLIDE
from stages.twin.walking.record import pair_axes, point_motion
from tests.study import parameters_of

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


# --- Frames and specific force.


@pytest.mark.parametrize("slope_deg", [0.0, 2.0, 10.0])
def test_sensor_at_rest_feels_gravity_upward(slope_deg):
    """At rest the accelerometer shows g along the true vertical: magnitude g, and all of it up a plumb leg."""
    slope = Slope(slope_deg=slope_deg, gravity=9.81)
    angles = np.array([0.0, 0.2, -0.4, slope.angle])
    felt = specific_force(np.zeros((4, 2)), angles, slope.gravity_vector)
    assert np.allclose(np.hypot(*felt.T), 9.81)
    assert felt[0] == pytest.approx([-9.81 * np.sin(slope.angle), 9.81 * np.cos(slope.angle)])
    assert felt[3] == pytest.approx([0.0, 9.81], abs=1e-12)


# --- One definition of what a sensor feels, in the constraint model, the planar checker and the twin.


LENGTH = 0.333
TIME = np.linspace(0.0, 2.0, 41)
GRAVITY = (0.34, -9.8)


def coordinate(offset, size, speed):
    """A sine with its exact rates."""
    wave = speed * TIME + offset
    return Coordinate(offset + size * np.sin(wave), size * speed * np.cos(wave), -size * speed**2 * np.sin(wave))


ANGLE, LEG = coordinate(0.1, 0.3, 3.0), coordinate(LENGTH, 0.01, 7.0)


def test_standing_and_swinging_legs_carry_the_same_socket():
    """The constraint model has a formula for each; on a rolling leg both give the same point."""
    origin = np.zeros_like(TIME)
    theta = Coordinate(-ANGLE.value, -ANGLE.rate, -ANGLE.second_rate)
    hip = hip_motion(theta, LEG, RADIUS, origin)
    standing = stance_mass_motion(theta, COM, RADIUS, origin)
    swinging = swing_point_motion(hip, ANGLE, shifted(LEG, COM))
    for name in ("position", "velocity", "acceleration"):
        assert getattr(standing, name) == pytest.approx(getattr(swinging, name), abs=1e-12)


@pytest.mark.parametrize("foot", [False, True])
def test_the_twins_sockets_feel_what_the_constraint_models_do(foot):
    hip_x, hip_y = coordinate(0.4, 0.2, 2.0), coordinate(0.33, 0.01, 5.0)
    q, v, a = (np.zeros((len(TIME), 11)) for _ in range(3))
    slide = Coordinate(LENGTH - LEG.value, -LEG.rate, -LEG.second_rate)
    for column, moved in ((0, hip_x), (1, hip_y), (PITCH, ANGLE), (HINGE, hip_x), *((s, slide) for s in SLIDE)):
        q[:, column], v[:, column], a[:, column] = moved.value, moved.rate, moved.second_rate
    hip = Motion(*(np.column_stack(pair) for pair in zip(*(vars(c).values() for c in (hip_x, hip_y)), strict=True)))
    point = swing_point_motion(hip, ANGLE, shifted(LEG, COM)) if foot else hip
    expected = specific_force(point.acceleration, ANGLE.value, GRAVITY)
    axes = pair_axes(q, v, a, 0)
    place = np.array([0.0, COM - LENGTH if foot else 0.0, 0.0])
    motion = point_motion(q, v, a, axes, place, SLIDE[0] if foot else None)
    felt = axes.components(motion.acceleration - np.array([*GRAVITY, 0.0]))
    assert felt[:, :2] == pytest.approx(expected, abs=1e-11) and abs(felt[:, 2]).max() < 1e-12
    assert axes.components(axes.spin)[:, 2] == pytest.approx(ANGLE.rate)


def test_exudyns_own_sensor_feels_what_the_constraint_models_formula_says():
    """A step of the planar checker: its foot sensor against the formula fed with the coordinates it records."""
    given = parameters_of("multibody")
    state = PlanarState(
        (0.0, 0.330985), (0.235, 0.0), (0.0, 0.27), (-0.71, 1.8), (0.331, 0.334), (0.0, 0.0), (True, False)
    )
    settings = dataclasses.replace(given.settings, assembly="tree", tolerance=1e-8)
    walked = simulate(given.biped, given.slope, given.contact, state, settings, steps=1).trajectory
    rows = (walked.position, walked.velocity, walked.acceleration)
    angle, leg = (Coordinate(*(row[:, column] for row in rows)) for column in (2, 4))
    foot = swing_point_motion(Motion(*(row[:, :2] for row in rows)), angle, shifted(leg, given.biped.foot_com))
    later = slice(2, None)  # an explicit solver reports no acceleration at its start
    assert walked.foot_acceleration[later] == pytest.approx(foot.acceleration[later], rel=1e-6, abs=1e-6)
