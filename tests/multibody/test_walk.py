"""A walk of the multibody model: energy, momentum, convergence, two assemblies, failures that are told."""

import dataclasses

import numpy as np
import pytest

from pipeline.parameters.loading import load
from stages.contact_study.parameters import Parameters as ContactStudy
from stages.multibody.parameters import Parameters
from stages.multibody.walking.walk import build, simulate
from stages.multibody.walking.watch import Look, Watch
from stages.planar.energy import energy_balance, mass_moment
from stages.planar.run import DIVERGED, FELL, SOLVER_FAILED, STALLED, STEP_FLOOR, PlanarState
from stages.planar.sampling import find_events, sample


@pytest.fixture(scope="module")
def walk(two_steps, slope, biped):
    return sample(two_steps.trajectory, biped, slope, 2000.0)


def test_two_steps_are_walked(two_steps, walk):
    assert two_steps.completed and two_steps.heel_strikes == 2
    assert walk.heel_strike_leg.tolist() == [1, 0] and walk.toe_off_leg.tolist() == [0, 1]
    assert np.all(walk.toe_off_time > walk.heel_strike_time)
    assert walk.time[1] == pytest.approx(1 / 2000.0) and walk.time[-1] <= two_steps.trajectory.time[-1]


def test_losses_add_up_to_the_work_of_gravity(two_steps, walk, biped, slope, contact):
    start, end = walk.heel_strike_time
    balance = energy_balance(two_steps.trajectory, biped, slope, contact, start, end)
    assert balance.relative_residual < 1e-6
    assert min(balance.leg_damper_loss, balance.contact_damping_loss, balance.friction_loss) > 0.0


def test_ground_reaction_changes_the_momentum(two_steps, biped, slope):
    """Impulse of the recorded forces and of gravity equals the change of momentum over the whole walk."""
    trajectory = two_steps.trajectory
    impulse = np.trapezoid(trajectory.ground_reaction.sum(axis=1), trajectory.time, axis=0)
    span = trajectory.time[-1] - trajectory.time[0]
    ends, step = trajectory.time[[0, -1]], 1e-5
    earlier = mass_moment(biped, trajectory.at(np.array([ends[0], ends[1] - step]))[0])
    later = mass_moment(biped, trajectory.at(np.array([ends[0] + step, ends[1]]))[0])
    momentum = (later - earlier) / step
    expected = momentum[1] - momentum[0] - biped.total_mass * np.array(slope.gravity_vector) * span
    assert impulse == pytest.approx(expected, abs=2e-3)


def test_sensors_feel_the_motion_they_ride_on(walk, slope, biped):
    """Specific force is the derivative of velocity less gravity, on the leg's axes; here away from the impacts."""
    quiet = np.ones(len(walk.time), dtype=bool)
    for strike in walk.heel_strike_time:
        quiet &= np.abs(walk.time - strike) > 0.03
    acceleration = np.gradient(walk.hip_velocity, walk.time, axis=0) - np.array(slope.gravity_vector)
    angle = walk.leg_angle[:, 0]
    forward = acceleration[:, 0] * np.cos(angle) + acceleration[:, 1] * np.sin(angle)
    upward = -acceleration[:, 0] * np.sin(angle) + acceleration[:, 1] * np.cos(angle)
    inside = quiet & (walk.time > 0.02) & (walk.time < walk.time[-1] - 0.01)
    assert np.abs(walk.hip_specific_force[inside, 0] - forward[inside]).max() < 0.02
    assert np.abs(walk.hip_specific_force[inside, 1] - upward[inside]).max() < 0.02
    arm = walk.leg_length[:, 0] - biped.foot_com
    foot = walk.hip_position + np.column_stack([arm * np.sin(angle), -arm * np.cos(angle)])
    acceleration = np.gradient(np.gradient(foot, walk.time, axis=0), walk.time, axis=0) - np.array(slope.gravity_vector)
    forward = acceleration[:, 0] * np.cos(angle) + acceleration[:, 1] * np.sin(angle)
    assert np.abs(walk.foot_specific_force[inside, 0] - forward[inside]).max() < 0.05
    assert np.array_equal(walk.hip_angular_velocity, walk.leg_rate[:, 0])


def test_feet_are_loaded_only_between_heel_strike_and_toe_off(walk):
    strike, off = walk.heel_strike_time[0], walk.toe_off_time[1]
    loaded = walk.ground_reaction[:, 1, 1] > 0.0
    stance = (walk.time > strike) & (walk.time < off)
    rounding = 1e-9  # of the located events
    apart = (walk.time < strike - rounding) | (walk.time > off + rounding)
    assert not loaded[apart].any() and loaded[stance].mean() > 0.95
    assert walk.ground_reaction[:, :, 1].min() >= 0.0


def test_reruns_have_the_same_bits(biped, slope, contact, start, settings):
    coarse = dataclasses.replace(settings, tolerance=1e-5, largest_step=2e-3)
    one, two = (simulate(biped, slope, contact, start, coarse).trajectory for _ in range(2))
    for name in ("time", "position", "velocity", "acceleration", "foot_acceleration", "ground_reaction"):
        assert np.array_equal(getattr(one, name), getattr(two, name)), name


def test_a_walk_can_be_resumed(two_steps, biped, slope, contact, start, settings):
    first = simulate(biped, slope, contact, start, settings, steps=1)
    rest = simulate(biped, slope, contact, first.last_state, settings, steps=1)
    assert rest.completed
    joined = first.trajectory.time[-1] + rest.trajectory.time[-1] - 1e-3
    whole = two_steps.trajectory.at(np.array([joined]))[0]
    parts = rest.trajectory.at(np.array([rest.trajectory.time[-1] - 1e-3]))[0]
    assert np.abs(whole - parts).max() < 1e-8


def end_of(run):
    state = run.last_state
    assert run.completed
    return np.array([*state.hip_position, *state.leg_angle, *state.leg_length])


def test_explicit_solver_converges_at_fifth_order(biped, slope, contact, start, settings):
    """Over a smooth span, with a tolerance so wide that the largest step rules."""
    fine = dataclasses.replace(settings, tolerance=1e-11, largest_step=1e-4)
    reference = end_of(simulate(biped, slope, contact, start, fine, duration=0.1))
    errors = []
    for step in (8e-4, 4e-4, 2e-4):
        loose = dataclasses.replace(settings, tolerance=1e-3, largest_step=step)
        errors.append(np.abs(end_of(simulate(biped, slope, contact, start, loose, duration=0.1)) - reference).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 4.7)


def test_implicit_solver_converges_at_second_order_through_heel_strike(biped, slope, contact, start, settings):
    time = np.linspace(0.0, 0.2, 2000)
    reference = simulate(biped, slope, contact, start, settings, duration=0.2).trajectory.at(time)[0]
    errors = []
    for refinement in (1, 2, 4):
        steps = {"rolling_step": 1.2e-3 / refinement, "impact_step": 6e-5 / refinement}
        jointed = dataclasses.replace(settings, assembly="joints", **steps)
        run = simulate(biped, slope, contact, start, jointed, duration=0.2)
        errors.append(np.abs(run.trajectory.at(time)[0] - reference).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([2.0, 2.0], abs=0.2)


@pytest.mark.parametrize("solver", ["trapezoidal", "generalized_alpha"])
def test_the_two_assemblies_agree(two_steps, biped, slope, contact, start, settings, solver):
    jointed = dataclasses.replace(
        settings, assembly="joints", implicit_solver=solver, rolling_step=3e-4, impact_step=1.5e-5)
    run = simulate(biped, slope, contact, start, jointed, steps=1)
    assert run.completed and run.joint_drift < 1e-7
    time = np.linspace(0.0, run.trajectory.time[-1] - 1e-3, 3000)
    difference = run.trajectory.at(time)[0] - two_steps.trajectory.at(time)[0]
    assert np.abs(difference[:, :2]).max() < 1e-6


@pytest.mark.slow
def test_the_two_assemblies_agree_over_ten_steps(biped, slope, contact, start, settings):
    one = simulate(biped, slope, contact, start, settings, steps=10)
    fine = dataclasses.replace(settings, assembly="joints", rolling_step=1e-4, impact_step=5e-6)
    two = simulate(biped, slope, contact, start, fine, steps=10)
    time = np.linspace(0.0, one.trajectory.time[-1] - 1e-3, 20_000)
    difference = one.trajectory.at(time)[0] - two.trajectory.at(time)[0]
    assert np.abs(difference[:, :2]).max() < 1e-6


@pytest.fixture(scope="module")
def chosen(repository):
    """The contact set of the study's own ground.yaml."""
    return load(repository / "params", [], {"multibody": Parameters}, [Parameters, ContactStudy])["multibody"].contact


@pytest.mark.slow
@pytest.mark.parametrize("ground", ["contact", "chosen"])
def test_a_hundred_steps_settle_and_stay_with_the_same_bits(ground, request, biped, slope, start, settings):
    """No fall; after the transient neither period nor length of a step drifts; a rerun has the same bits."""
    law, fast = request.getfixturevalue(ground), dataclasses.replace(settings, tolerance=1e-8)
    one, two = (simulate(biped, slope, law, start, fast, steps=100) for _ in range(2))
    assert one.completed and one.heel_strikes == 100
    strikes = find_events(one.trajectory, biped.foot_radii).heel_strike_time
    periods, lengths = np.diff(strikes), np.diff(one.trajectory.at(strikes)[0][:, 0])
    assert np.ptp(periods[-60:]) < 1e-7 and np.ptp(lengths[-60:]) < 1e-7
    for name in ("time", "position", "velocity", "ground_reaction"):
        assert np.array_equal(getattr(one.trajectory, name), getattr(two.trajectory, name)), name


@pytest.mark.parametrize("assembly", ["tree", "joints"])
def test_a_fall_is_told_with_the_last_valid_state(biped, slope, contact, start, settings, assembly):
    pushed_back = dataclasses.replace(start, hip_velocity=(-0.6, 0.0), leg_rate=(2.0, 0.0))
    coarse = dataclasses.replace(
        settings, assembly=assembly, tolerance=1e-6, largest_step=2e-3, rolling_step=5e-4, impact_step=5e-5)
    run = simulate(biped, slope, contact, pushed_back, coarse)
    assert run.outcome == FELL and "fell at t =" in run.message
    assert run.last_state.hip_position[1] < 0.6 * biped.leg_length
    assert np.all(np.isfinite(run.trajectory.position))


def test_standing_still_is_told(biped, slope, contact, settings):
    level = dataclasses.replace(slope, slope_deg=0.0)
    upright = (0.0, 0.0)
    standing = PlanarState((0.0, 0.33299), upright, upright, upright, (0.333, 0.333), (0.0, 0.0), (True, True))
    run = simulate(biped, level, contact, standing, dataclasses.replace(settings, longest_step=0.2))
    assert run.outcome == STALLED and run.trajectory.time[-1] == pytest.approx(0.2, abs=2e-3)


def test_a_state_that_is_not_finite_is_told(biped, slope, contact, start, settings):
    run = simulate(biped, slope, contact, dataclasses.replace(start, hip_velocity=(1e200, 0.0)), settings)
    assert run.outcome in (DIVERGED, FELL, STEP_FLOOR)
    assert np.all(np.isfinite(run.trajectory.position))


def test_a_newton_iteration_that_fails_is_told(biped, slope, contact, start, settings):
    coarse = dataclasses.replace(settings, assembly="joints", rolling_step=1e-2, impact_step=1e-2)
    hard = dataclasses.replace(contact, contact_stiffness=1e12, damping_depth=1e-9)
    run = simulate(biped, slope, hard, start, coarse)
    assert run.outcome == SOLVER_FAILED and run.message
    assert np.all(np.isfinite(run.trajectory.position))


def test_a_solver_that_gets_nowhere_is_stopped(start):
    class Frozen:
        def look(self):
            return Look(0.33, (0.0, 0.1), (0.0, 0.0), (0.0, 0.0), 1.09)

        def leg_rate(self, leg):
            return 0.0

        def set_in_play(self, leg, acts):
            pass

    watch = Watch(Frozen(), 0.5 * 0.333, 3.0, 2, in_play=[True, False], landed=[True, False])
    with pytest.raises(RuntimeError, match=r"gets nowhere at its smallest step, t = 0\.5 s"):
        for _ in range(1000):
            watch(None, 0.5)
    assert watch.outcome == STEP_FLOOR


def test_residuals_of_implicit_steps_are_counted(biped, slope, contact, start, settings):
    """As often as the contact's law is called, written in Python, for each foot; Newton's iterations are most of it."""
    joints = dataclasses.replace(settings, assembly="joints", rolling_step=1e-3, impact_step=2e-5)
    machine, made = build(biped, slope, contact, joints, compiled=False, signals=()), []
    for connector, law in zip(machine.contacts, machine.laws, strict=True):
        counted = lambda *given, law=law: (made.append(1), law(*given))[1]  # noqa: E731
        machine.mbs.SetObjectParameter(connector, "springForceTorqueUserFunction", counted)
    run = simulate(biped, slope, contact, start, joints, duration=0.15, assembly=machine)
    assert run.completed and run.evaluations > 3 * run.solver_steps
    assert len(made) / 2 == pytest.approx(run.evaluations, abs=2)
