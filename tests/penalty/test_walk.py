"""Walks and gaits of the penalty walker: energy, convergence, how they end, and derivatives by state and parameters."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.derivatives.multipliers import SURE
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.phases.motion import SINGLE_STANCE
from stages.analytic.walk.recording import crossing_state, record
from stages.analytic.walk.sampling import sample_walk, walk_from_mid_stance
from stages.biped.design import Biped
from stages.biped.walk import StanceState
from stages.ground.contact_law import ContactLaw, family_member
from stages.ground.friction import static_penetration
from stages.ground.slope import Friction, Slope
from stages.penalty import step_map
from stages.penalty.model.changes import changes_of
from stages.penalty.model.walker import build_penalty
from stages.penalty.motion import feet
from stages.penalty.step_map import PenaltyStepper, changed, of_multipliers, responses
from stages.penalty.walk import Settings, simulate
from stages.planar.energy import energy_balance
from stages.planar.limit_cycle import cycle_at, fixed_point, gait_near
from stages.planar.run import FELL, STALLED, STEP_FLOOR, rolling_state
from stages.planar.sampling import find_events
from stages.planar.section import NoLimitCycle, mid_stance_after, section_numbers, section_state
from stages.planar.signals import GROUND_REACTION
from tests.analytic.differences import extrapolated, together
from tests.penalty.drawn import drawn_designs, drawn_sets
from tests.planar_start import SCALES

#: Coefficient of friction where contact hardens.
FRICTION = 3.0
#: Standing on one leg, nearly at rest.
STILL = StanceState(0.0, 0.331, -0.1, 0.333, 0.01, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def walked(biped, slope, contact, start):
    return simulate(biped, slope, contact, start, Settings(1e-11, 2), steps=2)


def test_energy_is_accounted_for(walked, biped, slope, contact):
    """Over two steps, gravity's work against the losses in leg dampers, contact damping and friction."""
    assert walked.completed and walked.heel_strikes == 2
    balance = energy_balance(walked.trajectory, biped, slope, contact, 0.0, float(walked.trajectory.time[-1]))
    assert balance.relative_residual < 1e-7
    assert min(balance.leg_damper_loss, balance.contact_damping_loss, balance.friction_loss) > 1e-3


def test_a_tighter_tolerance_comes_nearer(walked, biped, slope, contact, start):
    """Errors in tolerances, their geometric mean over five of them: a step over a corner of the contact now and then
    passes for a good one; where, the last bits of the start decide.
    """
    end = walked.trajectory.position[-1]
    errors = []
    for tolerance in (1e-6, 1e-7, 1e-8, 1e-9, 1e-10):
        run = simulate(biped, slope, contact, start, Settings(tolerance), steps=2, signals=())
        errors.append(np.abs(run.trajectory.position[-1] - end).max() / tolerance)
    assert np.exp(np.log(errors).mean()) < 40, errors


def test_what_is_not_asked_for_is_not_recorded(walked, biped, slope, contact, start):
    bare = simulate(biped, slope, contact, start, Settings(1e-7), steps=1, signals=())
    assert bare.trajectory.ground_reaction.shape[1:] == (0, 2) and bare.trajectory.foot_acceleration.shape[1] == 0
    some = simulate(biped, slope, contact, start, Settings(1e-7), steps=1, signals=(GROUND_REACTION,))
    # the depth is a difference of numbers as large as the leg, after ten roundings: a condition number times round-off
    amplified = contact.contact_exponent * biped.leg_length / static_penetration(contact, 9.4)
    assert some.trajectory.ground_reaction[0, 0, 1] == pytest.approx(9.4, rel=10 * amplified * np.finfo(float).eps / 2)
    assert walked.trajectory.foot_acceleration.shape == (len(walked.trajectory.time), 2)


def test_a_walk_of_a_given_time_ends_there(walked, biped, slope, contact, start):
    for end in (0.1, 0.35, 0.6):
        run = simulate(biped, slope, contact, start, Settings(1e-11), duration=end, signals=())
        assert run.completed and run.trajectory.time[-1] == end
        known = walked.trajectory.at(np.array([end]))[0][0]
        assert run.trajectory.position[-1] == pytest.approx(known, abs=1e-9)


def test_how_walks_end_early(biped, slope, contact, start):
    back = dataclasses.replace(start, hip_velocity=(-0.6, 0.0), leg_rate=(2.0, 0.0))
    run = simulate(biped, slope, contact, back, Settings(1e-8), steps=1)
    assert run.outcome == FELL and "the walker fell at t =" in run.message
    hung = dataclasses.replace(slope, slope_deg=0.0)
    still = rolling_state(biped, contact, STILL, 9.4)
    run = simulate(biped, hung, contact, still, Settings(1e-8, longest_step=0.05), steps=1)
    assert run.outcome == STALLED and run.message.startswith("no heel strike for 0.05 s")
    run = simulate(biped, slope, contact, start, Settings(1e-8, most_solver_steps=20), steps=1)
    assert run.outcome == STEP_FLOOR and "gets nowhere after 20 steps" in run.message


def test_events_lie_between_the_switches(walked, biped):
    """Each leg goes out of play at or after it has left the ground, comes into play ahead, and lands after that."""
    found = find_events(walked.trajectory, biped.foot_radii)
    outs = {leg: time for time, leg, acts in walked.trajectory.switches if not acts}
    ins = {leg: time for time, leg, acts in walked.trajectory.switches if acts and time > 0.0}
    assert len(found.heel_strike_time) == 2 and set(outs) == {0, 1}
    for leg in (0, 1):
        off = found.toe_off_time[found.toe_off_leg == leg]
        assert off[0] <= outs[leg] + 1e-9
    assert ins[0] < found.heel_strike_time[found.heel_strike_leg == 0][-1]


@pytest.mark.parametrize("legs", ["compliant", "rigid"])
def test_as_contact_hardens_it_walks_as_the_constraint_model_does(biped, slope, contact, legs):
    """With Coulomb's transition; what sets it apart is of first order in the share of contact's effects.

    The coefficient is one at which little is of the orders between: extrapolated in whole ones, .02 of it is left.
    """
    machine = dataclasses.replace(biped, legs=legs)
    friction = Friction(FRICTION, FRICTION)
    walker, point = find_gait(machine, slope, 1e-11, friction)
    upright = crossing_state(walker, point.z, 1e-11)
    phase = SINGLE_STANCE if legs == "compliant" else 0
    walk = sample_walk(walker, record(walker, upright, 2, 1e-11, phase), 5000.0)
    base = dataclasses.replace(
        contact, static_friction=FRICTION, dynamic_friction=FRICTION, stiction_velocity=0.02)
    time = walk.time[(walk.time < 0.45) & (np.abs(walk.time - walk.heel_strike_time[0]) > 5e-3)]
    away = []
    for share in (0.1, 0.05, 0.025):
        law = family_member(base, share)
        state = rolling_state(machine, law, walker.stance_state(upright), walk.standing_force)
        run = simulate(machine, slope, law, state, Settings(1e-9), duration=0.47, signals=())
        hip = run.trajectory.at(time)[0][:, :2]
        away.append(np.abs(hip - walk.hip_position[np.isin(walk.time, time)]).max())
    far, middle, near = away
    assert abs(8.0 * near - 6.0 * middle + far) / 3.0 < 0.1 * near


@pytest.mark.parametrize("status, ahead, swings, ends", [
    (feet.OUT, 0.1, 1.0, True), (feet.OUT, -0.1, 1.0, False), (feet.LANDED, -0.1, 1.0, True),
    (feet.LANDED, 0.1, 1.0, False), (feet.LANDED, -0.1, -1.0, False)])
def test_a_foot_is_in_the_air_once_it_is_above_the_ground_by_a_millionth_of_its_leg(
    biped, slope, contact, status, ahead, swings, ends
):
    """However little it clears: ahead of the other foot the ground acts on it again; behind it, on its way forward, no
    longer.
    """
    p, y = build_penalty(biped, slope.gravity_vector, contact, 0.5), np.zeros(12)
    reach = biped.leg_length - biped.foot_radius
    y[2:4], y[4:6] = (np.arcsin(ahead / reach), 0.0), biped.leg_length
    y[8] = swings
    phase = feet.phase_of(status, feet.LANDED, 0)
    for above, flies in ((1e-6, True), (-1e-6, False)):
        y[1] = biped.foot_radius + reach * np.cos(y[2]) + above * biped.leg_length
        assert (feet.leg_guard(phase, y, p, 0, y, 0)[0] < 0) == (flies and ends)


# --- The step map of the penalty walker: its exact derivative, its fixed point and multipliers.


@pytest.fixture(scope="module")
def fine(biped, slope, contact, start):
    return PenaltyStepper(biped, slope, contact, start, Settings(1e-12))


def test_the_derivative_is_that_of_the_map(fine, gait):
    """Against central differences of walks, extrapolated to no difference, in directions of all numbers."""
    exact = fine.derivative(gait.section_state)
    for direction in np.random.default_rng(11).normal(size=(4, 10)):
        along = direction * SCALES * np.array([1e-3, 1.0, 1e-3, *[1.0] * 7])  # hardly lifts the standing foot
        expected = extrapolated(lambda h: fine.step(gait.section_state + h * along).numbers, 2e-3)  # noqa: B023
        assert exact @ along / SCALES == pytest.approx(expected / SCALES, abs=2e-5 * np.abs(expected / SCALES).max())


def test_a_step_from_the_gait_ends_on_it(fine, gait):
    after = fine.step(gait.section_state)
    assert np.abs((after.numbers - gait.section_state) / SCALES).max() < 1e-7
    assert after.duration == pytest.approx(gait.period_s, abs=1e-9)
    assert gait.residual < 1e-9 and gait.steps_walked < 20


def test_walks_approach_the_gait_as_its_multipliers_say(fine, gait, start):
    """Two multipliers remain after a step; distances along their left eigenvectors shrink by them, one by one."""
    values, vectors = np.linalg.eig(gait.monodromy_matrix)
    leading = np.argsort(-np.abs(values))[:2]
    left = np.linalg.inv(vectors)[leading].real
    numbers, distances = gait.section_state + 2e-4 * SCALES * [0, 1, 0, 0, 0, 0, 0, 1, 0, 0], []
    for _ in range(4):
        numbers = fine.step(numbers).numbers
        distances.append(left @ (numbers - gait.section_state))
    for before, after in pairwise(distances):
        assert after / before == pytest.approx(values[leading].real, rel=0.02)
    assert gait.floquet_multipliers[:2] == pytest.approx(np.column_stack([values[leading].real, [0.0, 0.0]]))


def test_the_step_map_is_the_walk(fine, biped, slope, contact, start):
    """The same step read off a recorded walk, as it is of Exudyn's walks."""
    numbers = section_numbers(start)
    read = mid_stance_after(simulate(biped, slope, contact, start, Settings(1e-12), steps=1))
    own = fine.step(numbers)
    assert own.numbers == pytest.approx(read.numbers, abs=1e-9)
    assert (own.duration, own.length) == pytest.approx((read.duration, read.length), abs=1e-10)
    assert np.array_equal(section_numbers(section_state(numbers, start)), numbers)


def test_a_start_that_falls_has_no_step(fine, start):
    numbers = section_numbers(start)
    numbers[4] = -0.6
    with pytest.raises(NoLimitCycle, match="fell"):
        fine.step(numbers)


# --- Derivatives of steps and gaits by parameters: against differences, what dimensions demand, gaits solved anew.


DESIGN = ("biped.hip_mass", "biped.foot_mass", "biped.leg_length", "biped.foot_radius", "biped.foot_com",
          "biped.leg_inertia", "biped.stiffness", "biped.damping")  # fmt: skip
SLOPE = ("ground.slope_deg", "ground.gravity")
OF_FRICTION = tuple(
    f"ground.{key}" for key in ("static_friction", "dynamic_friction", "stiction_velocity", "friction_velocity"))
SPRING = ("ground.contact_stiffness", "ground.contact_exponent")
OF_LAW = {"impact": ("ground.contact_damping", "ground.damping_depth"),
          "restitution": ("ground.restitution", "ground.impact_speed")}  # fmt: skip
#: How the steps are walked whose differences are taken, and the largest of these: rigid legs bounce.
FINE = {"compliant": (Settings(1e-12), 8e-4), "rigid": (Settings(1e-13), 8e-5)}
#: Numbers whose derivatives are held against one rerun.
TOGETHER = 6
#: What sums may leave: of period and length, and of multipliers, whose derivatives are differences of matrices.
LEFT, LEFT_OF_MULTIPLIERS = 1e-8, 4e-7
#: And not more than so many of the errors that are stated.
SAFE = 3.0


@pytest.fixture(scope="module")
def found(biped, slope, contact, start, gait):
    return responses(biped, slope, contact, start, gait, (*DESIGN, *SLOPE, *SPRING, *OF_FRICTION, *OF_LAW["impact"]))


def total(table, names, weights):
    return sum(power * table[names.index(name)] for name, power in weights.items())


def differences(parts, state, along, lift):
    """Central differences of a step along a change of its numbers, extrapolated (12,), and how far those of half the
    size are from them: their truncation, and twice their round-off.

    `along`: how much of each number goes into the change; `lift` (10,): changes of the start's section numbers that go
    along.
    """
    numbers = section_numbers(state)
    settings, first = FINE[parts[0].legs]

    def slope(share):
        ends = []
        for by in (share, -share):
            there = parts
            for name, size in along.items():
                there = changed(*there, name, by * size)
            step = PenaltyStepper(*there, state, settings).step(numbers + by * lift)
            ends.append(np.array([*(step.numbers / SCALES), step.duration, step.length]))
        return (ends[0] - ends[1]) / (2 * share)

    slopes = [slope(share) for share in (first, first / 2, first / 4)]
    once = [(4 * fine - coarse) / 3 for coarse, fine in pairwise(slopes)]
    return once[0], np.abs(once[1] - once[0]).max()


def assert_derivatives_are_those_of_reruns(parts, state, names):
    """By every name, each with a weight of its own and along with others whose derivatives are about as large."""
    changes = changes_of(*parts, names)
    stepper = PenaltyStepper(*parts, state, FINE[parts[0].legs][0])
    numbers, duration, length = stepper.step_tangents(section_numbers(state), changes)
    columns = np.vstack([numbers / SCALES[:, None], duration, length])
    for rows, weights in together(np.abs(columns[:, 10:]).max(axis=0), TOGETHER):
        along = {names[row]: weight * changes.scales[row] for row, weight in zip(rows, weights, strict=True)}
        lift = np.zeros(10)
        if parts[0].legs == "rigid":  # a longer rigid leg stands as deep in the ground
            lift[0] = along.get("biped.leg_length", 0.0)
        own = columns[:, 10 + rows] @ weights + columns[:, :10] @ lift
        expected, left = differences(parts, state, along, lift)
        assert own == pytest.approx(expected, abs=1e-6 + 10 * left), (along, parts)
        assert left < 1e-3 * max(np.abs(expected).max(), 1.0), along


@pytest.mark.parametrize("legs", ["compliant", "rigid"])
@pytest.mark.parametrize(("law", "others"), [
    ("impact", True), ("restitution", False), pytest.param("restitution", True, marks=pytest.mark.slow)])
def test_a_steps_derivatives_are_those_of_reruns(biped, slope, contact, rough, law, others, legs):
    """By every number of the normal force, from a start that is no gait, on ground drawn by a seed; of one law by every
    other number too, of design, slope and friction.
    """
    names = (*SPRING, *OF_LAW[law])
    if others:
        names = (*(DESIGN if legs == "compliant" else DESIGN[:6]), *SLOPE, *OF_FRICTION, *names)
    length = biped.leg_length
    stance = rough if legs == "compliant" else dataclasses.replace(rough, stance_length=length, swing_length=length)
    for ground in drawn_sets(contact, 4, 1, law):
        parts = dataclasses.replace(biped, legs=legs, leg_inertia=2e-4), slope, ground
        assert_derivatives_are_those_of_reruns(parts, rolling_state(parts[0], ground, stance, 9.4), names)


def test_a_detailed_steps_derivatives_are_those_of_reruns(biped, slope, contact, rough):
    """By every number of frames, legs that differ and hip, over the two steps of a cycle."""
    design = next(drawn_designs(biped, 12, 1))
    parts = design, slope, contact
    names = [f"biped.{field.name}" for field in dataclasses.fields(design)
             if isinstance(getattr(design, field.name), float)]  # fmt: skip
    assert_derivatives_are_those_of_reruns(parts, rolling_state(design, contact, rough, 9.4), names)


@pytest.mark.parametrize("of_multipliers_too", [
    slice(1), pytest.param(slice(3), marks=pytest.mark.slow)], ids=["mass", "all"])
def test_dimensions_demand_sums(contact, biped, slope, start, gait, of_multipliers_too):
    """Similar walkers: T in times, s in lengths; k_c in N/m^e, the multipliers without unit."""
    mass = dict.fromkeys(("biped.hip_mass", "biped.foot_mass", "biped.stiffness", "biped.damping",
                          "ground.contact_stiffness", "ground.contact_damping"), 1.0)  # fmt: skip
    sizes = ("biped.leg_length", "biped.foot_radius", "biped.foot_com", "ground.gravity", "ground.damping_depth")
    length = dict.fromkeys((*sizes, "ground.stiction_velocity", "ground.friction_velocity"), 1.0)
    length["ground.contact_stiffness"] = 1.0 - contact.contact_exponent
    time = {"ground.gravity": -2.0, "ground.stiction_velocity": -1.0, "ground.friction_velocity": -1.0,
            "biped.stiffness": -2.0, "biped.damping": -1.0, "ground.contact_stiffness": -2.0,
            "ground.contact_damping": -1.0}  # fmt: skip
    names = sorted({*mass, *length, *time})
    table = responses(biped, slope, contact, start, gait, names).elasticities()
    for powers, wanted in ((mass, [0.0, 0.0]), (length, [0.0, 1.0]), (time, [1.0, 0.0])):
        assert (np.abs(total(table, names, powers) - wanted) < LEFT).all()
    for powers in (mass, length, time)[of_multipliers_too]:
        answers = responses(biped, slope, contact, start, gait, [*powers])
        shares, errors, refused = of_multipliers(biped, slope, contact, start, answers)
        assert errors.max() < SURE and not refused
        left = np.abs(total(shares, [*powers], powers))
        assert (left < LEFT_OF_MULTIPLIERS).all()
        assert (left < SAFE * np.abs([*powers.values()]) @ errors).all()


def test_what_is_left_of_an_elasticity_is_a_share_of_the_multiplier(contact, biped, slope, start, gait, monkeypatch):
    """It was that of the derivative: of a second multiplier of .05 elasticities were said to be 20 times too sure."""
    answers = responses(biped, slope, contact, start, gait, ["biped.hip_mass"])
    monkeypatch.setattr(step_map, "along_the_gait", lambda *_: (np.ones(2), 1e-7))
    _, errors, _ = of_multipliers(biped, slope, contact, start, answers)
    least = np.sort(np.abs(np.linalg.eigvals(answers.matrix)))[-2]
    assert errors == pytest.approx([1e-7 / least]) and errors[0] > 1.1e-7


def test_a_longer_rigid_leg_counts_once(biped, slope, contact, rough):
    """Lengths add up for rigid legs too, whose lengths are no numbers of the section but those of the start."""
    rigid, length = dataclasses.replace(biped, legs="rigid"), biped.leg_length
    stance = dataclasses.replace(rough, stance_length=length, swing_length=length)
    start = rolling_state(rigid, contact, stance, 9.4)
    gait = gait_near(PenaltyStepper(rigid, slope, contact, start, Settings(1e-10)), start)
    powers = dict.fromkeys(("biped.leg_length", "biped.foot_radius", "biped.foot_com", "ground.gravity",
                            "ground.damping_depth", "ground.stiction_velocity", "ground.friction_velocity"), 1.0)
    powers["ground.contact_stiffness"] = 1.0 - contact.contact_exponent
    table = responses(rigid, slope, contact, start, gait, [*powers]).elasticities()
    assert total(table, [*powers], powers) == pytest.approx([0.0, 1.0], abs=1e-5)


def test_a_leg_that_strikes_twice_makes_no_cycle_and_one_on_the_ground_does_not(biped, slope, contact, rough):
    """Of rigid legs that hardly differ one that hung in the air struck again, and half of a stride was a gait; what
    round-off leaves under a foot made it hang."""
    length = biped.leg_length
    lame = dataclasses.replace(biped, legs="rigid", other_leg_length=length * (1 + 4.5e-5))
    stance = dataclasses.replace(rough, stance_length=length, swing_length=lame.leg(1).leg_length)
    start = rolling_state(lame, contact, stance, 9.4)
    stepper, numbers = PenaltyStepper(lame, slope, contact, start, Settings(1e-8)), section_numbers(start)
    whole = stepper.step(numbers).duration
    numbers[0] = np.nextafter(length, 1.0)
    assert stepper.step(numbers).duration == pytest.approx(whole, rel=0.05)
    numbers[0] = length * (1 + 2e-5)
    with pytest.raises(NoLimitCycle, match="strikes twice"):
        stepper.step(numbers)
    with pytest.raises(NoLimitCycle, match="strikes twice"):  # as Exudyn's walks are read
        mid_stance_after(simulate(lame, slope, contact, section_state(numbers, start), Settings(1e-8), steps=2))


def test_beside_a_fold_the_gait_is_the_stable_one_that_a_walk_leads_to(biped):
    """Large feet at 3.71 m/s^2, where gaits have .2667, .2744 and .3524 m: the second, unstable, was the gait at the
    usual accuracy, the first at draft."""
    large = dataclasses.replace(biped, foot_radius=0.25, stiffness=1058.92, damping=35.88)
    slope, contact = Slope(0.8, 3.71), ContactLaw(3e3, 2.2, 3e2, 1e-4, 1.1, 1.0, 0.03, 1.0)
    walker, point = find_gait(large, slope, 1e-10, Friction(1.1, 1.0))
    walk, upright = walk_from_mid_stance(walker, point.z, 1, 1e-10, 2000.0)
    start = rolling_state(large, contact, upright, walk.standing_force)
    stepper = PenaltyStepper(large, slope, contact, start, Settings(1e-9))
    found = gait_near(stepper, start)
    assert np.hypot(*found.floquet_multipliers[0]) < 1.0 and found.step_length_m < 0.27
    settled = stepper.walk(start, 100)
    assert np.abs((settled.numbers - found.section_state) / stepper.scales).max() < 1e-2
    assert np.abs((stepper.step(found.section_state).numbers - found.section_state) / stepper.scales).max() < 1e-6


def test_beside_an_unstable_gait_of_legs_nearly_alike_it_is_the_limp_that_a_walk_settles_in():
    """Pairs of legs that differ by half a gramme, beyond the doubling of alike ones: a walk leaves the gait between two
    limps by 2 % a step, and a search could end in any of the three."""
    alike = Biped("compliant", 0.0, 0.38, 0.35, 0.08, 0.106, 2500.0, 60.0, 1.1e-3,
                  frame_mass=0.1725, frame_com=0.0163, frame_inertia=2.1e-4)  # fmt: skip
    pairs = dataclasses.replace(alike, other_frame_mass=0.172, other_frame_com=0.0164)
    slope, contact = Slope(3.5, 9.81), ContactLaw(3e5, 2.2, 3e4, 1e-4, 1.1, 1.0, 0.03, 1.0)
    walker, point = find_gait(alike, slope, 1e-8, Friction(1.1, 1.0))
    walk, upright = walk_from_mid_stance(walker, point.z, 1, 1e-8, 2000.0)
    start = rolling_state(alike, contact, upright, walk.standing_force)
    between = fixed_point(PenaltyStepper(alike, slope, contact, start, Settings(1e-8)), section_numbers(start))
    start = section_state(between.numbers, start)
    for tolerance in (1e-6, 1e-8):
        stepper = PenaltyStepper(pairs, slope, contact, start, Settings(tolerance))
        assert cycle_at(stepper, fixed_point(stepper, between.numbers), None, True).floquet_multipliers[0, 0] > 1.02
        found = gait_near(stepper, start)
        settled = stepper.walk(start, 200)
        assert found.stable
        assert np.abs((settled.numbers - found.section_state) / stepper.scales).max() < 1e-4


def test_tighter_steps_come_nearer(found, biped, slope, contact, start, gait):
    """Through touch-down, lift-off and the corners of friction: nothing of order one is left at any of them.

    A step over a corner now and then passes for a good one; where, the last bits of the start decide. So the errors are
    counted in tolerances, and their geometric mean over four of them is bounded.
    """
    names, errors = (*DESIGN[1:7:2], SLOPE[0], SPRING[0], *OF_FRICTION[1:3]), []
    exact = found.elasticities()[[found.changes.names.index(name) for name in names]]
    for tolerance in (1e-7, 1e-8, 1e-9, 1e-10):
        other = responses(biped, slope, contact, start, gait, names, tolerance)
        errors.append(np.abs(other.elasticities() - exact).max() / tolerance)
    assert np.exp(np.log(errors).mean()) < 150, errors


@pytest.mark.parametrize("name", ["biped.foot_mass", "ground.stiction_velocity", "ground.slope_deg"])
def test_a_gait_solved_anew_is_where_they_say(found, biped, slope, contact, start, gait, name):
    row, ends = found.changes.names.index(name), []
    for share in (1e-3, -1e-3):
        parts = changed(biped, slope, contact, name, share * found.changes.scales[row])
        anew = fixed_point(PenaltyStepper(*parts, start, Settings(1e-12)), gait.section_state, found.matrix)
        ends.append(np.array([*(anew.numbers / SCALES), np.log(anew.step.duration), np.log(anew.step.length)]))
    own = [*(found.section[:, row] / SCALES), *found.elasticities()[row]]
    assert own == pytest.approx((ends[0] - ends[1]) / 2e-3, abs=1e-4)


def test_on_hard_ground_they_are_the_constraint_models(biped, slope, contact, rough):
    """With an eighth of what the study's ground gives way and lets creep; the largest elasticity is .82."""
    ground = family_member(dataclasses.replace(contact, stiction_velocity=0.03), 0.25)
    start = rolling_state(biped, ground, rough, 9.4)
    gait = gait_near(PenaltyStepper(biped, slope, ground, start, Settings(1e-9)), start)
    _, point = find_gait(biped, slope, 1e-9)
    exact = gait_derivatives(DesignPoint(biped, slope), point, (*DESIGN, *SLOPE), 1e-9).elasticities()
    own = responses(biped, slope, ground, start, gait, (*DESIGN, *SLOPE), 1e-9).elasticities()
    assert own[:, 0] == pytest.approx(exact["period_s"], abs=0.02)
    assert own[:, 1] == pytest.approx(exact["step_length_m"], abs=0.02)


@pytest.mark.parametrize(
    "name", ["ground.nothing", "ground.friction", "biped.legs", "twin.hip_mass", "biped.frame_mass"])
def test_a_name_of_no_number_is_refused(biped, slope, contact, start, gait, name):
    with pytest.raises(KeyError, match=name):
        responses(biped, slope, contact, start, gait, [name])
