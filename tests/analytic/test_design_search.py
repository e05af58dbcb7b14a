from __future__ import annotations

import numpy as np
import pytest

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.design_search import Problem, search_design
from stages.analytic.gait.gait_search import find_gait
from tests.analytic.designs import SLOPE, TABLE_1

DESIGN = DesignPoint(TABLE_1, SLOPE)
TOLERANCE = 1e-10


@pytest.fixture(scope="module")
def start():
    return find_gait(TABLE_1, SLOPE, TOLERANCE)[1].z


def within(share, *names):
    return {name: ((1 - share) * DESIGN.value(name), (1 + share) * DESIGN.value(name)) for name in names}


def test_the_search_beats_every_design_of_a_grid(start):
    bounds = within(0.1, "biped.foot_com", "biped.damping")
    found = search_design(DESIGN, start, bounds, tolerance=TOLERANCE)
    problem = Problem(DESIGN, bounds, {}, TOLERANCE)
    grid = [
        problem.candidate(np.array([x, y]), start) for x in np.linspace(0.9, 1.1, 5) for y in np.linspace(0.9, 1.1, 5)
    ]
    best = min(candidate.largest_multiplier for candidate in grid if candidate is not None)
    assert found.converged
    assert found.best.largest_multiplier <= best + 1e-6
    assert found.best.largest_multiplier < found.start.largest_multiplier - 0.01


def test_an_optimum_inside_the_bounds_is_one(start):
    """Leg length alone: two multipliers cross inside the bounds, so the optimum is a kink."""
    bounds = within(0.05, "biped.leg_length")
    found = search_design(DESIGN, start, bounds, tolerance=TOLERANCE)
    problem = Problem(DESIGN, bounds, {}, TOLERANCE)
    x = np.array([found.best.design.value("biped.leg_length") / DESIGN.value("biped.leg_length")])
    for step in (-1e-3, 1e-3):
        beside = problem.candidate(x + step, found.best.point.z)
        assert beside is None or beside.largest_multiplier >= found.best.largest_multiplier - 1e-7


def test_targets_are_held_and_bounds_kept(start):
    bounds = within(0.15, "biped.foot_com", "biped.foot_radius", "biped.stiffness")
    found = search_design(DESIGN, start, bounds, targets={"speed_m_s": 0.334}, tolerance=TOLERANCE)
    assert found.best.gait.speed_m_s == pytest.approx(0.334, rel=1e-6)
    for name, (low, high) in bounds.items():
        assert low - 1e-12 <= found.best.design.value(name) <= high + 1e-12


def test_a_design_without_a_gait_cannot_start_a_search():
    flat = DESIGN.with_value("ground.slope_deg", 0.0)
    with pytest.raises(ValueError, match="no gait"):
        search_design(flat, np.array([-0.2, 1.0, 1.0, 0.4, 0.0]), within(0.1, "biped.foot_com"), tolerance=TOLERANCE)
