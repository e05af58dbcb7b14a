"""The gait as a fixed point with its multipliers, and walks that do not settle, which are called so."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.unequal_designs import compared
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.recording import crossing_state
from stages.ground.contact_law import ContactLaw, family_member
from stages.multibody.parameters import Parameters
from stages.multibody.result import Result
from stages.multibody.walking.cycle import search, solve, unsettled
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings as PenaltySettings
from stages.planar.energy import energy_balance
from stages.planar.limit_cycle import by_differences, fixed_point, gait_near, nearer
from stages.planar.run import rolling_state
from stages.planar.sampling import sample
from stages.planar.section import NoLimitCycle, SectionStep, section_numbers, section_state
from tests.planar_start import SCALES
from tests.study import parameters_of

FIXED = np.linspace(0.2, 1.1, 10) * SCALES
BASIS = np.eye(10) + 0.1 * np.random.default_rng(3).normal(size=(10, 10))
MULTIPLIERS = np.array([-1.9, 0.6, 0.3, 0.01, *np.zeros(6)])
MAP = BASIS @ np.diag(MULTIPLIERS) @ np.linalg.inv(BASIS)


class MadeUp:
    """Takes the steps of a made-up map, and keeps where from."""

    steps_a_cycle, scales = 1, SCALES

    def __init__(self, step, size, tolerance=1e-6):
        self.map, self.size, self.tolerance, self.taken = step, size, tolerance, []

    def step(self, numbers):
        self.taken.append(numbers)
        return SectionStep(self.map(numbers), None, 0.5, 0.16, 100, 1)

    def walk(self, start, steps):
        """Away from a gait that is unstable, as the made-up ones are, a walk falls."""
        raise NoLimitCycle("the walker fell")

    @property
    def steps_walked(self):
        return len(self.taken)

    def derivative(self, numbers, after=None):
        return by_differences(self.step, numbers, self.size * SCALES, after)


def bent(numbers):
    """A step map with the multipliers above, not linear."""
    off = (numbers - FIXED) / SCALES
    return FIXED + SCALES * (MAP @ off + 0.5 * off**2)


def scaled(derivative):
    """As a derivative of section numbers."""
    return derivative * SCALES[:, None] / SCALES


def away(numbers):
    """From the fixed point, in the section's scales."""
    return np.abs((numbers - FIXED) / SCALES).max()


@pytest.mark.parametrize(("tolerance", "known", "within", "most"), [
    (1e-10, None, 1e-9, 60), (1e-8, 1.05 * MAP, 1e-7, 9)])
def test_an_unstable_fixed_point_of_a_bent_map_is_found(tolerance, known, within, most):
    """A kept derivative, which is not quite the map's, is corrected on the way: a derivative alone would take ten."""
    walker = MadeUp(bent, 1e-6, tolerance)
    found = fixed_point(walker, FIXED + 0.02 * SCALES, known if known is None else scaled(known))
    assert found.residual < tolerance and away(found.numbers) < within and len(walker.taken) <= most


def test_one_more_correction_leaves_little_of_where_a_search_stopped():
    walker = MadeUp(bent, 1e-6, 1e-3)
    found = fixed_point(walker, FIXED + 0.02 * SCALES, scaled(MAP))
    closer = nearer(walker, found, scaled(MAP))
    assert found.residual > 1e-5 and closer.residual < 0.05 * found.residual
    assert away(closer.numbers) < 0.05 * away(found.numbers)
    assert nearer(walker, closer, scaled(np.zeros((10, 10)))).residual <= closer.residual
    assert nearer(walker, found, scaled(np.eye(10))) is found  # a multiplier of one leads nowhere


@pytest.mark.parametrize(("central", "steps", "within"), [(True, 20, 1e-9), (False, 10, 1e-6)])
def test_multipliers_at_a_gait_are_those_of_the_map(start, central, steps, within):
    """Central differences have no error of the size of the difference, forward ones have, and cost half."""
    walker = MadeUp(bent, 1e-6, 1e-10)
    found = gait_near(walker, section_state(FIXED, start), central=central)
    assert len(walker.taken) == 1 + steps and np.array_equal(found.section_state, FIXED)
    assert found.floquet_multipliers[:4, 0] == pytest.approx(MULTIPLIERS[:4], abs=within)


@pytest.mark.parametrize("rough", [False, True])
def test_a_search_ends_where_the_steps_own_error_does(rough):
    """A made-up error of fifty tolerances, which no residual gets below for long: what is found is within it.

    Without the error the residual falls to the tolerance, however far beyond what a walk of the same steps needs.
    """
    tolerance = 1e-8

    def step(numbers):
        return bent(numbers) + 50.0 * rough * tolerance * SCALES * np.sin(1e12 * numbers)

    walker, within = MadeUp(step, 1e-6, tolerance), tolerance * (100.0 if rough else 1.0)
    found = fixed_point(walker, FIXED + 0.02 * SCALES, scaled(MAP))
    assert found.residual == np.abs((step(found.numbers) - found.numbers) / SCALES).max() <= within
    assert away(found.numbers) < 10.0 * within and len(walker.taken) < 10


def test_a_derivative_that_leads_away_is_made_anew_before_its_change_is_taken():
    """Nearly singular in one direction: its first change is ten times the distance, and the bent map leads on."""
    poor = BASIS @ np.diag([*MULTIPLIERS[:3], 0.999, *MULTIPLIERS[4:]]) @ np.linalg.inv(BASIS)
    walker = MadeUp(bent, 1e-6, 1e-10)
    assert away(fixed_point(walker, FIXED + 0.02 * SCALES, scaled(poor)).numbers) < 1e-9
    assert sum(away(taken) > 0.1 for taken in walker.taken) == 1 and len(walker.taken) < 30


@pytest.mark.parametrize(("bend", "off", "derivative", "words"), [
    *((0.0, 0.0, one, "no fixed point in reach") for one in (None, np.eye(10), (1.0 - 1e-14) * np.eye(10))),
    (1.0, 0.5, None, "no fixed point within 16 iterations, residual"),
])
def test_a_map_without_fixed_point_is_told(bend, off, derivative, words):
    """It moves each number by its scale: its derivative is one but for the round-off of differences, and Newton's
    change is infinite or nearly so. Or by more the further away it is: Newton's method goes to and fro.
    """
    walker = MadeUp(lambda numbers: numbers + SCALES * (1.0 + bend * ((numbers - FIXED) / SCALES) ** 2), 1e-4)
    with pytest.raises(NoLimitCycle, match=words):
        fixed_point(walker, FIXED + off * SCALES, derivative)


@pytest.fixture(scope="module")
def from_gait(scene):
    """Model, mid-stance of the constraint model's gait, a walk from it and its samples, for changes of the scene.

    `before`: steps of the compiled walker that lead from there to where the walk begins, nearer to the gait.
    """

    def prepared(steps, before=0, **changes):
        model = scene.but(tolerance=1e-7, **changes)
        walker, point = find_gait(model.biped, model.slope, 1e-9, None)
        upright = walker.stance_state(crossing_state(walker, point.z, 1e-9))
        state = rolling_state(model.biped, model.contact, upright, 9.4)
        if before:
            state = compiled(model, state, 1e-7).walk(state, before).state
        walked = model.walk(state, steps=steps)
        return model, state, walked, sample(walked.trajectory, model.biped, model.slope, 500.0)

    return prepared


def compiled(model, state, tolerance):
    """The compiled walker of the same model."""
    return PenaltyStepper(model.biped, model.slope, model.contact, state, PenaltySettings(tolerance))


@pytest.fixture(scope="module")
def settled(from_gait):
    """The study's gait: model, mid-stance, eight steps from there, their samples, and what `solve` says of them.

    The tolerance is one for which multipliers come from forward differences, and the walk nearly settles: so the gait
    is looked for where it ends, and one derivative does.
    """
    model, state, walked, walk = from_gait(8, before=6, largest_step=1e-3)
    return model, state, walked, walk, solve(model.at(2e-7), state, walked, walk)


def test_a_step_from_the_cycle_ends_on_it_and_a_walk_settles_there(settled):
    model, state, _, walk, (cycle, found, reason) = settled
    assert cycle.solved and not reason and cycle.residual < 1e-7
    again = model.walker(state).step(found.section_state)
    assert np.abs((again.numbers - found.section_state) / SCALES).max() < 1e-5
    periods = np.diff(walk.heel_strike_time)
    shrunk = abs(periods[-1] - cycle.period_s) / abs(periods[1] - cycle.period_s)
    assert 0.0 < shrunk < 2.0 * cycle.largest_multiplier ** (len(periods) - 2)
    assert cycle.peak_normal_force > 9.4 and cycle.double_stance_s == pytest.approx(
        walk.double_stance(walk.heel_strike_time[-2:]), rel=0.02
    )


def test_the_cycle_is_that_of_another_walker_at_a_far_finer_tolerance(settled):
    model, state, _, _, (cycle, _, _) = settled
    other = gait_near(compiled(model, state, 1e-12), state)
    assert (cycle.period_s, cycle.step_length_m) == pytest.approx((other.period_s, other.step_length_m), abs=3e-8)


def test_a_short_walk_has_not_settled_yet(settled):
    model, state, _, whole, (cycle, _, _) = settled
    far = dataclasses.replace(state, hip_velocity=(1.1 * state.hip_velocity[0], state.hip_velocity[1]))
    walked = model.walk(far, steps=2)
    walk = sample(walked.trajectory, model.biped, model.slope, 500.0)
    assert "stable, but after 2 steps the last one still differs by" in unsettled(walked, walk, cycle, "")
    unstable = dataclasses.replace(cycle, floquet_multipliers=np.array([[-1.05, 0.0], [0.6, 0.0]]))
    assert unsettled(walked, whole, unstable, "") == "its gait is unstable, largest multiplier 1.050 in magnitude"


@pytest.mark.parametrize("changed", [
    pytest.param({"slope_deg": 6.0}, marks=pytest.mark.slow),
    pytest.param({"damping": 0.0}, marks=pytest.mark.slow),
    pytest.param({"leg_inertia": 0.003}, marks=pytest.mark.slow),
])
def test_a_walk_that_does_not_settle_is_called_so(from_gait, changed):
    """Twelve steps of these are finished on this ground, with periods that differ by 17 to 21 %.

    The tolerance is one for which multipliers come from forward differences.
    """
    ground = ContactLaw(3e5, 2.2, 3e4, 1e-4, 1.1, 1.0, 0.03, 1.0)
    model, state, walked, walk = from_gait(3, contact=ground, **changed)
    assert walked.completed
    cycle, found, reason = solve(model.at(2e-7), state, walked, walk)
    assert cycle.solved and cycle.residual < 1e-5
    assert np.array_equal(found.floquet_multipliers, cycle.floquet_multipliers)
    assert cycle.largest_multiplier > 1.05 and reason.startswith("its gait is unstable, largest multiplier")


def test_without_a_fixed_point_the_walk_is_measured(settled, monkeypatch):
    """Over its last four steps."""
    model, state, walked, walk, _ = settled

    def none(*_):
        raise NoLimitCycle("the walker fell")

    monkeypatch.setattr("stages.multibody.walking.cycle.search", none)
    cycle, found, reason = solve(model, state, walked, walk)
    assert not cycle.solved and found is None and reason == "no fixed point of its step was found (the walker fell)"
    assert cycle.period_s == pytest.approx(np.diff(walk.heel_strike_time[-5:]).mean(), rel=1e-9)
    assert cycle.step_frequency_hz * cycle.period_s == pytest.approx(1.0)
    assert np.isnan(cycle.largest_multiplier) and np.isnan(cycle.residual)
    given = {field.name: None for field in dataclasses.fields(Result)}
    energy = SimpleNamespace(relative_residual=1e-8)
    said = {"outcome": "completed", "steps": 8, "settled": False, "unsettled": reason, "cycle": cycle, "energy": energy}
    assert "does not settle: no fixed point" in Result(**(given | said)).summary()


@pytest.mark.slow
def test_a_rough_search_begins_where_a_walk_ends(from_gait):
    """The same gait, its multipliers to half a hundredth (.0025 is found), for less than half the steps."""
    model, state, walked, _ = from_gait(12)
    rough, full = search(model.at(1e-6), state, walked), search(model, state)
    assert rough.steps_walked <= 15 < 30 <= full.steps_walked
    assert rough.floquet_multipliers[:2, 0] == pytest.approx(full.floquet_multipliers[:2, 0], abs=5e-3)
    assert np.abs((rough.section_state - full.section_state) / SCALES).max() < 1e-4


# --- Legs that differ, on the ground: a cycle of two steps, which both assemblies walk, and where its energy goes.


#: Frames instead of a hip mass, a hip with all it may have, and an other leg that differs in every number.
UNEQUAL = {
    "hip_mass": 0.02, "leg_inertia": 8e-4, "foot_offset": -2e-4, "frame_mass": 0.15, "frame_com": 0.015,
    "frame_offset": 5e-4, "frame_inertia": 1.7e-4, "hip_stiffness": 0.02, "hip_damping": 1e-3, "hip_rest_angle": 0.003,
    "hip_gravity_mass": 0.03, "other_foot_mass": 0.336, "other_leg_length": 0.33302, "other_foot_radius": 0.0832,
    "other_foot_com": 0.1002, "other_stiffness": 2780.0, "other_damping": 58.0, "other_leg_inertia": 8.1e-4,
    "other_foot_offset": -3e-4, "other_frame_mass": 0.148, "other_frame_com": 0.016, "other_frame_offset": 4e-4,
    "other_frame_inertia": 1.75e-4,
}  # fmt: skip


@pytest.fixture(scope="module")
def unequal(scene):
    return scene.but(**UNEQUAL)


@pytest.fixture(scope="module")
def gait(unequal):
    """The constraint model's gait."""
    walker, point = find_gait(unequal.biped, unequal.slope, 1e-9)
    return walker, point, walker.stance_state(crossing_state(walker, point.z, 1e-9))


@pytest.fixture(scope="module")
def begin(gait):
    """A model's start from that gait's mid-stance."""
    return lambda model: rolling_state(model.biped, model.contact, gait[2], 9.4)


@pytest.mark.slow
def test_a_cycle_has_two_steps_and_a_walk_settles_on_it(unequal, gait, begin):
    """On ground on which a standing foot hardly creeps: else the gaits differ by more than their limps."""
    walker, point, _ = gait
    model = unequal.but(contact=family_member(unequal.contact, 0.3), tolerance=1e-7)
    walked = model.walk(begin(model), steps=14)
    walk = sample(walked.trajectory, model.biped, model.slope, 500.0)
    cycle, _, reason = solve(model, begin(model), walked, walk)
    assert cycle.solved and not reason
    steps = np.diff(walk.heel_strike_time)
    off = np.abs(0.5 * (steps[1:] + steps[:-1]) - cycle.period_s)
    assert off[-1] < 1e-4 and off[-1] < 0.2 * off[1]
    theirs = (point.steps[1].period - point.steps[0].period) * walker.time  # leg 1 stands in the second
    assert theirs < -2e-3 and steps[-1] - steps[-2] < -2e-3
    assert cycle.floquet_multipliers[:2, 0] == pytest.approx(point.floquet_multipliers[:2].real, abs=0.015)
    assert cycle.double_stance_s == pytest.approx(walk.double_stance(walk.heel_strike_time[-3:-1]), rel=0.02)


def test_a_cycle_ends_where_it_began_with_the_same_leg_standing(scene, unequal, begin):
    numbers = section_numbers(begin(unequal))
    steps = {}
    for model, steps_a_cycle in ((scene, 1), (unequal, 2)):
        start = begin(model)
        walker = model.but(tolerance=1e-5, largest_step=2e-3).walker(start, 1e-4)
        steps[steps_a_cycle] = walker.step(numbers), walker.walk(start, 1)
        assert walker.steps_a_cycle == steps_a_cycle
    (cycle, step), (stride, half) = steps[1], steps[2]
    assert cycle.duration == step.duration
    assert 1.8 * half.duration < stride.duration < 2.2 * half.duration
    assert np.abs((stride.numbers - numbers) / SCALES).max() < 0.3  # it is near the gait


@pytest.mark.parametrize(("friction", "within"), [(0.0, 1e-6), (0.002, 1e-4)])
def test_losses_add_up_to_the_work_of_gravity(unequal, begin, friction, within):
    rough = unequal.but(hip_friction=friction, tolerance=1e-8, largest_step=1e-3)
    run = rough.walk(begin(rough), steps=2)
    assert run.completed

    strikes = sample(run.trajectory, rough.biped, rough.slope, 500.0).heel_strike_time[:2]
    balance, without = (energy_balance(run.trajectory, biped, rough.slope, rough.contact, *strikes) for biped in (
        rough.biped, unequal.but(hip_stiffness=0.0, hip_rest_angle=0.0).biped))
    assert balance.relative_residual < within and without.relative_residual > 1e-4
    assert min(balance.leg_damper_loss, balance.contact_damping_loss, balance.friction_loss) > 0.0


def test_both_assemblies_walk_it(unequal, begin):
    coarse = unequal.but(tolerance=1e-7, largest_step=1e-3, rolling_step=4e-4, impact_step=2e-5)
    tree, joints = (coarse.but(assembly=assembly).walk(begin(coarse), steps=1) for assembly in ("tree", "joints"))
    assert tree.completed and joints.completed and joints.joint_drift < 1e-7
    time = np.linspace(0.0, 0.45, 200)
    assert np.abs(tree.trajectory.at(time)[0] - joints.trajectory.at(time)[0]).max() < 2e-5


@pytest.mark.parametrize(("legs", "assembly", "keys"), [
    ("rigid", "joints", ["multibody.assembly"]), ("compliant", "joints", []), ("rigid", "tree", [])])
def test_joints_refuse_frames_on_rigid_legs_by_name(unequal, legs, assembly, keys):
    given = Parameters(**vars(unequal.but(legs=legs, assembly=assembly)))
    assert [fault.key for fault in given.broken_rules()] == keys


@pytest.mark.slow
def test_ten_unequal_designs_agree_as_designs_with_legs_alike_do():
    """What parts Exudyn from the constraint model is, design by design, that of the same design with legs alike."""
    pairs = list(compared(parameters_of("twin_ladder"), 10, 20))
    assert max(abs(unequal.limps[0]) for _, unequal in pairs) > 0.1
    for alike, unequal in pairs:
        assert abs(alike.limps[1]) < 1e-5
        assert unequal.period == pytest.approx(alike.period, abs=2e-4)
        assert unequal.step_length == pytest.approx(alike.step_length, abs=1e-4)
        assert unequal.limps[1] == pytest.approx(unequal.limps[0], rel=0.1)
        own, other = unequal.multipliers
        assert np.abs(other - own).max() < np.abs(alike.multipliers[1] - alike.multipliers[0]).max() + 0.01
