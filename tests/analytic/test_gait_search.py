"""The search for gaits: all kinds found and labelled, refusals with a reason, nothing wrong at the extremes."""

import numpy as np
import pytest

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.gait_search import by_stability, describe, find_gait, find_gaits
from stages.analytic.gait.poincare import poincare_map
from stages.ground.slope import Slope
from tests.analytic.designs import SLOPE, TABLE_1, TABLE_1_RIGID, changed, walker_of


def closes(walker, point):
    """Whether the gait repeats when walked again, by the map alone and not at the search's tolerance."""
    return np.abs(poincare_map(walker, point.z, 1e-11).z - point.z).max()


def test_stable_long_step_and_unstable_short_step_are_both_found(table_1_gait, table_1_gaits):
    """Trap 2: the first root found is not "the" gait. The stable one takes longer steps and its label says so."""
    walker, stable = table_1_gait
    assert len(table_1_gaits) >= 2
    long_step, short_step = (describe(walker, point) for point in table_1_gaits[:2])
    assert long_step.stable and not short_step.stable
    assert long_step.step_length_m > short_step.step_length_m
    assert np.abs(table_1_gaits[0].z - stable.z).max() <= 1e-9
    for point in table_1_gaits:
        assert closes(walker, point) <= 1e-9
        assert describe(walker, point).stable == (by_stability(point) < 1)


def test_the_search_prefers_the_stable_gait_whatever_the_stiffness():
    for stiffness in (2800.0, 1e4, 1e5):
        found = find_gaits(walker_of(changed(TABLE_1, stiffness=stiffness)), 1e-10, unstable=True)
        assert [by_stability(point) < 1 for point in found[:2]] == [True, False]


def test_level_ground_is_refused_with_its_reason():
    for design in (TABLE_1, TABLE_1_RIGID):
        with pytest.raises(NoGait, match="level ground gravity does no work"):
            find_gait(design, Slope(slope_deg=0.0, gravity=9.81), 1e-10)


def test_soft_legs_are_refused_with_the_range_searched():
    with pytest.raises(NoGait, match=r"0\.05 to 0\.6 rad.*Newton's method converged from none"):
        find_gait(changed(TABLE_1, stiffness=100.0), SLOPE, 1e-10)


def test_simplest_walker_has_no_gait_on_a_steep_slope():
    """Garcia 1998: no gait of the simplest walker above a slope of about 0.019 that it can keep; it falls."""
    walker = walker_of(changed(
        TABLE_1_RIGID, hip_mass=1000.0, foot_mass=1.0, leg_length=1.0, foot_radius=0.0, foot_com=0.0), slope_deg=3.0)
    assert all(by_stability(point) > 1 for point in find_gaits(walker, 1e-10, unstable=True))


EXTREMES = [(1e2, 1e5), (1e6, 58.35), (1e8, 58.35)]


@pytest.mark.parametrize("stiffness, damping", EXTREMES)
def test_stiff_walkers_have_the_gait_of_stiff_legs(stiffness, damping):
    """Springs or dampers that hardly give: a gait near that of rigid legs, which closes when walked again."""
    walker = walker_of(changed(TABLE_1, stiffness=stiffness, damping=damping))
    found = find_gaits(walker, 1e-10, unstable=False)
    assert found and by_stability(found[0]) < 1
    assert found[0].z[0] == pytest.approx(-0.2772, abs=6e-3)
    assert closes(walker, found[0]) <= 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("slope_deg", [0.0, 0.1, 2.0, 5.0, 10.0])
@pytest.mark.parametrize("stiffness", [1e2, 1e4, 1e6, 1e8, 1e10])
@pytest.mark.parametrize("damping", [0.0, 58.35, 1e5])
def test_every_corner_has_an_answer(slope_deg, stiffness, damping):
    """A gait that closes when it is walked ten times finer than it was found, or a refusal that says why."""
    design = changed(TABLE_1, stiffness=stiffness, damping=damping)
    try:
        walker, point = find_gait(design, Slope(slope_deg=slope_deg, gravity=9.81), 1e-10)
    except NoGait as refusal:
        assert "no periodic gait" in str(refusal)
        return
    assert slope_deg > 0
    noise = 1e3 * np.finfo(float).eps * walker.p.k
    assert np.abs(poincare_map(walker, point.z, 1e-11).z - point.z).max() <= max(1e-7, noise)
    assert abs(report_gait(walker, point, 1e-10).energy.residual) <= max(1e-7, noise)


def test_a_walker_that_rocks_back_has_no_gait():
    """It lands with the hip behind both feet, where the section's coordinates are those of another state: a fixed
    point of them would be no gait, and its energy audit would not close."""
    walker = walker_of(changed(TABLE_1, stiffness=1e4, damping=0.0), slope_deg=1.0)
    rocking = np.array([-0.02412, 0.99866, 0.99858, 0.00764, -0.2301])
    with pytest.raises(StepFailed, match="hip is behind both feet"):
        poincare_map(walker, rocking, 1e-10)
