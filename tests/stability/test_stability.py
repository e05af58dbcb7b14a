"""The gait over the slope and from other starts, against walks that know nothing of continuation."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.optimize import brentq

from stages.analytic.errors import StepFailed
from stages.analytic.gait.continuation import PERIOD_DOUBLING
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import fixed_point, poincare_map, require_landing, start_state
from stages.analytic.integration.phase import walk_step
from stages.analytic.result import BACK, FORWARD, NO_START, REACHES, WALKS_ON
from stages.stability.parameters import Settings
from stages.stability.run import SLOPE, over_slope, section_of, starts_around
from tests.analytic.designs import SLOPE as TWO_DEGREES
from tests.analytic.designs import TABLE_1

SETTINGS = Settings(0.4, 2.8, 2, 0.1, 1e-9, 0.5, 2.0, 0.3, 2.3, 12, 30)
TOLERANCE = 1e-10


@pytest.fixture(scope="module")
def gait():
    return find_gait(TABLE_1, TWO_DEGREES, TOLERANCE)


@pytest.fixture(scope="module")
def families(gait):
    return over_slope(DesignPoint(TABLE_1, TWO_DEGREES), gait[1].z, SETTINGS)


@pytest.fixture(scope="module")
def basin(gait):
    return starts_around(*_of(gait), SETTINGS)


def _of(gait):
    walker, point = gait
    return walker, point.z


def walker_on(slope):
    return DesignPoint(TABLE_1, TWO_DEGREES).with_value(SLOPE, slope).walker()


def test_a_gait_in_si_units_leads_back_to_its_section(gait):
    walker, point = gait
    assert section_of(walker, walker.stance_state(start_state(walker, point.z))) == pytest.approx(point.z, abs=1e-14)


def test_a_doubling_is_where_newtons_gaits_have_a_multiplier_of_minus_one(families, gait):
    """Brent's method on the least multiplier of gaits found by Newton's at single slopes, without continuation."""
    turn = next(turn for turn in families[0].turns if turn.value > 2)
    z = np.array(fixed_point(walker_on(4.0), _nearest_start(gait, 4.0), TOLERANCE).z)

    def least(slope):
        return min(fixed_point(walker_on(slope), z, TOLERANCE).floquet_multipliers.real)

    doubles = brentq(lambda slope: least(slope) + 1, 4.1, 4.25, xtol=1e-8)
    assert turn.value == pytest.approx(doubles, abs=1e-6)
    assert turn.multiplier == pytest.approx(-1, abs=1e-8)


def _nearest_start(gait, slope):
    z = gait[1].z
    for value in np.linspace(2.0, slope, 9):
        z = fixed_point(walker_on(value), z, TOLERANCE).z
    return z


@pytest.mark.parametrize(("slope", "cycle"), [(3.0, 1), (4.8, 2), (5.45, 4)])
def test_where_a_family_is_stable_walks_settle_on_its_steps(families, gait, slope, cycle):
    """Many steps from somewhere near: the durations that come back are those of the family, each once."""
    family = next(one for one in families if one.cycle == cycle and one.value.max() > slope > one.value.min())
    order = np.argsort(family.value)
    assert family.stable[order][np.searchsorted(family.value[order], slope)]
    wanted = np.sort([np.interp(slope, family.value[order], column[order]) for column in family.step_duration.T])
    walker, z, durations = walker_on(slope), _nearest_start(gait, slope) + 1e-3, []
    for _ in range(200):
        step = poincare_map(walker, z, 1e-8)
        z = step.z
        durations.append(step.period * walker.time)
    assert np.sort(durations[-cycle:]) == pytest.approx(wanted, abs=3e-4)  # between two gaits of the family
    assert durations[-1] == pytest.approx(durations[-1 - cycle], abs=1e-7)
    assert cycle == 1 or abs(durations[-1] - durations[-1 - cycle // 2]) > 1e-3


def test_each_doubling_gives_a_family_that_is_stable_at_first(families):
    assert [family.cycle for family in families] == [1, 2, 2, 4]
    for family in families:
        assert family.step_duration.shape == (len(family.value), family.cycle)
        assert {turn.kind for turn in family.turns} <= {PERIOD_DOUBLING}
    for turn in families[0].turns:
        born = min(families[1:3], key=lambda family: abs(family.value[0] - turn.value))
        assert born.value[0] == pytest.approx(turn.value, abs=2e-3) and born.stable[1]
        assert born.step_duration[0] == pytest.approx(turn.step_duration[0], abs=0.02)


def test_kinds_of_ending_are_those_of_single_steps(basin, gait):
    walker, point = gait
    assert {REACHES, FORWARD, BACK, NO_START} <= set(basin.ending.ravel())
    for number in (REACHES, FORWARD, BACK, NO_START):
        i, j = np.argwhere(basin.ending == number)[0]
        z = point.z.copy()
        z[0], z[3] = -basin.stance_angle[i], basin.stance_rate[j] * walker.time
        if number == NO_START:
            with pytest.raises(StepFailed, match="cannot reach the ground"):
                start_state(walker, z)
            continue
        for _ in range(basin.steps[i, j]):
            z = poincare_map(walker, z, 1e-6).z
        if number == REACHES:
            assert np.abs(z - point.z).max() < basin.near
            continue
        y = start_state(walker, z)
        status, phase, *_ = walk_step(y, walker.p, 1e-6, 30.0, 400_000)
        with pytest.raises(StepFailed):
            require_landing(walker, y, status, phase)
        assert (y[0] > 0) == (number == FORWARD) or y[2] >= 0


def test_a_few_steps_are_not_enough_to_reach_the_gait(basin, gait):
    few = starts_around(*_of(gait), dataclasses.replace(SETTINGS, most_steps=4))
    late = (basin.ending == REACHES) & (basin.steps > 4)
    assert late.any() and (few.ending[late] == WALKS_ON).all() and (few.steps[late] == 4).all()
    soon = (basin.ending != WALKS_ON) & (basin.steps < 4)
    assert (few.ending[soon] == basin.ending[soon]).all()
