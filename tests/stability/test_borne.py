"""The height of blocks that a design bears, and the search for designs that walk longer on them."""

from __future__ import annotations

import pytest

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.poincare import fixed_point
from stages.ground.blocks import Blocks
from stages.stability.blocks.borne import EVERY, STEPS, Borne
from stages.stability.blocks.passage import Counted
from stages.stability.blocks.walks import Rough, some_walks
from tests.analytic.designs import SLOPE, TABLE_1, TABLE_1_RIGID, changed, found_gait

LARGE = changed(
    TABLE_1_RIGID, hip_mass=8 * 0.316, foot_mass=8 * 0.335, leg_length=2 * 0.333, foot_radius=2 * 0.083, foot_com=0.2)


@pytest.mark.parametrize("design", [TABLE_1, TABLE_1_RIGID])
def test_on_blocks_as_high_as_it_bears_a_walker_falls_as_often_as_the_staircase_wants(design):
    walker, point = found_gait(design)
    height = Borne(Blocks()).of(walker, point.z)
    counted = Counted(10)
    counted.add(some_walks(Rough(walker, point.z, height / walker.length, 0.08 / walker.length), 5, 0, STEPS))
    found = counted.passage()
    assert found.steps_low < 1.15 * EVERY and found.steps_high > EVERY / 1.15  # the staircase is spread about its mean


def test_a_robot_twice_as_large_bears_blocks_twice_as_high():
    heights = [Borne(Blocks(block_length=length)).of(walker, point.z) for length, (walker, point) in (
        (0.08, found_gait(TABLE_1_RIGID)), (0.16, found_gait(LARGE)))]
    assert heights[1] == pytest.approx(2 * heights[0], rel=0.02)  # round-off alone makes another walk in the end


def test_slopes_are_the_differences_of_gaits_solved_anew():
    _, point = found_gait(TABLE_1_RIGID)
    design, bears = DesignPoint(TABLE_1_RIGID, SLOPE), Borne(Blocks())
    [slopes] = bears.slopes(gait_derivatives(design, point, ("biped.foot_radius", "biped.hip_mass"), 1e-10), 1e-10)

    def there(share):
        walker = design.with_value("biped.foot_radius", design.value("biped.foot_radius") * (1 + share)).walker()
        return bears.parts(walker, fixed_point(walker, point.z, 1e-10), 1e-10)[0]

    assert slopes[0] == pytest.approx((there(0.04) - there(-0.04)) / 0.08, rel=0.2)
    assert slopes[0] > 2 * abs(slopes[1])


def test_blocks_that_reach_the_other_foot_are_not_borne():
    walker, point = found_gait(TABLE_1)
    with pytest.raises(StepFailed, match="reaches the other foot"):
        Borne(Blocks(block_length=0.3)).of(walker, point.z)
