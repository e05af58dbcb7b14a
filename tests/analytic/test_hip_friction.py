"""Gaits of rigid legs with Coulomb friction at the hip: its events, its energy, its multipliers."""

from __future__ import annotations

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives, step_tangents
from stages.analytic.derivatives.numbers import left_by_dimensions, sensitive_names
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.poincare import fixed_point, poincare_derivative
from stages.analytic.integration.phase import EVENT, NO_NODES, integrate
from stages.analytic.model.kinds import DetailedRigid, with_legs_exchanged
from stages.analytic.model.terms import exchanged
from stages.analytic.model.walker import build_walker
from stages.analytic.phases.motion import HIP_STICKS, RUBS_BACK, RUBS_FORWARD, holding_torque
from stages.analytic.phases.section import section_state
from stages.analytic.phases.succession import first_phase, succeed
from stages.analytic.walk.recording import crossing_state, record, walk_on
from stages.analytic.walk.sampling import sample_walk
from tests.analytic.designs import SLOPE, TABLE_1_RIGID, changed, found_gait
from tests.analytic.differences import gait_slope, map_slope, shares, step_slope

FREE = changed(TABLE_1_RIGID, frame_mass=0.01, frame_com=0.02)
SIZES = (4e-6, 4e-6, 4e-6)  # of differences


@pytest.fixture(scope="module")
def free():
    return found_gait(FREE)


def rubbing(friction, **values):
    return build_walker(changed(FREE, hip_friction=friction, **values), SLOPE)


def test_without_friction_nothing_rubs(free):
    """The gait goes to that of a free hip in proportion to the friction."""
    _, point = free
    moved = [fixed_point(rubbing(friction), point.z, 1e-12).period - point.period for friction in (1e-5, 2e-5)]
    assert abs(moved[0]) > 1e-8 and moved[1] == pytest.approx(2 * moved[0], rel=2e-3)


@pytest.mark.parametrize("friction", [1e-4, 3e-3])
def test_multipliers_are_those_of_differences(free, friction):
    walker = rubbing(friction)
    assert isinstance(walker.p, DetailedRigid)
    point = fixed_point(walker, free[1].z, 1e-13)
    assert np.abs(point.monodromy_matrix - map_slope(walker, point.z, SIZES)).max() < 1e-7


@pytest.mark.parametrize(("friction", "z", "phases"), [
    (3e-3, (-0.28, 0.3, 0.0), (RUBS_FORWARD, RUBS_BACK)),
    (3e-3, (-0.28, 0.45, -0.5), (RUBS_BACK, RUBS_FORWARD)),
    (0.03, (-0.12, 0.3, -0.8), (RUBS_BACK, RUBS_FORWARD, RUBS_BACK, RUBS_FORWARD)),
    (0.075, (-0.25, 0.2, 0.3), (RUBS_FORWARD, RUBS_BACK, RUBS_FORWARD, HIP_STICKS)),
    (0.2, (-0.28, 0.3, 0.4), (RUBS_FORWARD, HIP_STICKS)),
])
def test_the_map_is_exact_through_turning_and_sticking(friction, z, phases):
    walker, start = rubbing(friction), np.array(z)
    segments = record(walker, section_state(start, walker.p), 1, 1e-12)
    assert tuple(segment.phase for segment in segments) == phases
    _, derivative = poincare_derivative(walker, start, 1e-13)
    assert np.abs(derivative - map_slope(walker, start, SIZES)).max() < 1e-6 * max(1.0, np.abs(derivative).max())
    if phases[-1] == HIP_STICKS:
        assert np.abs(segments[-1].states[:, 2] + segments[-1].states[:, 3]).max() < 1e-12
        assert np.linalg.svd(derivative)[1][-1] < 1e-9  # legs that land as one body forget how they came to


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_hip_that_sticks_lets_go_where_friction_is_used_up(side):
    """Either way, from legs that are together and swing as one."""
    walker, y = rubbing(0.05), side * np.array([-0.05, 0.05, 0.5, -0.5])
    assert first_phase(y, walker.p) == (HIP_STICKS, True)
    status, *_ = integrate(HIP_STICKS, y, walker.p, 1e-12, 30.0, 10_000, 0.02, NO_NODES)
    assert status == EVENT and abs(y[2] + y[3]) < 1e-12
    needed = holding_torque(HIP_STICKS, y, walker.p)
    assert abs(needed) == pytest.approx(walker.p.tau_h, rel=1e-9)
    assert succeed(HIP_STICKS, y, walker.p) == (RUBS_BACK if needed > 0 else RUBS_FORWARD, True)


def test_energy_audit_closes_with_friction(free):
    walker, smooth = rubbing(3e-3), free
    point = fixed_point(walker, smooth[1].z, 1e-12)
    report = report_gait(walker, point, 1e-12, 1.1)
    assert abs(report.energy.residual) < 1e-8 and report.energy.damper_loss > 1e-4
    plain = report_gait(*smooth, 1e-12, 1.1).validity
    assert report.validity.least_normal_force_stance == pytest.approx(plain.least_normal_force_stance, rel=0.05)


def test_a_walk_is_sampled_through_its_events(free):
    walker = rubbing(3e-3)
    point = fixed_point(walker, free[1].z, 1e-12)
    walk = sample_walk(walker, walk_on(walker, crossing_state(walker, point.z, 1e-12), 3, 1e-12), 500.0)
    periods = np.diff(walk.heel_strike_time)
    assert periods == pytest.approx(point.period * walker.time, abs=1e-9) and len(periods) == 3


def test_legs_that_differ_rub_as_well(free):
    walker = rubbing(1e-3, other_foot_mass=0.3345)
    assert exchanged(walker.p) == with_legs_exchanged(walker.p) != walker.p
    point = fixed_point(walker, free[1].z, 1e-12)
    assert point is not None and len(point.steps) == 2 and abs(point.steps[0].period - point.steps[1].period) > 1e-5


# --- derivatives by the numbers of the design -----------------------------------------------------------------------

#: One change of each of the numbers that the hip's events feel in ways of their own.
NUMBERS = ("tau_h", "k_h", "l", "m_2", "phi_h", "g_x", "b_h", "l_f_2")


@pytest.mark.parametrize(("friction", "z"), [
    (3e-3, (-0.28, 0.3, 0.0)), (3e-3, (-0.28, 0.45, -0.5)), (0.075, (-0.25, 0.2, 0.3)), (0.2, (-0.28, 0.3, 0.4)),
])
def test_a_step_s_derivatives_by_numbers_are_exact_through_turning_and_sticking(friction, z):
    """Against extrapolated differences: coordinates after the step, and its period."""
    walker, start = rubbing(friction, hip_stiffness=1e-3), np.array(z)
    along = shares(walker, NUMBERS)
    exact = step_tangents(walker, start, along, 1e-13)
    by_state = poincare_derivative(walker, start, 1e-13)[1]
    assert np.abs(exact.by_start - by_state).max() < 1e-9 * max(1.0, np.abs(by_state).max())
    for row, name in enumerate(NUMBERS):
        wanted = step_slope(walker, start, along[row], 1e-5)
        found = np.append(exact.along[:, row], exact.time_along[row])
        assert found == pytest.approx(wanted, rel=0, abs=1e-6 * max(1.0, np.abs(found).max())), name


@pytest.mark.parametrize("values", [{}, {"other_foot_mass": 0.3345}])
def test_a_gait_s_derivatives_are_those_of_differences(free, values):
    """Period and step length of the gait, by the friction and by what else there is; a stride where the legs differ."""
    design = DesignPoint(changed(FREE, hip_friction=1e-3, **values), SLOPE)
    point = fixed_point(design.walker(), free[1].z, 1e-13)
    names = ("biped.hip_friction", "biped.foot_mass", "biped.frame_com", "ground.slope_deg")
    gait = gait_derivatives(design, point, names, 1e-13)
    for row, name in enumerate(names):
        exact = np.array([gait.period[row] * gait.walker.time, gait.step_length[row] * gait.walker.length])
        assert exact == pytest.approx(gait_slope(design, point.z, {name: 1.0}), abs=1e-8, rel=2e-6), name


def test_dimensions_set_the_sums_of_elasticities_with_friction(free):
    design = DesignPoint(changed(FREE, hip_friction=1e-3), SLOPE)
    point = fixed_point(design.walker(), free[1].z, 1e-13)
    gait = gait_derivatives(design, point, sensitive_names(design), 1e-13)
    assert "biped.hip_friction" in gait.changes.names
    there = [row for row, value in enumerate(gait.changes.values) if value != 0.0]
    units = [gait.changes.units[row] for row in there]
    for measure, unit in (("period_s", "s"), ("step_length_m", "m")):
        assert np.abs(left_by_dimensions(gait.elasticities()[measure][there], units, unit)).max() < 1e-9
