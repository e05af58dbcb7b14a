"""Mid-stance in numbers, and what a step may and may not do to them."""

import dataclasses
import itertools

import numpy as np
import pytest

from stages.analytic.gait.gait_search import find_gait, step_lengths
from stages.multibody.walking.cycle import SectionWalker
from stages.multibody.walking.walk import simulate
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings as PenaltySettings
from stages.planar.limit_cycle import gait_near
from stages.planar.sampling import sample
from stages.planar.section import NoLimitCycle, section_numbers, section_state as planar_state
from stages.studies.result import COMPLETED
from stages.twin.machine.machine import build, join
from stages.twin.machine.projection import project
from stages.twin_ladder.cycle import (
    UPRIGHT,
    SectionState,
    leading,
    multipliers_of,
    section_state,
    start_from,
    step_map,
)
from stages.twin_ladder.run import PHASES, STANDING, beside, constraint_gait, constraint_gaits, planar_rung, rungs


@pytest.fixture(scope="module")
def take(machines, parameters):
    """A step of the rung with this number at a fine tolerance."""
    fine = dataclasses.replace(parameters.twin, tolerance=1e-7, largest_step=1e-3)
    maps = {}

    def step(rung, plane, side=UPRIGHT, stance=0):
        if rung not in maps:
            maps[rung] = step_map(machines[rung].machine, parameters.slope, parameters.contact, fine)
        return maps[rung](SectionState(plane, side), stance)

    return step


@pytest.mark.parametrize("stance", [0, 1])
def test_numbers_and_start_are_inverse(stance):
    length = np.array([0.333, 0.334, 0.335, 0.336])
    rng = np.random.default_rng(3)
    state = SectionState(rng.normal(size=10), rng.normal(size=9))
    start = start_from(state, stance, length)
    back = section_state(start.position, start.velocity, stance, length)
    assert back.plane == pytest.approx(state.plane, abs=1e-14) and back.side == pytest.approx(state.side, abs=1e-14)
    assert start.in_play == (stance == 0, stance == 1)


def test_pairs_and_width_do_not_change_a_step_in_the_plane(take, plane, parameters):
    """Without and with width, from the inner and from the outer pair: the step of the planar checker."""
    steps = [take(rung, plane, stance=stance) for rung in (0, 1) for stance in (0, 1)]
    start = planar_state(plane, STANDING)
    planar = dataclasses.replace(parameters.planar, assembly="tree", tolerance=1e-7, largest_step=1e-3)
    assert np.array_equal(section_numbers(start), plane)
    run = simulate(parameters.biped, parameters.slope, parameters.contact, start, planar, steps=1)
    landed = sample(run.trajectory, parameters.biped, parameters.slope, 500.0).heel_strike_time
    assert len(landed) == 1
    for step in steps:
        assert abs(step.end.plane - steps[0].end.plane).max() < 1e-6
        assert abs(step.end.side).max() < 1e-9
        hip = run.trajectory.at(np.array([step.duration]))[0][0]
        assert step.length == pytest.approx(hip[0], abs=1e-7) and step.end.plane[0] == pytest.approx(hip[1], abs=1e-7)


def test_a_mirrored_disturbance_ends_mirrored(take, plane):
    side = np.array([0.01, 0.0, 0.0, 0.0, 0.01, 0.05, 0.02, 0.0, 0.0])
    one, other = (take(1, plane, sign * side).end for sign in (1.0, -1.0))
    assert one.side == pytest.approx(-other.side, abs=1e-7) and abs(one.side).max() > 1e-3
    assert one.plane == pytest.approx(other.plane, abs=1e-7)


def test_width_resists_what_a_line_does_not(take, plane):
    """A foot without width turns more freely: half a yaw rate is lost in both, but the twist goes on longer."""
    spin = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0])
    narrow, wide = (take(rung, plane, spin).end.side[0] for rung in (0, 1))
    assert 0.0 < wide < narrow


def test_a_start_that_falls_back_has_no_step(take, plane):
    back = plane.copy()
    back[[4, 6, 7]] = -0.66, 2.0, 0.0
    with pytest.raises(NoLimitCycle):
        take(1, back)


def test_multipliers_of_alike_steps_are_those_of_one():
    rng = np.random.default_rng(11)
    vectors = rng.normal(size=(5, 5))
    block = np.array([[0.3, -0.4], [0.4, 0.3]])
    wanted = np.zeros((5, 5))
    wanted[:2, :2], wanted[2, 2], wanted[3, 3] = block, -0.9, 0.6
    derivative = vectors @ wanted @ np.linalg.inv(vectors)
    found = multipliers_of(np.eye(5), derivative, derivative @ derivative)
    assert found[0] == pytest.approx(-0.9) and found[1] == pytest.approx(0.6)
    assert sorted(found[2:4], key=lambda value: value.imag) == pytest.approx([0.3 - 0.4j, 0.3 + 0.4j])


def test_multipliers_of_a_step_square_to_those_of_the_stride():
    rng = np.random.default_rng(12)
    one, other = rng.normal(size=(2, 4, 4))
    found = np.sort_complex(multipliers_of(np.eye(4), one, other @ one) ** 2)
    assert found == pytest.approx(np.sort_complex(np.linalg.eigvals(other @ one).astype(complex)))
    assert found == pytest.approx(np.sort_complex(multipliers_of(np.eye(4), one, other @ one, steps=2)))


@pytest.mark.parametrize(
    ("values", "wanted", "all_nine"),
    [
        ((-0.9, 0.6, 0.01), [-0.9, 0.6], False),
        ((0.7, 0.7j, 0.02), [0.7j, -0.7j], True),  # three of one size: two changes cannot hold them
        ((0.9j, 0.02, 0.01), [0.9j, -0.9j], False),
        ((0.8, 0.7999, 0.7998), [0.8, 0.7999], None),
    ],
)
def test_leading_multipliers_are_found_from_few_changes(values, wanted, all_nine):
    """An imaginary one stands for a pair. The made-up step is linear, its vectors are far from orthogonal."""
    rng = np.random.default_rng(8)
    blocks = [np.array([[0.0, abs(value)], [-abs(value), 0.0]]) if isinstance(value, complex) else np.array([[value]])
              for value in values]  # fmt: skip
    diagonal, at = np.zeros((9, 9)), 0
    for block in blocks:
        diagonal[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    vectors = rng.normal(size=(9, 9))
    step = vectors @ diagonal @ np.linalg.inv(vectors)
    asked = []

    def changes(change):
        asked.append(change)
        return step @ change, step @ step @ change

    found, basis = leading(changes, rng.normal(size=(9, 2)), 5e-4)
    assert basis.shape == (9, 2) and np.sort_complex(np.abs(found)) == pytest.approx(np.sort(np.abs(wanted)), abs=2e-3)
    if all_nine is not None:
        assert (len(asked) > 12) is all_nine
    if all_nine is False:
        assert np.sort_complex(found) == pytest.approx(np.sort_complex(np.array(wanted, dtype=complex)), abs=2e-3)


# --- The machines of the ladder: one thing more each, the same masses, the twin among them.


def test_each_rung_differs_from_the_one_before(machines):
    for one, other in itertools.pairwise(machines):
        with pytest.raises(AssertionError):
            np.testing.assert_equal(*map(dataclasses.asdict, (one.machine, other.machine)))


def test_no_rung_changes_the_masses_of_table_1(machines, parameters):
    """But the outsole, which comes on top of them."""
    for rung in machines[:-1]:
        assert rung.machine.mass == pytest.approx(parameters.biped.total_mass, abs=1e-4)
        for pair in (rung.machine.bodies[1:3], rung.machine.bodies[4:6]):
            assert join(pair).mass == pytest.approx(parameters.biped.foot_mass, abs=5e-5)


def test_the_outsoles_weigh_what_their_rubber_does(machines, parameters):
    rubber = parameters.twin.mass(parameters.biped.foot_radius, parameters.settings.outsole)
    assert machines[-1].machine.mass - machines[-2].machine.mass == pytest.approx(4.0 * rubber) and rubber > 0.004


def test_the_twin_is_one_of_them(machines, parameters):
    (twin,) = [rung for rung in machines if rung.is_twin]
    np.testing.assert_equal(*map(dataclasses.asdict, (twin.machine, build(parameters.biped, parameters.twin))))
    assert machines[-1].name == "rubber outsoles" and not machines[-1].is_twin


def test_an_outsole_or_friction_of_the_twin_moves_it_up(parameters):
    soled = dataclasses.replace(parameters.twin, outsole=0.001, slider_friction=2.0)
    found = rungs(parameters.biped, soled, 0.002)
    assert [rung.is_twin for rung in found] == [False] * 5 + [True]
    np.testing.assert_equal(*map(dataclasses.asdict, (found[-1].machine, build(parameters.biped, soled))))
    assert found[-1].machine.length == pytest.approx(parameters.biped.leg_length + 0.001)
    assert found[-2].name == "joint friction"


def test_planar_inertia_leaves_out_the_rungs_of_the_parts(parameters):
    planar = dataclasses.replace(parameters.twin, inertia="planar")
    assert [rung.name for rung in rungs(parameters.biped, planar, 0.002)] == [
        "paired legs", "foot width", "rubber outsoles",
    ]  # fmt: skip


def test_rungs_of_rigid_legs_name_no_spring(machines, parameters):
    rigid = [(one.name, one.added) for one in rungs(dataclasses.replace(parameters.biped, legs="rigid"),
                                                    parameters.twin, 0.002)]  # fmt: skip
    assert "spring" not in str(rigid) and "leg mass above the spring" in [rung.name for rung in machines]


def test_distributed_inertia_keeps_the_mass_centres(machines):
    points, spread = (rung.machine for rung in machines[1:3])
    for one, other in zip(points.bodies, spread.bodies, strict=True):
        assert other.centre == pytest.approx(one.centre, abs=2e-6)
    assert np.trace(spread.bodies[1].inertia) > 0.0 and not points.bodies[1].inertia.any()


# --- The constraint model of a rung's machine: its numbers, its alternation, and what is left between the two.


TOLERANCE = 1e-9


@pytest.fixture(scope="module")
def twin(machines):
    """The machine of the bill, without rubber."""
    return next(rung.machine for rung in machines if rung.name == "leg mass above the spring")


@pytest.fixture(scope="module")
def own(twin, parameters):
    return constraint_gait(project(twin), parameters.slope, TOLERANCE)


@pytest.fixture(scope="module")
def simple(parameters):
    return constraint_gait(parameters.biped, parameters.slope, TOLERANCE)


def multipliers_in(gait):
    return gait.row.multipliers @ [1.0, 1.0j]


def test_a_machine_with_legs_alike_does_not_limp(simple, parameters):
    walker, point = find_gait(parameters.biped, parameters.slope, TOLERANCE)
    assert simple.row.outcome == COMPLETED
    assert simple.row.period_s == pytest.approx(point.period * walker.time, abs=1e-12)
    assert simple.row.step_length_m == pytest.approx(step_lengths(walker, point)[0] * walker.length, abs=1e-12)
    assert multipliers_in(simple) == pytest.approx(point.floquet_multipliers[:2], abs=1e-9)
    assert abs(simple.row.inner_outer_difference) < 1e-6
    half = len(PHASES) // 2
    assert simple.hip[half] == pytest.approx(simple.hip[0] + [simple.row.step_length_m, 0.0], abs=1e-6)


def test_multipliers_of_a_step_are_roots_of_the_strides(own, twin, parameters):
    _, point = find_gait(project(twin), parameters.slope, TOLERANCE)
    assert len(point.steps) == 2
    assert multipliers_in(own)**2 == pytest.approx(point.floquet_multipliers[:2], abs=1e-9)
    assert multipliers_in(own)[0].real < -0.7 and multipliers_in(own)[1].real > 0.6
    assert own.hip[-1] == pytest.approx(own.hip[0] + [2 * own.row.step_length_m, 0.0], abs=1e-6)


def test_legs_exchanged_limp_the_other_way(own, twin, parameters):
    other = constraint_gait(project(twin).exchanged, parameters.slope, TOLERANCE)
    assert other.row.period_s == pytest.approx(own.row.period_s, abs=1e-9)
    assert other.row.step_length_m == pytest.approx(own.row.step_length_m, abs=1e-9)
    assert multipliers_in(other) == pytest.approx(multipliers_in(own), abs=1e-6)
    limp = own.row.inner_outer_difference
    assert abs(limp) > 5e-4 and other.row.inner_outer_difference == pytest.approx(-limp, abs=1e-6)


def test_the_planar_rung_of_legs_that_differ_limps_as_the_constraint_model(parameters, plane):
    """And its multipliers are those of two steps, as those of the machines in space."""
    lame = dataclasses.replace(parameters, biped=dataclasses.replace(parameters.biped, other_foot_mass=0.338))
    stepper = PenaltyStepper(lame.biped, lame.slope, lame.contact, planar_state(plane, STANDING), PenaltySettings(1e-9))
    found, _ = planar_rung(lame, gait_near(stepper, stepper.start))
    own = constraint_gaits(lame, [lame.biped])[0].row
    assert abs(own.inner_outer_difference) > 0.05
    assert found.inner_outer_difference == pytest.approx(own.inner_outer_difference, abs=5e-3)
    _, point = find_gait(lame.biped, lame.slope, TOLERANCE)
    np.testing.assert_allclose(own.multipliers @ [1.0, 1.0j], point.floquet_multipliers[:2], atol=1e-6)
    np.testing.assert_allclose(found.plane_multipliers, own.multipliers, atol=0.02)


def test_a_machine_without_a_gait_says_why(parameters, simple):
    level = constraint_gait(parameters.biped, dataclasses.replace(parameters.slope, slope_deg=0.0), TOLERANCE)
    assert level.row.outcome != COMPLETED and np.isnan(level.row.period_s) and not len(level.row.multipliers)
    row = beside("level", level, simple, simple.hip)
    assert not row.found and np.isnan(row.hip_apart_m).all() and row.hip_from_simple_m == pytest.approx([0.0, 0.0])


@pytest.mark.parametrize("stance", [0, 1])
def test_in_exudyn_the_twin_steps_as_its_planar_projection(twin, plane, parameters, stance):
    """Two models of Exudyn's, one with eleven coordinates, one with six: a step from either pair."""
    fine = dataclasses.replace(parameters.twin, tolerance=3e-8, largest_step=1e-3)
    spatial = step_map(twin, parameters.slope, parameters.contact, fine)(SectionState(plane, UPRIGHT), stance)
    biped = project(twin) if stance == 0 else project(twin).exchanged
    settings = dataclasses.replace(parameters.planar, assembly="tree", tolerance=3e-8, largest_step=1e-3)
    start = planar_state(plane, STANDING)
    walker = SectionWalker(biped, parameters.slope, parameters.contact, start, settings, 1e-4)
    step = walker.walk(start, 1)
    assert step.numbers == pytest.approx(spatial.end.plane, abs=2e-6)
    assert step.duration == pytest.approx(spatial.duration, abs=1e-7)
    assert step.length == pytest.approx(spatial.length, abs=1e-7)
    simple = SectionWalker(parameters.biped, parameters.slope, parameters.contact, start, settings, 1e-4)
    assert abs(simple.walk(start, 1).duration - spatial.duration) > 1e-3
