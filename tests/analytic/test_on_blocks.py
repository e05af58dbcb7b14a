"""A step onto another height, its exact derivatives by heights, and the linear spread of a gait on drawn blocks."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives, step_tangents
from stages.analytic.derivatives.on_blocks import LENGTH, on_blocks, step_on_blocks
from stages.analytic.design.goals import GOALS
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.poincare import fixed_point, start_state, step_from
from stages.analytic.model.kinds import H_AHEAD, H_BEHIND
from stages.analytic.phases.guards import foot_clearance
from stages.ground.blocks import drawn_heights
from tests.analytic.designs import FRICTION, SLOPE, TABLE_1, TABLE_1_RIGID, changed, found_gait, gait_beside
from tests.analytic.differences import extrapolated, step_slope

LONG = changed(TABLE_1_RIGID, hip_mass=0.4, foot_mass=0.3, leg_length=1.2, foot_radius=0.25, foot_com=0.4)


def on_heights(walker, ahead, behind):
    """The walker with ground of these heights, in leg lengths, about its stance foot."""
    return replace(walker, p=walker.p._replace(h_ahead=ahead, h_behind=behind))


@pytest.mark.parametrize("design", [TABLE_1, TABLE_1_RIGID, LONG])
@pytest.mark.parametrize("rise", [-4e-3, 2e-3])
def test_feet_land_on_the_height_of_their_block_and_start_from_it(design, rise):
    walker, point = found_gait(design)
    rough = on_heights(walker, rise, 0.0)
    landed = step_from(rough, start_state(rough, point.z), 1e-12)
    after = on_heights(walker, 0.0, -rise)
    assert foot_clearance(landed.state, after.p, landed.state, 0)[0] == pytest.approx(-rise, abs=1e-13)
    assert start_state(after, landed.z) == pytest.approx(landed.state, abs=1e-11)
    assert (landed.period - point.period) * rise < 0.0  # a foot lands later on a lower block


@pytest.mark.parametrize("design", [TABLE_1, TABLE_1_RIGID, LONG])
def test_derivatives_by_heights_are_those_of_differences(design):
    walker, point = found_gait(design)
    along = np.zeros((2, len(walker.p)))
    along[0, H_AHEAD] = along[1, H_BEHIND] = 1.0
    found = step_tangents(walker, point.z, along, 1e-12)
    for row in range(2):
        slope = step_slope(walker, point.z, along[row], 4e-4)
        exact = np.append(found.along[:, row], found.time_along[row])
        assert exact == pytest.approx(slope, abs=1e-7 * np.abs(slope).max())
    assert np.abs(found.along).max() > 0.1


def advance(walker, z, heights):
    """Distance of both feet after a step between three heights: trailing foot's, stance foot's, swing foot's."""
    trailing, stance, swing = heights
    standing = on_heights(walker, swing - stance, trailing - stance)
    y, p = step_from(standing, start_state(standing, z), 1e-13).state, walker.p
    return -(y[1] - p.r) * np.sin(y[0]) - (y[3] - p.r) * np.sin(y[2]) - p.r * (y[0] + y[2])


def test_the_length_of_a_step_answers_to_all_three_heights():
    walker, point = found_gait(TABLE_1)
    (_, _, measures, by_landing), _ = step_on_blocks(walker, point.z, 1e-12)
    for heights, exact in (((0, 0, 1), by_landing[LENGTH]), ((0, 1, 0), measures[LENGTH, 5]),
                           ((1, 0, 0), measures[LENGTH, 6])):  # fmt: skip
        slope = extrapolated(lambda h, at=heights: advance(walker, point.z, h * np.array(at)), 1e-4)
        assert exact == pytest.approx(slope, abs=1e-7)


def walked(walker, z, heights, rms):
    """Durations and lengths (n, 2) of the steps of a walk over blocks, by the readable rule: one block a footfall."""
    steps, blocks = [], rms * heights
    standing = on_heights(walker, blocks[2] - blocks[1], blocks[0] - blocks[1])
    y = start_state(standing, z)
    for here, ahead in pairwise(blocks[1:].tolist()):
        p = on_heights(walker, ahead - here, 0.0).p
        step = step_from(on_heights(walker, ahead - here, 0.0), y, 1e-9)
        y = step.state.copy()
        stance, swing = (p.L_nat, p.L_nat) if walker.rigid else (y[1], y[3])
        psi = y[1] if walker.rigid else y[2]
        length = -(stance - p.r) * np.sin(y[0]) - (swing - p.r) * np.sin(psi) - p.r * (y[0] + psi)
        steps.append((step.period * walker.time, length * walker.length))
        walker = walker.exchanged
    return np.array(steps)


@pytest.mark.parametrize("design", [TABLE_1, LONG])
def test_linear_spread_is_that_of_walks_over_low_blocks(design):
    walker, point = found_gait(design)
    found, rms, count, parts = on_blocks(walker, point, 1e-12), 1e-5, 4000, 20
    steps = walked(walker, point.z, drawn_heights(3, 0, 0, count + 42), rms)[40:]
    for measured, exact in zip(steps.T, (found.sensitivity_norm, found.step_length_spread), strict=True):
        spread = measured.std() / (rms * walker.length)
        batches = ((measured - measured.mean()) ** 2).reshape(parts, -1).mean(axis=1)  # correlated within a batch only
        error = batches.std(ddof=1) / np.sqrt(parts) / (2 * batches.mean())
        assert abs(spread / exact - 1) <= 0.03 + 2 * error and error < 0.03


def test_a_cycle_of_two_steps_has_the_spread_of_its_mean_step():
    walker, point = found_gait(TABLE_1)
    twice = gait_beside(TABLE_1, point.z)[1]
    double = replace(twice, steps=(*twice.steps, *twice.steps), monodromy_matrix=twice.monodromy_matrix @
                     twice.monodromy_matrix)  # fmt: skip
    one, two = (on_blocks(walker, each, 1e-12) for each in (twice, double))
    assert two.sensitivity_norm == pytest.approx(one.sensitivity_norm, rel=1e-8)
    assert two.section_spread == pytest.approx(one.section_spread, rel=1e-8)


def test_what_has_no_spread_has_none():
    walker, point = found_gait(TABLE_1, FRICTION)
    assert on_blocks(walker, point, 1e-10) is None


def test_heights_are_normal_and_do_not_depend_on_how_they_are_asked_for():
    heights = drawn_heights(7, 3, 0, 100_000)
    assert abs(heights.mean()) < 0.01 and heights.std() == pytest.approx(1.0, abs=0.01)
    assert abs(np.corrcoef(heights[1:], heights[:-1])[0, 1]) < 0.01
    for first, count in ((0, 1), (5, 7), (4, 4), (1023, 2)):
        assert (drawn_heights(7, 3, first, count) == heights[first : first + count]).all()
    assert not (drawn_heights(7, 4, 0, 8) == heights[:8]).any() and not (drawn_heights(8, 3, 0, 8) == heights[:8]).any()


def test_the_goal_of_a_design_has_the_slopes_of_the_norms_of_gaits_solved_anew():
    names = ("biped.foot_radius", "biped.stiffness", "ground.slope_deg")
    _, point = found_gait(TABLE_1)
    design, goal = DesignPoint(TABLE_1, SLOPE), GOALS["sensitivity_norm"]
    slopes = goal.slopes(gait_derivatives(design, point, names, 1e-12), 1e-12)[0]

    def there(name, share):
        walker = design.with_value(name, design.value(name) * (1 + share)).walker()
        return goal.parts(walker, fixed_point(walker, point.z, 1e-13), 1e-12)[0]

    for name, slope in zip(names, slopes, strict=True):
        assert slope == pytest.approx(extrapolated(lambda share, at=name: there(at, share), 4e-3), rel=1e-5)
