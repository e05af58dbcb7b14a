"""Feet that retract, and are put down at a given time of the step: map, derivatives, gaits, energy, refusals."""

import dataclasses
import math

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives, step_tangents
from stages.analytic.errors import StepFailed
from stages.analytic.gait.basin import basin_of_attraction
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.gait_search import find_gait, step_length
from stages.analytic.gait.poincare import poincare_derivative, poincare_map
from stages.analytic.model.kinds import DetailedRigid, with_legs_exchanged
from stages.analytic.model.terms import exchanged
from stages.analytic.model.walker import build_walker
from stages.analytic.phases.section import section_state
from stages.analytic.result import FORWARD, NO_START, REACHES
from stages.analytic.walk.error_estimate import estimate_errors
from stages.analytic.walk.recording import crossing, record, walk_on
from stages.analytic.walk.sampling import sample_walk
from stages.biped.quantity import faults
from stages.ground.slope import Slope
from tests.analytic.designs import SLOPE, TABLE_1, TABLE_1_RIGID, changed, found_gait
from tests.analytic.differences import gait_slope, map_slope, shares, step_slope
from tests.analytic.test_detailed import LAME_RIGID

FREE = changed(TABLE_1_RIGID, frame_mass=0.01, frame_com=0.02)
SIZES = (4e-6,) * 4
TOLERANCE = 1e-12


@pytest.fixture(scope="module")
def free():
    return found_gait(FREE)


def timed(time, **values):
    return changed(FREE, feet_retract=True, strike_time=time, **values)


@pytest.fixture(scope="module")
def later(free):
    """A gait whose feet are put down two per cent later than they would land."""
    walker, point = free
    design = DesignPoint(timed(1.02 * point.period * walker.time), SLOPE)
    return design, *find_gait(design.biped, SLOPE, TOLERANCE)


def test_put_down_when_they_would_land_the_gait_is_that_of_feet_that_land(free):
    walker, point = free
    own, found = find_gait(timed(point.period * walker.time), SLOPE, TOLERANCE)
    assert isinstance(own.p, DetailedRigid) and own.timed and own.section_size == 4 == len(found.z)
    assert found.z == pytest.approx(section_state(point.z, walker.p), abs=1e-10)
    report = report_gait(own, found, TOLERANCE, 1.1)
    assert np.abs(report.put_down.rise_m).max() < 1e-11
    assert report.put_down.slope_walked_deg == pytest.approx(SLOPE.slope_deg, abs=1e-8)
    assert report_gait(*free, TOLERANCE, 1.1).put_down is None


def test_the_map_and_its_derivatives_are_exact(later):
    """By the state, by every number of the walker, and by the time of the step, which is the period."""
    _, walker, point = later
    start = point.z + np.array([1e-3, -2e-3, 3e-3, 1e-3])
    _, derivative = poincare_derivative(walker, start, 1e-13)
    assert np.abs(derivative - map_slope(walker, start, SIZES)).max() < 1e-7
    names = ("T", "l", "m_2", "l_f_2", "r_2", "g_x", "k_h", "L_nat_2")
    along = shares(walker, names)
    exact = step_tangents(walker, start, along, 1e-13)
    assert exact.time_along[0] == pytest.approx(walker.p.T, rel=1e-15)
    assert np.abs(exact.time_along[1:]).max() == 0.0 == np.abs(exact.time_by_start).max()
    for row, name in enumerate(names):
        wanted = step_slope(walker, start, along[row], 4e-5)[:-1]
        assert exact.along[:, row] == pytest.approx(wanted, rel=0, abs=1e-8 * max(1.0, np.abs(wanted).max())), name


def test_a_gait_s_derivatives_are_those_of_differences(later):
    design, _, point = later
    names = ("biped.strike_time", "biped.foot_com", "ground.slope_deg")
    gait = gait_derivatives(design, point, names, 1e-13)
    for name, length in zip(names, gait.step_length * gait.walker.length, strict=True):
        assert length == pytest.approx(gait_slope(design, point.z, {name: 1.0})[1], rel=1e-6)


def test_energy_is_kept_over_the_ground_that_is_found(later):
    """Feet put down above or below the slope change what gravity does; the audit closes, the path's slope says so."""
    _, walker, point = later
    report = report_gait(walker, point, TOLERANCE, 1.1)
    down = report.put_down
    assert abs(down.rise_m[0]) > 1e-4 and abs(report.energy.residual) < 1e-9
    advance = step_length(walker, point) * walker.length
    assert down.slope_walked_deg == pytest.approx(SLOPE.slope_deg - np.degrees(np.arctan2(down.rise_m[0], advance)))
    assert report.energy.gravity_work == pytest.approx(
        FREE.total_mass * SLOPE.gravity * np.hypot(advance, down.rise_m[0]) * np.sin(np.radians(down.slope_walked_deg)),
        rel=1e-9)
    assert report.validity.deepest_scuff == 0.0


def test_a_walk_from_mid_stance_keeps_the_clock_and_climbs(later):
    _, walker, point = later
    upright, elapsed = crossing(walker, point.z, TOLERANCE)
    walk = sample_walk(walker, walk_on(walker, upright, 3, TOLERANCE, elapsed), 5000.0)
    assert np.diff(walk.heel_strike_time) == pytest.approx(walker.p.T * walker.time, abs=1e-12)
    assert walk.heel_strike_time[0] == pytest.approx((walker.p.T - elapsed) * walker.time, abs=1e-12)
    assert np.abs(np.diff(walk.hip_position[:, 1])).max() < 2e-3  # no jump where feet change
    rise = report_gait(walker, point, TOLERANCE, 1.1).put_down.rise_m[0]
    amid = walk.heel_strike_time[1:] - 0.3 * walker.p.T * walker.time
    assert np.diff(np.interp(amid, walk.time, walk.hip_position[:, 1])) == pytest.approx(rise, abs=1e-6)


def test_legs_that_differ_are_put_down_each_in_its_time():
    walker, point = found_gait(LAME_RIGID)
    biped = changed(LAME_RIGID, feet_retract=True, strike_time=point.period * walker.time)
    own, found = find_gait(biped, SLOPE, TOLERANCE)
    assert exchanged(own.p) == with_legs_exchanged(own.p) != own.p
    periods = [step.period for step in found.steps]
    assert periods == pytest.approx([own.p.T] * 2, rel=1e-15)
    report = report_gait(own, found, TOLERANCE, 1.1)
    assert report.limp.limp == pytest.approx(0.0, abs=1e-12) and np.ptp(report.put_down.rise_m) > 1e-6
    assert abs(report.energy.residual) < 1e-9


def test_a_walk_whose_foot_is_put_down_behind_the_other_does_not_reach_the_gait():
    """Its hip is ahead of both feet. Such starts were said to reach the gait all the same."""
    biped = changed(TABLE_1_RIGID, foot_mass=0.372, foot_radius=0.22, leg_inertia=0.0024, frame_mass=0.163,
                    frame_com=0.1, hip_stiffness=0.1, feet_retract=True, strike_time=0.274)  # fmt: skip
    walker, point = find_gait(biped, Slope(1.68, 9.81), TOLERANCE)
    found = basin_of_attraction(walker, point.z, np.linspace(0.4, 0.6, 8), np.linspace(2.0, 4.0, 8), steps=60)
    behind = []
    for place in np.argwhere(found.ending != NO_START):
        z = point.z.copy()
        z[0], z[walker.rate_entry] = -found.stance_angle[place[0]], found.stance_rate[place[1]] * walker.time
        try:
            for _ in range(found.steps[tuple(place)] + (found.ending[tuple(place)] == FORWARD)):
                z = poincare_map(walker, z, 1e-6).z
        except StepFailed as why:
            behind.append("behind the stance foot" in str(why))
            assert found.ending[tuple(place)] == FORWARD
        assert (np.abs(z - point.z).max() < found.near) == (found.ending[tuple(place)] == REACHES)
    assert sum(behind) > 3 and (found.ending == REACHES).any()


def test_feet_that_retract_and_land_themselves_scuff_nothing(free):
    walker, point = found_gait(changed(FREE, feet_retract=True))
    assert np.array_equal(point.z, free[1].z) and walker.retracts
    retracting = report_gait(walker, point, TOLERANCE, 1.1).validity
    assert retracting.deepest_scuff == 0.0 and math.isnan(retracting.deepest_scuff_angle)
    assert report_gait(*free, TOLERANCE, 1.1).validity.deepest_scuff > 1e-5


def test_a_time_without_a_step_is_refused(free):
    walker, point = free
    early = build_walker(timed(0.2 * point.period * walker.time), SLOPE)
    with pytest.raises(StepFailed, match=r"swing foot is behind|rocks back"):
        poincare_map(early, section_state(point.z, walker.p), TOLERANCE)
    own, found = find_gait(timed(point.period * walker.time), SLOPE, TOLERANCE)
    assert "no strike at a given time" in estimate_errors(own, found, 2, TOLERANCE).checked
    assert len(record(own, section_state(found.z, own.p), 2, TOLERANCE)) == 2


@pytest.mark.parametrize(("values", "words"), [
    ({"feet_retract": False}, "feet_retract: true"), ({"legs": "compliant"}, "rigid legs can"),
    ({"hip_friction": 1e-3}, "not known together")])
def test_what_a_timed_strike_goes_with_is_said(values, words):
    biped = dataclasses.replace(timed(0.5), **values)
    assert any(broken.key == "strike_time" and words in broken.allowed for broken in faults(biped))
    assert not list(faults(timed(0.5))) and not TABLE_1.detailed
