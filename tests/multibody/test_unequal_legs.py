"""Legs that differ, on the ground: a cycle of two steps, which both assemblies walk, and where its energy goes."""

import numpy as np
import pytest

from benchmarks.unequal_designs import compared
from pipeline.parameters.loading import load
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.recording import crossing_state
from stages.ground.contact_law import family_member
from stages.multibody.parameters import Parameters
from stages.multibody.walking.cycle import solve
from stages.planar.energy import energy_balance
from stages.planar.run import rolling_state
from stages.planar.sampling import sample
from stages.planar.section import section_numbers
from stages.stability.parameters import Parameters as Stability
from stages.twin_ladder.parameters import Parameters as Ladder
from tests.planar_start import SCALES

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

    def residual(model):
        return energy_balance(run.trajectory, model.biped, model.slope, model.contact, *strikes[:2]).relative_residual

    strikes = sample(run.trajectory, rough.biped, rough.slope, 500.0).heel_strike_time
    assert residual(rough) < within and residual(unequal.but(hip_stiffness=0.0, hip_rest_angle=0.0)) > 1e-4


def test_both_assemblies_walk_it(unequal, begin):
    coarse = unequal.but(tolerance=1e-7, largest_step=1e-3, rolling_step=4e-4, impact_step=2e-5)
    tree, joints = (coarse.but(assembly=assembly).walk(begin(coarse), steps=1) for assembly in ("tree", "joints"))
    assert tree.completed and joints.completed and joints.joint_drift < 1e-7
    time = np.linspace(0.0, 0.45, 200)
    assert np.abs(tree.trajectory.at(time)[0] - joints.trajectory.at(time)[0]).max() < 2e-5


@pytest.mark.parametrize(("legs", "assembly", "keys"), [
    ("rigid", "joints", ["multibody.assembly"]), ("compliant", "joints", []), ("rigid", "tree", [])])
def test_joints_refuse_frames_on_rigid_legs_by_name(unequal, legs, assembly, keys):
    given = Parameters(*vars(unequal.but(legs=legs, assembly=assembly)).values())
    assert [fault.key for fault in given.broken_rules()] == keys


@pytest.mark.slow
def test_ten_unequal_designs_agree_as_designs_with_legs_alike_do(repository):
    """What parts Exudyn from the constraint model is, design by design, that of the same design with legs alike."""
    parameters = load(repository / "params", [], {"twin_ladder": Ladder}, [Ladder, Stability])["twin_ladder"]
    pairs = list(compared(parameters, 10, 20))
    assert max(abs(unequal.limps[0]) for _, unequal in pairs) > 0.1
    for alike, unequal in pairs:
        assert abs(alike.limps[1]) < 1e-5
        assert unequal.period == pytest.approx(alike.period, abs=2e-4)
        assert unequal.step_length == pytest.approx(alike.step_length, abs=1e-4)
        assert unequal.limps[1] == pytest.approx(unequal.limps[0], rel=0.1)
        own, other = unequal.multipliers
        assert np.abs(other - own).max() < np.abs(alike.multipliers[1] - alike.multipliers[0]).max() + 0.01
