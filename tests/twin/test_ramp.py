"""The ramp: where blocks lie, that walking on them is walking, and what ends a run."""

import dataclasses
import re

import numpy as np
import pytest

from pipeline.errors import StudyError
from stages.ground.blocks import Blocks, BlocksDoNotFit
from stages.planar.run import COMPLETED
from stages.twin.ramp import lay_blocks
from stages.twin.walking.simulate import MISSED
from tests.study import parameters_of

STEP, BLOCKS = 0.16, Blocks()


@pytest.fixture(scope="module")
def on_blocks(machine, settings, walk_from):
    """Walk some steps on a ramp, pushed or not; keywords change the settings."""

    def walk(steps, push=None, step=STEP, **changes):
        blocks = Blocks(block_sets=changes.pop("block_sets", 11))
        ramp = lay_blocks(dataclasses.replace(settings, scene="ramp", **changes), blocks, step)
        return walk_from(machine, steps, ramp=ramp, push=push, **{"scene": "ramp", "tolerance": 1e-5, **changes})

    return walk


def test_sets_lie_a_step_apart_and_in_turn(settings):
    ramp = lay_blocks(settings, BLOCKS, STEP)
    half, track = 0.5 * BLOCKS.block_length, (settings.inner_lane, settings.outer_lane)
    for number in range(-2, BLOCKS.block_sets + 2):
        own, other = number % 2, 1 - number % 2
        there = 0 <= number < BLOCKS.block_sets
        for x, inside in ((0.0, there), (0.99 * half, there), (-1.01 * half, False), (1.01 * half, False)):
            assert ramp.carries(own, number * STEP + x, -track[own], 0.01) == inside
        assert not ramp.carries(other, number * STEP, track[other], 0.01)
    assert ramp.steps == 10 and ramp.number(1, 3.1 * STEP) == 4
    assert ramp.miss(0, 2 * STEP - half - 0.003) == pytest.approx(-0.003)


def test_a_foot_over_the_side_is_not_carried(settings):
    ramp = lay_blocks(settings, BLOCKS, STEP)
    room = 0.5 * (BLOCKS.block_width - settings.foot_width)
    assert ramp.carries(0, 0.0, settings.inner_lane + 0.99 * room, 0.5 * settings.foot_width)
    assert not ramp.carries(0, 0.0, settings.inner_lane + 1.01 * room, 0.5 * settings.foot_width)


def test_blocks_under_the_feet_give_the_walk_of_the_plane(machine, walk_from, on_blocks):
    """The feet switch elsewhere, but always in the air: no bit of the motion changes."""
    plane, ramp = walk_from(machine, 2, tolerance=1e-5), on_blocks(2)
    assert ramp.outcome == COMPLETED
    assert np.array_equal(ramp.position, plane.position) and np.array_equal(ramp.time, plane.time)
    assert [time for time, *_ in ramp.switches] != [time for time, *_ in plane.switches]


def test_the_walk_ends_on_the_last_set(on_blocks):
    record = on_blocks(50, block_sets=3)
    assert record.outcome == COMPLETED and record.heel_strikes == 2


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"expected_step": 0.19, "ramp_length": 3.0},
            r"in step \d the \w+ left foot came down .* mm short of block set",
        ),
        ({"expected_step": 0.13}, r"in step \d the \w+ left foot (went off the end|struck|came down .* beyond)"),
        ({"push": {"yaw": 0.05}}, r"in step \d the \w+ \w+ foot .*(side|beside)"),
    ],
)
def test_a_missed_block_ends_the_run_with_that_reason(on_blocks, changes, said):
    record = on_blocks(10, **changes)
    assert record.outcome == MISSED and record.heel_strikes < 10
    assert re.match(said, record.reason), record.reason
    assert np.isfinite(record.position).all()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("ground.block_length=0.6", "block_length is not allowed; allowed: < two steps"),
        ("ground.block_width=0.05", "blocks side by side overlap"),
        ("twin.expected_step=0.3", "11 sets of blocks find no room"),
        ("ground.block_sets=1", "block_sets = 1"),
        ("twin.block_length=0.06", 'there is no parameter "block_length" in twin; did you mean "ground.block_length"?'),
        ("multibody.block_length=0.06", 'did you mean "ground.block_length"?'),
    ],
)
def test_impossible_blocks_are_refused_with_the_parameters(change, said):
    with pytest.raises(StudyError) as refused:
        parameters_of("twin", "twin.scene=ramp", change)
    assert said in str(refused.value) and len(refused.value.sentences) == 1


def test_blocks_that_overlap_at_the_gaits_step_are_refused(settings):
    with pytest.raises(BlocksDoNotFit, match=r"block_length = 0.35 m .* the blocks of a lane overlap$"):
        lay_blocks(settings, Blocks(block_length=0.35), STEP)


@pytest.mark.slow
def test_the_whole_ramp_is_walked(settings, on_blocks):
    record = on_blocks(settings.steps, step=0.1612, tolerance=settings.tolerance)
    assert record.outcome == COMPLETED and record.heel_strikes == BLOCKS.block_sets - 1
