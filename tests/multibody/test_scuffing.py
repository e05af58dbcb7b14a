"""The ideal rule against scuffing, and stepping blocks that do the same."""

import numpy as np
import pytest

from stages.ground.friction import SCALARS, Lane, lanes
from stages.planar.run import FELL
from stages.planar.sampling import sample


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
