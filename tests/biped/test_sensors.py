"""One definition of what a sensor feels, in the constraint model, the planar checker and the twin.

A sensor feels acceleration minus gravity on the axes of the inner leg. The same motion is given to the kinematics of
each model.
"""

import dataclasses

import numpy as np
import pytest

from pipeline.parameters.loading import load
from stages.biped.kinematics import (
    Coordinate,
    Motion,
    hip_motion,
    shifted,
    specific_force,
    stance_mass_motion,
    swing_point_motion,
)
from stages.contact_study.parameters import Parameters as ContactStudy
from stages.multibody.parameters import Parameters
from stages.multibody.walking.walk import simulate
from stages.planar.run import PlanarState
from stages.stability.parameters import Parameters as Stability
from stages.twin.machine.contact import HINGE, PITCH, SLIDE
from stages.twin.walking.record import pair_axes, point_motion

LENGTH, RADIUS, COM = 0.333, 0.083, 0.1
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


def test_exudyns_own_sensor_feels_what_the_constraint_models_formula_says(repository):
    """A step of the planar checker: its foot sensor against the formula fed with the coordinates it records."""
    known = [Parameters, ContactStudy, Stability]
    given = load(repository / "params", [], {"multibody": Parameters}, known)["multibody"]
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
