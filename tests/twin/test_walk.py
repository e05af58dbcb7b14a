"""The walking twin: symmetry, energy, failure, signals, the planar checker, its ground; rigid legs are rigid."""

import dataclasses

import numpy as np
import pytest

from stages.biped.between_steps import uniform_times
from stages.biped.rubber import soled
from stages.ground.friction import SCALARS, static_penetration
from stages.ground.laws import FRICTIONS, NORMAL_FORCES
from stages.multibody.assembly import solver
from stages.multibody.assembly.contact import disc_force
from stages.multibody.assembly.solver import explicit_settings
from stages.multibody.parameters import Settings as PlanarSettings
from stages.multibody.walking.walk import simulate
from stages.planar.run import FELL, rolling_state
from stages.planar.section import section_numbers, section_state
from stages.twin.machine.contact import (
    COUNT,
    HINGE,
    PITCH,
    ROLL,
    SLIDE,
    YAW,
    X,
    Y,
    Z,
    along,
    clearances,
    feet_forces,
    feet_places,
    point_law,
)
from stages.twin.machine.machine import Build, build, join, under_foot
from stages.twin.machine.projection import machine_of
from stages.twin.machine.tree import ConnectorTree, SpatialTree
from stages.twin.parameters import SIGNALS
from stages.twin.walking.measures import energy_balance
from stages.twin.walking.record import find_events, pair_axes, peak_force, point_motion, sample
from stages.twin.walking.simulate import rolling_start
from stages.twin_ladder.cycle import SectionState, step_map
from tests.twin.conftest import ROUGH, STANDING_FORCE

MIRRORED = np.array([1, 1, -1, -1, -1, 1, 1, 1, 1, 1, 1])
SWAPPED = [0, 1, 2, 3, 4, 5, 7, 6, 8, 10, 9]


@pytest.fixture(scope="module")
def signals(three_steps, parameters):
    times = uniform_times(three_steps.time[-1], 1000.0)
    return sample(three_steps, times, dataclasses.replace(parameters.settings, signals=SIGNALS))


def test_symmetric_start_stays_in_the_plane(three_steps):
    assert three_steps.completed
    assert abs(three_steps.position[:, [Z, YAW, ROLL]]).max() < 1e-9


def test_mirrored_start_gives_mirrored_motion(machine, settings, walk_from):
    """To round-off until it decides on the length of a step, as left and right are summed in another order; from there
    on within the solver's tolerance."""
    push = {"yaw": 0.02, "yaw_rate": 0.1, "roll_rate": 0.05, "sideways": 0.01}
    record, mirror = (walk_from(machine, 2, push={name: sign * value for name, value in push.items()})
                      for sign in (1.0, -1.0))  # fmt: skip
    assert record.completed and abs(record.position[:, Z]).max() > 1e-3
    time = np.linspace(0.0, min(record.time[-1], mirror.time[-1]), 300)
    apart = abs(record.at(time)[0] - (mirror.at(time)[0] * MIRRORED)[:, SWAPPED]).max(axis=1)
    both = min(len(record.time), len(mirror.time))
    alike = int(np.argmax(np.append(abs(record.time[:both] - mirror.time[:both]) > 1e-9, True)))
    assert alike > 100 and apart[time < record.time[alike - 1]].max() < 1e-3 * settings.tolerance
    assert apart.max() < settings.tolerance


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_evaluations_are_those_that_were_made(machine, parameters, walk_from, tolerance):
    """Steps that error control rejects cost too: counted in the force that the solver calls."""
    tree, made = SpatialTree(machine, parameters.slope, parameters.contact), []
    inner = tree.pushed
    counted = lambda *given: (made.append(1), inner(*given))[1]  # noqa: E731
    tree.mbs.SetObjectParameter(tree.tree, "forceUserFunction", counted)
    record = walk_from(machine, 1, tree=tree, tolerance=tolerance)
    assert record.completed and len(made) > 7 * (len(record.time) - 1)
    assert abs(len(made) - record.evaluations) <= 16  # the solver's first look at the system


def test_last_stage_tells_the_acceleration_at_a_steps_end(three_steps, machine, walk_from, monkeypatch):
    """To the last bit what Exudyn evaluates there when it is asked to, which is an eighth of the work."""

    def asked(*given: float) -> object:
        wanted = explicit_settings(*given)
        wanted.timeIntegration.explicit.computeEndOfStepAccelerations = True
        return wanted

    monkeypatch.setattr(solver, "explicit_settings", asked)
    again = walk_from(machine, 1, tolerance=1e-7)
    rows = len(again.time) - 1  # the first walk goes on
    assert rows > 100 and abs(again.acceleration).max() > 100.0
    for mine, theirs in zip((again.time, *again.steps), (three_steps.time, *three_steps.steps), strict=True):
        assert np.array_equal(mine[:rows], theirs[:rows])


LOSSES = ("ground_loss", "leg_damper_loss", "bearing_loss")


@pytest.mark.parametrize(("legs", "changes", "there"), [
    ("compliant", {}, 2), ("compliant", {"bearing_friction": 1e-4, "slider_friction": 5.0}, 3),
    ("rigid", {"tolerance": 1e-7, "largest_step": 1e-3}, 1)])
def test_energy_balances(parameters, walk_from, legs, changes, there):
    """Friction in bearings and sliders is accounted for; rigid legs have no dampers."""
    settings = dataclasses.replace(parameters.settings, **changes)
    record = walk_from(build(dataclasses.replace(parameters.biped, legs=legs), settings), 2, **changes)
    balance = energy_balance(record, *find_events(record).heel_strike_time[-2:])
    assert balance.gravity_work > 0.03 and balance.relative_residual < 1e-4
    assert [getattr(balance, loss) > 1e-5 for loss in LOSSES] == [number < there for number in range(3)]


def test_legs_that_differ_begin_as_long_as_the_simple_model_has_them(parameters):
    """On an outsole too, which lengthens both; and each spring as loaded as its own leg's."""
    design = dataclasses.replace(parameters.biped, other_leg_length=parameters.biped.leg_length + 4e-4)
    stance = dataclasses.replace(ROUGH[False], swing_length=ROUGH[False].swing_length + 4e-4)
    for outsole in (0.0, 2e-3):
        machine = machine_of(design, dataclasses.replace(parameters.settings, outsole=outsole))
        start = rolling_start(machine, parameters.contact, stance, STANDING_FORCE)
        lengths = machine.length - start.position[list(SLIDE)] - outsole
        assert lengths == pytest.approx(np.repeat([stance.stance_length, stance.swing_length], 2), abs=1e-12)


def test_a_start_off_mid_stance_rolls_on_its_inner_feet(parameters):
    """As pressed in as its force has it, where it would be had it rolled there, and without slip."""
    machine = machine_of(parameters.biped, parameters.settings)
    stance = dataclasses.replace(ROUGH[False], stance_angle=0.2, stance_length_rate=0.05)
    start = rolling_start(machine, parameters.contact, stance, STANDING_FORCE)
    here, later = (feet_places(start.position + time * start.velocity, machine.feet)[:2] for time in (0.0, 1e-7))
    radius, depth = parameters.biped.foot_radius, static_penetration(parameters.contact, STANDING_FORCE)
    assert here[:, 0] == pytest.approx(radius * 0.2, abs=1e-12) and here[:, 1] == pytest.approx(-depth, abs=1e-12)
    rates = (later - here) / 1e-7
    assert rates[:, 0] == pytest.approx(radius * stance.stance_rate, abs=1e-6)
    assert rates[:, 1] == pytest.approx(0.0, abs=1e-6)


def test_energy_balances_with_all_that_a_hip_may_have(parameters, walk_from):
    """Spring, damper and Coulomb friction between the frames, and a counterweight that gravity pulls at."""
    hip = {"hip_stiffness": 0.05, "hip_rest_angle": 0.02, "hip_damping": 0.001, "hip_friction": 0.002,
           "hip_gravity_mass": parameters.biped.hip_mass + 0.1}  # fmt: skip
    design = dataclasses.replace(parameters.biped, **hip)
    record = walk_from(machine_of(design, parameters.settings), 2)
    strikes = find_events(record).heel_strike_time[-2:]
    balance = energy_balance(record, *strikes)
    assert balance.gravity_work > 0.03 and balance.bearing_loss > 1e-3 and balance.relative_residual < 1e-4
    bare = dataclasses.replace(record, machine=dataclasses.replace(
        record.machine, hip_stiffness=0.0, hip_friction=0.0, hip_weight=0.0))  # fmt: skip
    assert energy_balance(bare, *strikes).relative_residual > 1e-2


def test_events_come_in_turn(three_steps):
    events = find_events(three_steps)
    assert events.heel_strike_leg.tolist() == [1, 0, 1]
    assert events.toe_off_leg.tolist() == [0, 1, 0]
    assert (events.toe_off_time > events.heel_strike_time).all()


def test_sockets_in_the_plane_feel_what_the_simple_models_report(signals):
    walk = signals.walk
    assert signals.hip_imu_specific_force[:, :2] == pytest.approx(walk.hip_specific_force, abs=1e-9)
    assert signals.foot_imu_specific_force[:, :2] == pytest.approx(walk.foot_specific_force, abs=1e-9)
    assert abs(signals.hip_imu_specific_force[:, 2]).max() < 1e-6
    assert signals.hip_imu_angular_velocity[:, 2] == pytest.approx(walk.hip_angular_velocity)
    assert abs(signals.hip_imu_angular_velocity[:, :2]).max() < 1e-8


def test_the_largest_force_is_that_of_dense_samples(three_steps, parameters):
    times = uniform_times(three_steps.time[-1], 2e5)
    dense = sample(three_steps, times, dataclasses.replace(parameters.settings, signals=("ground_reaction",)))
    assert peak_force(three_steps) == pytest.approx(dense.walk.ground_reaction[:, :, 1].max(), rel=5e-3)


def test_a_hard_push_to_the_side_topples(machine, walk_from):
    record = walk_from(machine, 5, push={"sideways": 1.0}, tolerance=1e-5)
    assert record.outcome == FELL and "toppled sideways" in record.reason


def test_the_same_run_gives_the_same_bits(machine, walk_from):
    first, second = (walk_from(machine, 1, push={"yaw": 0.01}) for _ in range(2))
    assert first.position.tobytes() == second.position.tobytes()


def test_outsole_and_build_tolerance_reach_the_machine(parameters, machine):
    departure = Build(body_mass=(1.0, 1.1, 1.0, 1.0, 1.0, 1.0), leg_length=(0.001, 0.0, 0.0, 0.0), outsole=0.002)
    built = build(parameters.biped, parameters.settings, departure)
    assert built.radius == pytest.approx(machine.radius + 0.002)
    assert built.length == pytest.approx(machine.length + [0.003, 0.002, 0.002, 0.002])
    rubber = parameters.settings.mass(parameters.biped.foot_radius, 0.002)
    assert built.bodies[1].mass == pytest.approx(1.1 * machine.bodies[1].mass + rubber)
    assert built.bodies[2].mass == pytest.approx(machine.bodies[2].mass + rubber)
    assert built.bodies[0].mass == machine.bodies[0].mass


def test_an_outsole_has_the_mass_of_its_rubber(parameters, machine):
    """Two feet of a leg carry 9.9 g in 2 mm; in the plane the machine is the simple model with leg and sole as one."""
    settings = dataclasses.replace(parameters.settings, outsole=0.002, inertia="planar")
    built, simple = build(parameters.biped, settings), parameters.biped
    mass = 2.0 * settings.mass(simple.foot_radius, 0.002)
    assert built.mass == pytest.approx(simple.total_mass + 2.0 * mass) and mass == pytest.approx(9.856e-3)
    whole = soled(simple, settings, 0.002, mass)
    for pair in (built.bodies[1:3], built.bodies[4:6]):
        leg = join(pair)
        assert leg.mass == pytest.approx(whole.foot_mass)
        assert leg.centre == pytest.approx([0.0, whole.foot_com - whole.leg_length, 0.0], abs=1e-12)
        assert sum(foot.inertia[2, 2] for foot in pair) == pytest.approx(whole.leg_inertia)
        assert pair[0].centre[2] == pytest.approx(-pair[1].centre[2])
    massless = build(simple, dataclasses.replace(settings, outsole_density=0.0))
    assert massless.mass == pytest.approx(simple.total_mass)


def test_an_outsole_is_as_wide_as_the_foot(parameters):
    """Its mean square distance from the foot's middle is that of points spread evenly over the width."""
    sole = under_foot(1, parameters.biped, parameters.settings, 0.002)
    width = np.linspace(-0.5, 0.5, 10001) * parameters.settings.foot_width
    across = 0.5 * (sole.inertia[0, 0] + sole.inertia[1, 1] - sole.inertia[2, 2]) / sole.mass
    assert across == pytest.approx(np.mean(width**2), rel=1e-3)


@pytest.fixture
def planar(parameters):
    """A machine that is the planar model, that model, its start, and settings alike for both."""

    def alike(legs, steps, tolerance):
        changes = {"inertia": "planar", "tolerance": tolerance, "largest_step": 5e-4}
        biped = dataclasses.replace(parameters.biped, legs=legs)
        machine = build(biped, dataclasses.replace(parameters.settings, **changes))
        solver = PlanarSettings(tolerance, "tree", steps, 2000.0, 5e-4, "trapezoidal", 2e-4, 1e-5, 0.02, 3.0)
        state = rolling_state(biped, parameters.contact, ROUGH[machine.rigid], STANDING_FORCE)
        return machine, (biped, parameters.slope, parameters.contact), state, solver, changes

    return alike


@pytest.mark.parametrize(("legs", "steps", "tolerance"), [
    ("compliant", 2, 1e-7), ("rigid", 2, 1e-9), pytest.param("compliant", 5, 1e-9, marks=pytest.mark.slow)])
def test_planar_equivalent_reproduces_the_planar_checker(planar, walk_from, legs, steps, tolerance):
    """Same contact law, same start, two assemblies: the hips stay together."""
    machine, model, state, solver, changes = planar(legs, steps, tolerance)
    checker, twin = simulate(*model, state, solver).trajectory, walk_from(machine, steps, **changes)
    time = np.linspace(0.0, min(checker.time[-1], twin.time[-1]), 1000)
    assert time[-1] > 0.46 * steps
    assert abs(checker.at(time)[0][:, :2] - twin.at(time)[0][:, :2]).max() < 1e-7
    assert legs == "compliant" or not twin.position[:, list(SLIDE)].any()


def test_the_ladders_step_of_rigid_legs_is_the_planar_models(parameters, planar):
    machine, model, state, solver, changes = planar("rigid", 1, 1e-9)
    numbers, settings = section_numbers(state), dataclasses.replace(parameters.settings, **changes)
    step = step_map(machine, *model[1:], settings)(SectionState(numbers, np.zeros(9)), 0)
    hip = simulate(*model, section_state(numbers, state), solver).trajectory.at(np.array([step.duration]))[0][0]
    assert step.length == pytest.approx(hip[0], abs=1e-7)
    assert step.end.plane[[0, 2, 3]] == pytest.approx([hip[1], 0.333, 0.333], abs=1e-7)


# --- The compiled ground against the laws' own text, the principle of virtual power, and Exudyn's connectors.


@pytest.mark.parametrize("normal", NORMAL_FORCES)
@pytest.mark.parametrize("friction", FRICTIONS)
def test_a_pair_of_feet_that_stands_straight_feels_the_planar_models_force(parameters, machine, normal, friction):
    law = dataclasses.replace(parameters.contact, normal_force=normal, friction=friction)
    numbers, radius = point_law(law), float(machine.radius[0])
    reach = machine.length[0] - radius
    for depth, upward, forward, turn in ((2e-5, -0.2, 0.003, 0.1), (1e-4, 0.05, 0.7, -0.4), (3e-4, -0.3, -2.0, 0.5)):
        q, v = np.zeros(COUNT), np.zeros(COUNT)
        q[Y], v[X], v[Y], v[PITCH] = machine.length[0] - depth, forward, upward, turn
        force = feet_forces(q, v, np.array([1.0, 0.0, 0.0, 0.0]), machine.feet, numbers)[1].sum(axis=0)
        planar = disc_force(law, radius, radius - depth, forward + reach * turn, upward, turn, SCALARS)
        assert force[:2] == pytest.approx(planar, rel=1e-9, abs=1e-12) and force[2] == 0.0


def test_power_of_the_forces_is_that_of_the_generalized_forces(parameters, machine, random_states):
    q, v, _ = random_states
    numbers, touching = point_law(parameters.contact), 0
    for place, motion in zip(q, v, strict=True):
        place[1] -= min(clearances(place, machine.feet)[0]) + 2e-5
        generalized, force, power = feet_forces(place, motion, np.array([1.0, 1.0, 0.0, 0.0]), machine.feet, numbers)
        assert generalized @ motion == pytest.approx(power, rel=1e-9, abs=1e-9)
        assert generalized[:3] == pytest.approx(force.sum(axis=0))
        touching += bool(force[:, 1].sum() > 0.0)
    assert touching > 10


def test_lowest_point_is_found_on_the_cylinders_rim(machine, random_states):
    q, v, a = random_states
    around = np.linspace(0.0, 2.0 * np.pi, 20001)
    circle = machine.radius[0] * np.array([np.cos(around), np.sin(around)])
    for pair in (0, 1):
        axes, lowest = pair_axes(q, v, a, pair), np.full(len(q), np.inf)
        for leg in (2 * pair, 2 * pair + 1):
            for side in (-1, 1):
                z = machine.lane[leg] + side * machine.half_width
                place = np.array([0.0, machine.radius[leg] - machine.length[leg], z])
                centre = point_motion(q, v, a, axes, place, SLIDE[leg]).position
                rim = centre[:, 1, None] + axes.forward[:, 1, None] * circle[0] + axes.upward[:, 1, None] * circle[1]
                lowest = np.minimum(lowest, rim.min(axis=1))
        found = [clearances(place, machine.feet)[0][pair] for place in q]
        assert found == pytest.approx(lowest, abs=1e-8)


def test_no_force_on_a_pair_out_of_play(parameters, machine, random_states):
    q, v, _ = (values.copy() for values in random_states)
    q[:, 1] -= 0.05
    force, _ = along(q, v, np.tile([0.0, 1.0], (len(q), 1)), machine.feet, point_law(parameters.contact))
    assert not force[:, :2].any() and force[:, 2:, 1].max() > 0.0


@pytest.mark.parametrize(("legs", "solver", "within"), [
    ("compliant", {"tolerance": 1e-5}, 1e-8), ("rigid", {"tolerance": 1e-4, "largest_step": 2e-3}, 1e-6)])
def test_exudyn_connectors_move_the_machine_alike(parameters, walk_from, legs, solver, within):
    """The same steps are taken by both."""
    machine = build(dataclasses.replace(parameters.biped, legs=legs), parameters.settings)
    push = {"yaw": 0.02, "yaw_rate": 0.1, "roll_rate": 0.05, "sideways": 0.01}
    connectors = ConnectorTree(machine, parameters.slope, parameters.contact)
    ours, theirs = (walk_from(machine, 1, tree=tree, push=push, **solver) for tree in (None, connectors))
    assert ours.completed and theirs.completed
    time = np.linspace(0.0, min(ours.time[-1], theirs.time[-1]), 200)
    assert abs(ours.at(time)[0] - theirs.at(time)[0]).max() < within


def standing(machine, lanes, half_width):
    """The feet's numbers with other lanes and widths."""
    feet = machine.feet.copy()
    feet[:, 0], feet[:, 3] = lanes, half_width
    return feet


@pytest.mark.parametrize(("lanes", "half_width"), [((0.04, -0.04, 0.085, -0.085), 0.0), (np.zeros(4), 0.01)])
def test_where_the_feet_stand_resists_roll_and_yaw(parameters, machine, lanes, half_width):
    """Two feet apart, or one with two edges: a roll is pushed back, a spin braked; without either nothing resists."""
    law, feet, line = point_law(parameters.contact), standing(machine, lanes, half_width), standing(machine, 0.0, 0.0)

    def push(feet, roll=0.0, yaw=0.0, spin=0.0):
        """On an upright machine that stands on its inner pair."""
        q, v = np.zeros(COUNT), np.zeros(COUNT)
        q[Y], q[YAW], q[ROLL], q[HINGE], v[YAW] = machine.length[0] - 1.5e-5, yaw, roll, 0.3, spin
        return feet_forces(q, v, np.array([1.0, 0.0, 0.0, 0.0]), feet, law)[0]

    for sign in (1.0, -1.0):
        assert sign * push(feet, roll=sign * 2e-4)[ROLL] < -1e-2
        # a line foot tilts about its line: the ground's force then passes by the hip and pushes it further
        assert sign * push(line, roll=sign * 2e-4)[ROLL] > -1e-9
        assert sign * push(feet, spin=sign * 0.5)[YAW] < -1e-3
        assert push(line, spin=sign * 0.5)[YAW] == pytest.approx(0.0, abs=1e-12)
    assert push(feet, yaw=0.2)[YAW] == pytest.approx(0.0, abs=1e-12)
