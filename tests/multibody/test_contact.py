"""The compiled contact is the law of stages.ground, on a grid and through a walk."""

import dataclasses

import numpy as np
import pytest

from stages.ground.friction import ARRAYS, SCALARS, normal_force, static_penetration
from stages.ground.laws import FRICTIONS, NORMAL_FORCES
from stages.multibody.assembly.contact import SYMBOLS, disc_force, symbolic
from stages.planar.run import PlanarState, Trajectory, foot_kinematics, rolling_state
from stages.planar.sampling import find_events

LAWS = [(normal, friction) for normal in NORMAL_FORCES for friction in FRICTIONS]


@pytest.fixture
def recording():
    """Operations on symbols build expressions only while recording."""
    before = symbolic.GetRecording()
    symbolic.SetRecording(True)
    yield
    symbolic.SetRecording(before)


def contact_grid():
    generator = np.random.default_rng(7)
    depth = generator.uniform(-1, 1, 2000) * 10.0 ** generator.uniform(-7, -3, 2000)
    slip = generator.normal(size=2000) * 10.0 ** generator.uniform(-5, 0.5, 2000)
    return depth, generator.normal(size=2000) * 0.3, slip, generator.normal(size=2000)


@pytest.mark.parametrize(("normal", "friction"), LAWS)
def test_symbols_floats_and_arrays_agree(recording, contact, normal, friction):
    law = dataclasses.replace(contact, normal_force=normal, friction=friction)
    depth, rate, slip, turn = contact_grid()
    arguments = 0.083 - depth, slip, rate, turn
    names = [symbolic.Real(name, 0.0) for name in ("height", "along", "upward", "turn")]
    expressions = disc_force(law, 0.083, *names, SYMBOLS)
    compiled, plain = [], []
    for row in zip(*arguments):
        for name, value in zip(names, row):
            name.SetValue(float(value))
        compiled.append([expression.Evaluate() for expression in expressions])
        plain.append(disc_force(law, 0.083, *map(float, row), SCALARS))
    arrays = np.column_stack(disc_force(law, 0.083, *arguments, ARRAYS))
    assert np.array_equal(compiled, plain)
    assert np.allclose(arrays, plain, rtol=1e-12, atol=1e-12)
    assert np.count_nonzero(arrays[:, 1]) > 500


def test_a_walk_has_the_same_bits_again_and_with_the_law_in_python(scene, start):
    coarse = scene.but(tolerance=1e-5, largest_step=2e-3)
    first, *others = (
        coarse.walk(start, steps=1, assembly=coarse.build(compiled=compiled)).trajectory
        for compiled in (True, True, False)
    )
    for name in ("time", "position", "velocity", "acceleration", "foot_acceleration", "ground_reaction"):
        assert all(np.array_equal(getattr(first, name), getattr(other, name)) for other in others), name


def test_recorded_forces_are_the_law_at_the_recorded_state(two_steps, biped, contact):
    trajectory = two_steps.trajectory
    held = trajectory.in_play(trajectory.time)
    for leg in (0, 1):
        angle, rate = trajectory.position[:, 2 + leg], trajectory.velocity[:, 2 + leg]
        reach, reach_rate = trajectory.position[:, 4 + leg] - biped.foot_radius, trajectory.velocity[:, 4 + leg]
        height = trajectory.position[:, 1] - reach * np.cos(angle)
        along = trajectory.velocity[:, 0] + reach_rate * np.sin(angle) + reach * rate * np.cos(angle)
        upward = trajectory.velocity[:, 1] - reach_rate * np.cos(angle) + reach * rate * np.sin(angle)
        law = np.column_stack(disc_force(contact, biped.foot_radius, height, along, upward, rate, ARRAYS))
        law[~held[:, leg]] = 0.0
        assert np.allclose(trajectory.ground_reaction[:, leg], law, rtol=0, atol=1e-6)


@pytest.mark.parametrize("assembly", ["tree", "joints"])
def test_standing_still_sinks_to_the_static_penetration(scene, biped, contact, assembly):
    level = scene.but(
        slope_deg=0.0, assembly=assembly, largest_step=1e-3, rolling_step=5e-4, impact_step=5e-4)
    carried = 0.5 * biped.total_mass * level.slope.gravity
    squeezed = 0.5 * biped.hip_mass * level.slope.gravity / biped.stiffness
    standing = PlanarState((0.0, 0.333), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (0.333, 0.333), (0.0, 0.0), (True, True))
    run = level.walk(standing, duration=1.0)
    assert run.completed
    end = run.trajectory.state_at(run.trajectory.time[-1])
    assert end.leg_length == pytest.approx([0.333 - squeezed] * 2, abs=1e-9)
    assert end.leg_length[0] - end.hip_position[1] == pytest.approx(static_penetration(contact, carried), rel=1e-4)
    force = run.trajectory.ground_reaction[-1]
    assert force[:, 1] == pytest.approx([carried] * 2, rel=1e-5) and abs(force[:, 0]).max() < 1e-9


# --- Interpolation between solver steps, and the kinematics of a foot.


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
    assert np.array_equal(trajectory.after(1)(0.35), [rows[0] for rows in trajectory.at(np.array([0.35]))])


def test_switches_are_kept():
    _, trajectory = polynomial_trajectory(3, False)
    assert trajectory.in_play(np.array([0.0, 0.34, 0.35, 0.7])).tolist() == [
        [True, False],
        [True, False],
        [True, True],
        [False, True],
    ]


def test_a_foot_that_touches_at_a_recorded_time_lands_then():
    time, nothing = np.array([0.0, 0.5, 1.0]), np.zeros((3, 6))
    place, motion = np.tile([0.0, 1.0, 0.0, 0.0, 0.5, 0.5], (3, 1)), nothing - [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]
    place[:, 1] -= time
    falling = Trajectory(time, place, motion, nothing, (True, True), (), np.zeros((3, 2)), np.zeros((3, 2, 2)))
    assert find_events(falling, (0.25, 0.25)).heel_strike_time.tolist() == [0.5, 0.5]


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
