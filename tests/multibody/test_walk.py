"""A walk of the multibody model: energy, momentum, convergence, two assemblies, failures that are told."""

import math
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from stages.analytic.gait.gait_report import limp_of
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.result import REACHES
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.biped.accuracy.scales import scales_of
from stages.ground.blocks import Blocks, BlocksDoNotFit
from stages.ground.friction import SCALARS, Lane, lanes
from stages.multibody.walking.watch import Look, Watch
from stages.penalty.walk import Settings as PenaltySettings, begin, numbers_of
from stages.planar.energy import energy_balance
from stages.planar.run import COMPLETED, DIVERGED, FELL, SOLVER_FAILED, STALLED, STEP_FLOOR, PlanarState, rolling_state
from stages.planar.sampling import find_events, sample
from stages.stability.blocks.walks import Rough, heights_of, walk_on
from stages.twin.machine.machine import build as build_machine
from stages.twin.ramp import lay_blocks
from stages.twin.walking.measures import energy_balance as spatial_balance
from stages.twin.walking.record import find_events as spatial_events
from stages.twin.walking.simulate import rolling_start, simulate_twin
from tests.study import parameters_of


@pytest.fixture(scope="module")
def walk(two_steps, slope, biped):
    return sample(two_steps.trajectory, biped, slope, 2000.0)


def test_two_steps_are_walked(two_steps, walk):
    assert two_steps.completed and two_steps.heel_strikes == 2
    assert walk.heel_strike_leg.tolist() == [1, 0] and walk.toe_off_leg.tolist() == [0, 1]
    assert np.all(walk.toe_off_time > walk.heel_strike_time)
    assert walk.time[1] == pytest.approx(1 / 2000.0) and walk.time[-1] <= two_steps.trajectory.time[-1]


def test_sensors_feel_the_motion_they_ride_on(walk, slope, biped):
    """Specific force is the derivative of velocity less gravity, on the leg's axes; here away from the impacts."""
    inside = (walk.time > 0.02) & (walk.time < walk.time[-1] - 0.01)
    for strike in walk.heel_strike_time:
        inside &= np.abs(walk.time - strike) > 0.03
    angle, arm = walk.leg_angle[:, 0], walk.leg_length[:, 0] - biped.foot_com
    forward, upward = np.array([np.cos(angle), np.sin(angle)]).T, np.array([-np.sin(angle), np.cos(angle)]).T

    def felt(velocity):
        force = np.gradient(velocity, walk.time, axis=0) - np.array(slope.gravity_vector)
        return np.column_stack([(force * axis).sum(axis=1) for axis in (forward, upward)])

    foot = np.gradient(walk.hip_position - arm[:, None] * upward, walk.time, axis=0)
    assert np.abs(walk.hip_specific_force - felt(walk.hip_velocity))[inside].max() < 0.02
    assert np.abs(walk.foot_specific_force - felt(foot))[inside, 0].max() < 0.05
    assert np.array_equal(walk.hip_angular_velocity, walk.leg_rate[:, 0])


def test_feet_are_loaded_only_between_heel_strike_and_toe_off(walk):
    strike, off = walk.heel_strike_time[0], walk.toe_off_time[1]
    loaded = walk.ground_reaction[:, 1, 1] > 0.0
    stance = (walk.time > strike) & (walk.time < off)
    apart = (walk.time < strike - 1e-9) | (walk.time > off + 1e-9)  # but for the rounding of the located events
    assert not loaded[apart].any() and loaded[stance].mean() > 0.95
    assert walk.ground_reaction[:, :, 1].min() >= 0.0


def test_a_walk_can_be_resumed(two_steps, scene, start):
    first = scene.walk(start, steps=1)
    rest = scene.walk(first.trajectory.state_at(first.trajectory.time[-1]), steps=1)
    assert rest.completed
    end = rest.trajectory.time[-1] - 1e-3
    whole, parts = (run.trajectory.at(np.array([time]))[0]
                    for run, time in ((two_steps, first.trajectory.time[-1] + end), (rest, end)))  # fmt: skip
    assert np.abs(whole - parts).max() < 1e-8


def orders(errors):
    """Of a solver whose steps are halved."""
    return np.log2(np.array(errors[:-1]) / errors[1:])


def test_explicit_solver_converges_at_fifth_order(scene, start):
    """Over a smooth span, with a tolerance so wide that the largest step rules."""

    def end(tolerance, step):
        run = scene.but(tolerance=tolerance, largest_step=step).walk(start, duration=0.1)
        assert run.completed
        return run.trajectory.position[-1]

    reference = end(1e-11, 1e-4)
    assert np.all(orders([np.abs(end(1e-3, step) - reference).max() for step in (8e-4, 4e-4, 2e-4)]) > 4.7)


def test_implicit_solver_converges_at_second_order_through_heel_strike(scene, start):
    time = np.linspace(0.0, 0.2, 2000)
    reference = scene.walk(start, duration=0.2).trajectory.at(time)[0]
    errors = []
    for refinement in (1, 2, 4):
        jointed = scene.but(assembly="joints", rolling_step=1.2e-3 / refinement, impact_step=6e-5 / refinement)
        errors.append(np.abs(jointed.walk(start, duration=0.2).trajectory.at(time)[0] - reference).max())
    assert orders(errors) == pytest.approx([2.0, 2.0], abs=0.2)


@pytest.mark.parametrize(("solver", "steps", "rolling_step"), [
    ("trapezoidal", 1, 3e-4), ("generalized_alpha", 1, 3e-4),
    pytest.param("trapezoidal", 10, 1e-4, marks=pytest.mark.slow)])
def test_the_two_assemblies_agree(scene, start, two_steps, solver, steps, rolling_step):
    explicit = two_steps if steps == 1 else scene.walk(start, steps=steps)
    jointed = scene.but(
        assembly="joints", implicit_solver=solver, rolling_step=rolling_step, impact_step=0.05 * rolling_step)
    run = jointed.walk(start, steps=steps)
    assert run.completed and run.joint_drift < 1e-7
    time = np.linspace(0.0, run.trajectory.time[-1] - 1e-3, 3000 * steps)
    difference = run.trajectory.at(time)[0] - explicit.trajectory.at(time)[0]
    assert np.abs(difference[:, :2]).max() < 1e-6


@pytest.fixture(scope="module")
def chosen():
    """The contact set of the study's own ground.yaml."""
    return parameters_of("multibody").contact


@pytest.mark.slow
@pytest.mark.parametrize("ground", ["contact", "chosen"])
def test_a_hundred_steps_settle_and_stay_with_the_same_bits(ground, request, scene, start):
    """No fall; after the transient neither period nor length of a step drifts; a rerun has the same bits."""
    fast = scene.but(contact=request.getfixturevalue(ground), tolerance=1e-8)
    one, two = (fast.walk(start, steps=100) for _ in range(2))
    assert one.completed and one.heel_strikes == 100
    strikes = find_events(one.trajectory, scene.biped.foot_radii).heel_strike_time
    for values in (strikes, one.trajectory.at(strikes)[0][:, 0]):
        assert np.ptp(np.diff(values)[-60:]) < 1e-7
    for name in ("time", "position", "velocity", "ground_reaction"):
        assert np.array_equal(getattr(one.trajectory, name), getattr(two.trajectory, name)), name


COARSE = {"tolerance": 1e-6, "largest_step": 2e-3, "rolling_step": 5e-4, "impact_step": 5e-5}
BACK = {"hip_velocity": (-0.6, 0.0), "leg_rate": (2.0, 0.0)}


@pytest.mark.parametrize(("of_start", "changes", "outcomes", "words"), [
    (BACK, COARSE, (FELL,), "fell at t ="),
    (BACK, {**COARSE, "assembly": "joints"}, (FELL,), "fell at t ="),
    ({"hip_velocity": (1e200, 0.0)}, {}, (DIVERGED, FELL, STEP_FLOOR), ""),
    ({}, {"assembly": "joints", "rolling_step": 1e-2, "impact_step": 1e-2, "contact_stiffness": 1e12,
          "damping_depth": 1e-9}, (SOLVER_FAILED,), " "),
], ids=["fall", "fall of joints", "not finite", "no convergence"])
def test_a_walk_that_ends_early_is_told_with_the_last_valid_state(scene, start, of_start, changes, outcomes, words):
    """It falls, its state is not finite, or Newton's iteration fails."""
    run = scene.but(**changes).walk(replace(start, **of_start))
    assert run.outcome in outcomes and words in run.message
    assert np.all(np.isfinite(run.trajectory.position))
    assert of_start is not BACK or run.trajectory.position[-1, 1] < 0.6 * scene.biped.leg_length


def test_standing_still_is_told(scene):
    nothing = (0.0, 0.0)
    standing = PlanarState((0.0, 0.33299), nothing, nothing, nothing, (0.333, 0.333), nothing, (True, True))
    run = scene.but(slope_deg=0.0, longest_step=0.2).walk(standing)
    assert run.outcome == STALLED and run.trajectory.time[-1] == pytest.approx(0.2, abs=2e-3)


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


def test_residuals_of_implicit_steps_are_counted(scene, start):
    """As often as the contact's law is called, written in Python, for each foot; Newton's iterations are most of it."""
    joints, made = scene.but(assembly="joints", rolling_step=1e-3, impact_step=2e-5), []
    machine = joints.build(compiled=False, signals=())
    for connector, law in zip(machine.contacts, machine.laws, strict=True):
        counted = lambda *given, law=law: (made.append(1), law(*given))[1]  # noqa: E731
        machine.mbs.SetObjectParameter(connector, "springForceTorqueUserFunction", counted)
    run = joints.walk(start, duration=0.15, assembly=machine)
    assert run.completed and run.evaluations > 3 * run.solver_steps
    assert len(made) / 2 == pytest.approx(run.evaluations, abs=2)


# --- Walks over blocks of drawn heights: each model falls on the same block, and events and energy know the
# heights.


#: Heights over which Table 1 walks some steps, and a walk of it.
HIGH, WALK, MOST = 6e-4, 2, 30


@pytest.fixture(scope="module")
def hard(scene):
    """On ground as hard as the study's the models fall in the same step: on Adams' soft one they need not."""
    return scene.but(contact_stiffness=3e5, contact_damping=3e4, stiction_velocity=0.03)


@pytest.fixture(scope="module")
def gait(biped, slope):
    return gait_of(biped, slope)


def gait_of(biped, slope):
    walker, point = find_gait(biped, slope, 1e-9)
    walk, upright = walk_from_mid_stance(walker, point.z, 1, 1e-9, 1000.0)
    return walker, point, upright, walk.standing_force, limp_of(walker, point).feet_apart_m


def test_feet_of_the_gait_land_so_far_apart(biped, gait):
    walker, point, *_, apart = gait
    assert Rough(walker, point.z, 0.0, 0.1).middles == pytest.approx(apart / walker.length, rel=1e-12)
    with pytest.raises(BlocksDoNotFit, match=r"ground.block_length = 0.3 m .* allowed: < 0.2414 m"):
        Blocks(HIGH, block_length=0.3).under(0, apart)
    assert Blocks().under(0, apart) is None


def test_blocks_lie_under_the_feet_of_legs_that_differ(hard, biped, slope):
    """The softer leg's foot lands 3.6 mm farther ahead: both hit blocks of 3 mm, in every planar model."""
    limping = replace(biped, other_stiffness=2000.0)
    walker, point, upright, force, apart = gait_of(limping, slope)
    assert np.ptp(apart) == pytest.approx(3.56e-3, abs=1e-5)
    laid, start = Blocks(1e-9, block_length=3e-3).under(0, apart), rolling_state(limping, hard.contact, upright, force)
    made = walk_on(Rough(walker, point.z, 0.0, 3e-3 / walker.length), [0.0] * 4)
    penalty = begin(numbers_of(limping, slope, hard.contact), scales_of(limping, slope.gravity), start,
                    PenaltySettings(1e-7), 4, laid)  # fmt: skip
    penalty.go_on()
    run = replace(hard, biped=limping).but(tolerance=1e-6, largest_step=1e-3).walk(start, steps=4, blocks=laid)
    assert made.ending == REACHES and penalty.outcome == run.outcome == COMPLETED


def test_planar_models_fall_in_the_same_step(hard, biped, slope, gait):
    (walker, point, upright, force, apart), contact = gait, hard.contact
    start, laid = rolling_state(biped, contact, upright, force), Blocks(HIGH).under(WALK, apart)
    rough = Rough(walker, point.z, HIGH / walker.length, Blocks().block_length / walker.length)
    made = walk_on(rough, islice(heights_of(0, WALK), MOST)).steps
    penalty = begin(
        numbers_of(biped, slope, contact), scales_of(biped, slope.gravity), start, PenaltySettings(1e-7), MOST, laid)
    penalty.go_on()
    run = hard.but(tolerance=1e-6, largest_step=1e-3).walk(start, steps=MOST, blocks=laid)
    assert (penalty.outcome, penalty.heel_strikes) == (run.outcome, run.heel_strikes) == (FELL, made) and made > 3
    assert penalty.time == pytest.approx(float(run.trajectory.time[-1]), abs=3e-3)


@pytest.mark.parametrize("rows", [False, True])
def test_events_and_energy_know_the_heights(scene, biped, slope, contact, gait, rows):
    *_, upright, force, apart = gait
    start, laid = rolling_state(biped, contact, upright, force), Blocks(3e-4).under(WALK, apart)
    lying = lanes(0.1612, 0.08) if rows else None
    run = scene.walk(start, steps=3, blocks=laid, lanes=lying)
    strikes = find_events(run.trajectory, biped.foot_radii).heel_strike_time
    assert run.outcome == COMPLETED and len(strikes) == 3
    heights = np.diag(run.trajectory.under(strikes)[:, [1, 0, 1]])
    assert heights == pytest.approx([laid.height(number) for number in range(3)])
    balance = energy_balance(run.trajectory, biped, slope, contact, float(strikes[0]), float(strikes[2]))
    assert balance.relative_residual < 1e-5


@pytest.mark.parametrize("rows", [False, True])
def test_the_twin_walks_on_them_too(gait, rows):
    """At a tolerance where round-off of the start moves the balance little; at 1e-6 by up to 1e-3."""
    *_, upright, force, apart = gait
    given = parameters_of("twin", "twin.tolerance=1e-8")
    machine, laid = build_machine(given.biped, given.settings), Blocks(3e-4).under(WALK, apart)
    ramp = lay_blocks(given.settings, Blocks(), 0.1612) if rows else None
    start = rolling_start(machine, given.contact, upright, force)
    record = simulate_twin(
        machine, given.slope, given.contact, start, given.settings, steps=3, ramp=ramp, blocks=laid)
    events = spatial_events(record)
    assert record.outcome == COMPLETED and len(events.heel_strike_time) == 3
    heights = record.under(events.heel_strike_time)[np.arange(3), events.heel_strike_leg]
    assert heights == pytest.approx([laid.height(number) for number in range(3)])
    first, last = events.heel_strike_time[[0, 2]]
    assert spatial_balance(record, float(first), float(last)).relative_residual < 1e-5


def test_a_foot_that_lands_beyond_its_block_has_fallen(scene, biped, slope, contact, gait):
    *_, upright, force, apart = gait
    short = replace(Blocks(1e-4).under(WALK, apart), ends=tuple(0.9 * apart))
    start = rolling_state(biped, contact, upright, force)
    run = scene.but(tolerance=1e-6, largest_step=1e-3).walk(start, steps=2, blocks=short)
    penalty = begin(
        numbers_of(biped, slope, contact), scales_of(biped, slope.gravity), start, PenaltySettings(1e-7), 2, short)
    penalty.go_on()
    for outcome, message in ((run.outcome, run.message), (penalty.outcome, penalty.message)):
        assert outcome == FELL and "came down beyond its block" in message
    assert math.isclose(penalty.time, float(run.trajectory.time[-1]), abs_tol=3e-3)
    assert run.solver_steps == len(run.trajectory.time) - 1


def test_a_foot_that_rolls_has_its_centre_an_arc_ahead_and_a_radius_up(biped, contact, gait):
    *_, upright, force, _ = gait
    start = rolling_state(biped, contact, replace(upright, stance_angle=0.2), force)
    arm = start.leg_length[0] - biped.foot_radius
    centre = start.hip_position[0] - arm * math.sin(0.2), start.hip_position[1] - arm * math.cos(0.2)
    assert centre == pytest.approx((0.2 * biped.foot_radius, biped.foot_radius), abs=1e-4)


# --- The ideal rule against scuffing, and stepping blocks that do the same.


def test_blocks_of_a_lane():
    lane = Lane(first=0.1, spacing=0.4, length=0.1)
    x = np.array([-0.36, -0.34, -0.26, -0.24, 0.04, 0.06, 0.1, 0.14, 0.16, 0.46, 0.54, 0.56])
    assert lane.presence(x).tolist() == [0, 1, 1, 0, 0, 1, 1, 1, 0, 1, 1, 0]
    assert [lane.presence(value, SCALARS) for value in x.tolist()] == lane.presence(x).tolist()
    inner, outer = lanes(0.16, 0.08)
    assert inner.presence(0.0) == 1.0 and outer.presence(0.16) == 1.0 and inner.presence(0.16) == 0.0


def test_blocks_under_the_feet_give_the_walk_of_the_ideal_rule(scene, start):
    coarse = scene.but(tolerance=1e-6, largest_step=2e-3)
    run, plain = (coarse.walk(start, lanes=each) for each in (lanes(0.16, 0.1), None))
    assert run.completed and run.heel_strikes == 2
    assert np.array_equal(run.trajectory.position, plain.trajectory.position)
    on_blocks, ideal = (sample(each.trajectory, scene.biped, scene.slope, 500.0) for each in (run, plain))
    for name in ("heel_strike_time", "toe_off_time"):
        assert np.array_equal(getattr(on_blocks, name), getattr(ideal, name))


@pytest.mark.parametrize(("step", "length"), [(0.3, 0.05), (0.16, 0.03)])
def test_a_missed_block_is_told(scene, start, step, length):
    run = scene.walk(start, lanes=lanes(step, length))
    assert run.outcome == FELL and run.message


def test_without_the_rule_the_swing_foot_scuffs(scene, start):
    """The rule is needed: on plain ground under both feet the same start does not get through two steps."""
    endless = (Lane(0.0, 2.0, 2.0), Lane(0.0, 2.0, 2.0))
    assert not scene.but(tolerance=1e-6, largest_step=2e-3).walk(start, lanes=endless).completed
