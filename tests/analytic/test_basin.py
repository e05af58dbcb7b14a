from __future__ import annotations

import numpy as np
import pytest

from stages.analytic.gait.basin import NONE, basin_of_attraction
from stages.analytic.gait.poincare import poincare_map
from stages.analytic.result import BACK, REACHES, STILL
from tests.analytic.designs import TABLE_1, found_gait


@pytest.fixture(scope="module")
def gait():
    return found_gait(TABLE_1)


def small_map(gait, workers):
    walker, point = gait
    angles, rates = np.linspace(0.1, 0.45, 12), np.linspace(0.1, 0.9, 12) / walker.time
    return basin_of_attraction(walker, [point.z], angles, rates, workers=workers)


@pytest.fixture(scope="module")
def mapped(gait):
    return small_map(gait, 2)


def test_the_map_does_not_depend_on_the_number_of_workers(gait, mapped):
    one, two = small_map(gait, 1), mapped
    assert (one.steps == two.steps).all()
    assert (one.ending == two.ending).all()
    assert (one.reached == two.reached).all()


def test_the_gait_lies_in_its_own_basin_and_a_standstill_does_not(gait):
    walker, point = gait
    rates = np.array([point.z[3], 0.01]) / walker.time
    mapped = basin_of_attraction(walker, [point.z], np.array([-point.z[0]]), rates, steps=30)
    assert mapped.reached.tolist() == [[0, NONE]]
    assert mapped.ending[0, 0] == REACHES and mapped.ending[0, 1] in (BACK, STILL)
    assert mapped.steps[0, 1] < 30


def test_a_start_in_the_basin_does_walk_to_the_gait(gait, mapped):
    walker, point = gait
    inside = np.argwhere(mapped.reached >= 0)
    assert len(inside) > 3
    row, column = inside[0]
    z = point.z.copy()
    z[0], z[3] = -mapped.stance_angle[row], mapped.stance_rate[column] * walker.time
    for _ in range(80):
        z = poincare_map(walker, z, 1e-8).z
    assert z == pytest.approx(point.z, abs=1e-6)
