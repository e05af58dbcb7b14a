"""Mid-stance in numbers, and what a step may and may not do to them."""

import dataclasses

import numpy as np
import pytest

from stages.multibody.walking.walk import simulate
from stages.planar.sampling import sample
from stages.planar.section import NoLimitCycle, section_numbers
from stages.planar.section import section_state as planar_state
from stages.twin_ladder.cycle import (
    UPRIGHT,
    SectionState,
    leading,
    section_state,
    start_from,
    step_map,
    step_multipliers,
)
from stages.twin_ladder.run import STANDING


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
    found = step_multipliers(np.eye(5), derivative, derivative @ derivative)
    assert found[0] == pytest.approx(-0.9) and found[1] == pytest.approx(0.6)
    assert sorted(found[2:4], key=lambda value: value.imag) == pytest.approx([0.3 - 0.4j, 0.3 + 0.4j])


def test_multipliers_of_two_steps_square_to_those_of_the_stride():
    rng = np.random.default_rng(12)
    one, other = rng.normal(size=(2, 4, 4))
    found = np.sort_complex(step_multipliers(np.eye(4), one, other @ one) ** 2)
    assert found == pytest.approx(np.sort_complex(np.linalg.eigvals(other @ one).astype(complex)))


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
