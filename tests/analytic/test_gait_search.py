"""The search for gaits, refusals with a reason, nothing wrong at the extremes, and families of gaits."""

import dataclasses
import math

import numpy as np
import pytest

from benchmarks.missed_gaits import drawn
from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.basin import NONE, basin_of_attraction
from stages.analytic.gait.continuation import (
    PERIOD_DOUBLING,
    TORUS,
    TURNING_POINT,
    BranchPoint,
    Curve,
    continue_gait,
    follow_family,
    test_functions as signs_at,
)
from stages.analytic.gait.design_point import DesignPoint, parameter_names
from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.gait_search import by_stability, describe, find_gait, find_gaits, from_neighbours, gaits_kept
from stages.analytic.gait.poincare import FixedPoint, find_cycle, fixed_point, poincare_map
from stages.analytic.result import BACK, REACHES, STILL
from stages.biped.design import Biped
from stages.ground.slope import Slope
from tests.analytic.designs import FRICTION, SLOPE, TABLE_1, TABLE_1_RIGID, changed, found_gait, walker_of


def closes(walker, point):
    """Whether the gait repeats when walked again, by the map alone and not at the search's tolerance."""
    return np.abs(poincare_map(walker, point.z, 1e-11).z - point.z).max()


@pytest.mark.parametrize("design", [
    TABLE_1, TABLE_1_RIGID, pytest.param(changed(TABLE_1, stiffness=1e4), marks=pytest.mark.slow),
    changed(TABLE_1, stiffness=1e5)], ids=["Table 1", "rigid", "1e4 N/m", "1e5 N/m"])  # fmt: skip
def test_stable_long_step_and_unstable_short_step_are_both_found(design):
    """Trap 2: the first root found is not "the" gait. The stable one takes longer steps and its label says so."""
    walker = walker_of(design)
    points = find_gaits(walker, 1e-10, unstable=True)
    stable, *unstable = (describe(walker, point) for point in points)
    assert stable.stable and unstable and not any(gait.stable for gait in unstable)
    assert unstable[0].step_length_m < stable.step_length_m
    for point in points:
        assert closes(walker, point) <= 1e-9
        assert describe(walker, point).stable == (by_stability(point) < 1)


def test_what_is_found_once_is_kept_and_each_caller_has_arrays_of_its_own(rigid_gait):
    walker, point = rigid_gait
    first, before = find_gaits(walker, 1e-10, unstable=False), gaits_kept.cache_info().misses
    z = first[0].z.copy()
    assert z == pytest.approx(point.z, abs=1e-9)
    first.pop(0).z[:] = 0.0
    again = find_gaits(walker, 1e-10, unstable=False)
    assert gaits_kept.cache_info().misses == before and np.array_equal(again[0].z, z)


def test_walkers_of_two_kinds_with_the_same_numbers_are_not_mistaken_for_each_other(rigid_gait):
    """What is kept of one, starts and gaits, is not given for the other."""
    rubbing, timed = (dataclasses.replace(rigid_gait[0], p=rigid_gait[0].p._replace(**{name: 0.5}))
                      for name in ("tau_h", "T"))
    assert rubbing != timed and rubbing != rigid_gait[0]
    assert rubbing == dataclasses.replace(timed, p=rubbing.p)


@pytest.mark.parametrize(("design", "slope_deg", "reason"), [
    pytest.param(TABLE_1, 0.0, "level ground gravity does no work", id="level"),
    pytest.param(TABLE_1_RIGID, 0.0, "level ground gravity does no work", id="level, rigid legs"),
    pytest.param(changed(TABLE_1, stiffness=100.0), 2.0,
                 r"0\.05 to 0\.6 rad.*Newton's method converged from none", id="soft legs")])
def test_where_no_gait_is_found_the_reason_is_said(design, slope_deg, reason):
    with pytest.raises(NoGait, match=reason):
        find_gait(design, Slope(slope_deg=slope_deg, gravity=9.81), 1e-10)


def test_simplest_walker_has_no_gait_on_a_steep_slope():
    """Garcia 1998: no gait of the simplest walker above a slope of about 0.019 that it can keep; it falls."""
    walker = walker_of(changed(
        TABLE_1_RIGID, hip_mass=1000.0, foot_mass=1.0, leg_length=1.0, foot_radius=0.0, foot_com=0.0), slope_deg=3.0)
    assert all(by_stability(point) > 1 for point in find_gaits(walker, 1e-10, unstable=True))


EXTREMES = [(1e2, 1e5), (1e6, 58.35), pytest.param(1e8, 58.35, marks=pytest.mark.slow)]


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
    assert abs(report_gait(walker, point, 1e-10, FRICTION.static_friction).energy.residual) <= max(1e-7, noise)


def test_a_walker_that_rocks_back_has_no_gait():
    """It lands with the hip behind both feet, where the section's coordinates are those of another state: a fixed
    point of them would be no gait, and its energy audit would not close."""
    walker = walker_of(changed(TABLE_1, stiffness=1e4, damping=0.0), slope_deg=1.0)
    rocking = np.array([-0.02412, 0.99866, 0.99858, 0.00764, -0.2301])
    with pytest.raises(StepFailed, match="hip is behind both feet"):
        poincare_map(walker, rocking, 1e-10)


def test_a_light_foot_is_no_stiff_leg():
    """Rates are fast where the foot is light; 0.1.0 took such legs for stiff and refused this design, which walks."""
    design = changed(TABLE_1, hip_mass=0.98255662144, foot_mass=0.0017216892784, damping=15.69421022747663)
    walker, point = find_gait(design, Slope(slope_deg=0.35019307606455136, gravity=9.81), 1e-10)
    assert by_stability(point) < 1 and closes(walker, point) <= 1e-9


@pytest.mark.parametrize("index", [
    238, 260, 313, *(pytest.param(index, marks=pytest.mark.slow) for index in (446, 460))])
def test_gaits_that_were_missed_before(index):
    """Designs of benchmarks/missed_gaits.py with a stable gait that the search once did not find."""
    _, point = find_gait(*drawn(1, index), 1e-10)
    assert by_stability(point) < 1


@pytest.mark.parametrize("damping, slope_deg, fold", [
    (190.0, 2.0, "2.00284"), pytest.param(300.0, 2.0, "2.10382", marks=pytest.mark.slow)])
def test_a_refusal_says_where_the_family_turns_back(damping, slope_deg, fold):
    """The gait of steeper slopes ends at a fold before the design's slope; at its other side a gait is found."""
    design = changed(TABLE_1, damping=damping)
    with pytest.raises(NoGait, match=rf"ground\.slope_deg = .* turns back at {fold} deg, a fold"):
        find_gait(design, Slope(slope_deg=slope_deg, gravity=9.81), 1e-10)
    find_gait(design, Slope(slope_deg=float(fold) + 0.01, gravity=9.81), 1e-10)


def test_a_neighbour_leads_to_the_design(table_1_gait):
    """With its own search switched off, a design's gait still comes from other slopes."""
    point = from_neighbours(DesignPoint(TABLE_1, SLOPE), 1e-10)
    assert isinstance(point, FixedPoint)
    assert point.z == pytest.approx(table_1_gait[1].z, abs=1e-9)


def test_a_family_ends_on_its_limit_to_the_last_bit():
    """Else a search takes the gait for one beside the design's; limit over span times span is another number here."""
    start, limit = DesignPoint(TABLE_1_RIGID, Slope(4 * 0.8522346640120361, 9.81)), 0.8522346640120361
    point = find_gait(start.biped, start.slope, 1e-8)[1]
    family = continue_gait(start, "ground.slope_deg", (limit, start.slope.slope_deg), point.z, 1e-8, upward=False,
                           largest_step=0.15)  # fmt: skip
    assert family.ended == "the limit of the parameter" and family.points[-1].value == limit


@pytest.fixture(scope="module")
def gait():
    return found_gait(TABLE_1)


def small_map(gait, workers):
    walker, point = gait
    angles, rates = np.linspace(0.1, 0.45, 12), np.linspace(0.1, 0.9, 12) / walker.time
    return basin_of_attraction(walker, point.z, angles, rates, steps=30, workers=workers)


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
    mapped = basin_of_attraction(walker, point.z, np.array([-point.z[0]]), rates, steps=30)
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


# --- Families of gaits: the simplest walker's published period doubling, and consistency along a branch.


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


def test_a_cycle_told_beside_an_unstable_gait_is_the_stable_one(cascade):
    """Just beyond its doubling the cycle of two steps is unstable, near that of four on which a walk settles."""
    slopes = doublings(cascade)
    slope = math.degrees(slopes[2] + 0.1 * (slopes[4] - slopes[2]))
    near = min(cascade[0].points, key=lambda point: (abs(point.value - slope), abs(point.z[0])))
    walker = simplest_walker().with_value("ground.slope_deg", slope).walker()
    gait = fixed_point(walker, near.z, TOLERANCE)
    assert by_stability(gait) > 1.0
    cycle = find_cycle(walker, gait.z, TOLERANCE)
    assert len(cycle.steps) == 4 and by_stability(cycle) < 1.0


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


def test_a_family_whose_multipliers_go_to_infinity_ends_where_points_lead_nowhere():
    """It took 392 points, 240 of them within .002 of each other and with multipliers above 290."""
    _, point = found_gait(TABLE_1)
    branch = continue_gait(DesignPoint(TABLE_1, SLOPE), "biped.foot_com", (0.01, 0.4), point.z, 1e-8)
    assert len(branch.points) < 200, branch.ended
    assert branch.points[-1].value == pytest.approx(0.0418, abs=1e-4)
    assert [kind for kind, _ in branch.special] == [TURNING_POINT]


def test_a_prediction_below_no_gravity_is_a_step_that_fails():
    """So that the next one is shorter."""
    _, point = found_gait(TABLE_1)
    curve = Curve(DesignPoint(TABLE_1, SLOPE), "ground.gravity", 1.0, 1, 1e-8)
    beyond, along = np.append(point.z, -0.1), np.append(0.0 * point.z, 1.0)
    with pytest.raises(StepFailed, match=r"ground\.gravity = -0\.1 is no biped's"):
        curve.image(beyond)
    with pytest.raises(StepFailed, match="no biped's"):
        curve.correct(beyond, along)


@pytest.mark.parametrize(("name", "limits", "upward", "reason"), [
    ("ground.slope_deg", (0.1, 3.0), False, "the walker rocks back: at heel strike the hip is behind both feet"),
    ("biped.foot_radius", (0.05, 0.3), True, "the walker falls in single stance")])
def test_a_family_that_ends_says_what_no_step_comes_after(name: str, limits: tuple[float, float], upward: bool,
                                                          reason: str) -> None:
    """Where the hip lands above the foot behind no step of the gait has the hip between its feet."""
    _, point = found_gait(TABLE_1)
    branch = continue_gait(DesignPoint(TABLE_1, SLOPE), name, limits, point.z, 1e-8, upward=upward)
    assert branch.ended == reason


def test_names_reach_every_number_of_the_design():
    design = simplest_walker()
    for name in parameter_names():
        assert design.with_value(name, 0.123).value(name) == 0.123
    with pytest.raises(KeyError, match=r"biped\.hip_mass"):
        design.value("biped.hip_mas")


@pytest.mark.parametrize("multipliers, doubling, torus", [
    ([1.2, -0.5, 0.1], 1.0, np.nan), ([-1.1, 0.5, 0.1], -1.0, np.nan),
    ([0.6 + 0.9j, 0.6 - 0.9j, 0.1], 1.0, 1.0), ([0.6 + 0.7j, 0.6 - 0.7j, 1.3], 1.0, -1.0)])
def test_a_torus_bifurcation_is_of_complex_multipliers_alone(multipliers, doubling, torus):
    found = signs_at(BranchPoint(1.0, np.zeros(3), np.array(multipliers), 1.0, np.array([0.0, 0.0, 0.0, 1.0])))
    assert np.sign(found[PERIOD_DOUBLING]) == doubling
    np.testing.assert_equal(np.sign(found[TORUS]), torus)
