"""Families of gaits: the simplest walker's published period doubling, and consistency along a branch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stages.analytic.errors import NoGait
from stages.analytic.gait.continuation import PERIOD_DOUBLING, TURNING_POINT, continue_gait, follow_family
from stages.analytic.gait.design_point import DesignPoint, parameter_names
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import fixed_point, poincare_map
from stages.biped.design import Biped
from stages.ground.slope import Slope
from tests.analytic.designs import SLOPE, TABLE_1, changed

TOLERANCE = 1e-11
START = np.array([-0.2, 0.2, -0.184])


def simplest_walker(mass_ratio: float = 1e7) -> DesignPoint:
    """Garcia's walker (1998): all mass at the hip, point feet."""
    return DesignPoint(Biped("rigid", mass_ratio, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0), Slope(math.degrees(0.009), 1.0))


@pytest.fixture(scope="module")
def cascade():
    """Families of cycle 1, 2, 4 and 8 over the slope."""
    limits = (math.degrees(0.001), math.degrees(0.0185))
    return follow_family(simplest_walker(), "ground.slope_deg", limits, START, TOLERANCE, doublings=3)


def doublings(branches):
    return {
        branch.cycle: math.radians(point.value)
        for branch in branches
        for kind, point in branch.special
        if kind == PERIOD_DOUBLING
    }


def test_period_doubles_at_the_published_slope(cascade):
    """Garcia et al. (1998): stable below 0.0151; more digits in later work, 0.01509."""
    assert doublings(cascade)[1] == pytest.approx(0.01509, abs=1e-5)


def test_cycles_of_two_four_and_eight_follow_at_feigenbaums_pace(cascade):
    slopes = doublings(cascade)
    assert sorted(slopes) == [1, 2, 4, 8]
    gaps = np.diff([slopes[cycle] for cycle in (1, 2, 4, 8)])
    assert (gaps > 0).all()
    assert gaps[1] / gaps[2] == pytest.approx(4.669, rel=0.05)


def test_a_doubling_has_a_multiplier_of_minus_one(cascade):
    point = next(point for kind, point in cascade[0].special if kind == PERIOD_DOUBLING)
    assert np.abs(point.floquet_multipliers + 1).min() < 1e-9


def test_a_doubling_is_no_turning_point(cascade):
    """A doubled family is upright where it leaves the old one, but no two gaits meet and vanish there."""
    assert not [point for branch in cascade for kind, point in branch.special if kind == TURNING_POINT]


def test_longer_cycles_do_not_close_earlier(cascade):
    for branch in cascade[1:]:
        point = branch.points[len(branch.points) // 2]
        walker = simplest_walker().with_value(branch.name, point.value).walker()
        z, gaps = point.z, []
        for _ in range(branch.cycle):
            z = poincare_map(walker, z, TOLERANCE).z
            gaps.append(np.abs(z - point.z).max())
        assert gaps[-1] < 1e-9
        assert min(gaps[:-1]) > 1e-6


def test_points_of_a_branch_are_the_gaits_newton_finds(cascade):
    for point in cascade[0].points[::8]:
        walker = simplest_walker().with_value("ground.slope_deg", point.value).walker()
        again = fixed_point(walker, point.z + 1e-4, TOLERANCE)
        assert again is not None
        assert again.z == pytest.approx(point.z, abs=1e-9)


def test_a_family_is_followed_round_its_turning_points():
    """Table 1's gait turns three times in the damping: between two of the turns four gaits stand side by side."""
    design = DesignPoint(TABLE_1, SLOPE)
    z = np.array([-0.2648, 1.00253, 0.99483, 0.4220, -0.1568])
    branch = continue_gait(design, "biped.damping", (50.0, 195.0), z, 1e-8)
    turns = [point for kind, point in branch.special if kind == TURNING_POINT]
    assert len(turns) == 3
    for turn in turns:
        assert np.abs(turn.floquet_multipliers - 1).min() < 1e-4
    values = np.array([point.value for point in branch.points])
    between = 0.5 * (turns[1].value + turns[2].value)
    assert (np.diff(np.sign(values - between)) != 0).sum() == 4
    assert values[-1] == pytest.approx(50.0, abs=1e-12), "the family is followed onto the limit itself"
    assert values.max() == pytest.approx(188.074, abs=1e-2) and values.max() <= turns[0].value + 1e-6


@pytest.mark.slow
def test_no_gait_is_found_where_the_families_have_turned_back():
    """Soft dampers lose the gait at a turning point near 188 N s/m, stiff ones near 524; between them nothing walks."""
    for damping, walks in ((180.0, True), (300.0, False), (530.0, True)):
        design = changed(TABLE_1, damping=damping)
        if walks:
            assert find_gait(design, SLOPE, 1e-10)[1].residual <= 1e-10
        else:
            with pytest.raises(NoGait, match="no periodic gait in the range searched"):
                find_gait(design, SLOPE, 1e-10)


def test_names_reach_every_number_of_the_design():
    design = simplest_walker()
    for name in parameter_names():
        assert design.with_value(name, 0.123).value(name) == 0.123
    with pytest.raises(KeyError, match=r"biped\.hip_mass"):
        design.value("biped.hip_mas")
