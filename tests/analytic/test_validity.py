"""The report on what a gait asks of the ground."""

import dataclasses

import numpy as np
import pytest

from stages.analytic.phases.motion import DOUBLE_STANCE, RIGID, SINGLE_STANCE
from stages.analytic.phases.section import section_state
from stages.analytic.run import without_impact
from stages.analytic.walk.on_a_ramp import on_a_ramp
from stages.analytic.walk.recording import record, states_at
from stages.analytic.walk.sampling import accelerations_and_forces
from stages.analytic.walk.validity import assess, friction_used


@pytest.fixture(scope="module")
def report(table_1_gait, table_1_step):
    return assess(table_1_gait[0], table_1_step, 1.1)


def test_trailing_foot_would_slip_at_heel_strike(report):
    """Trap 4: the trailing foot's impulse is mostly tangential, far outside the cone of the paper's mu = 1.1."""
    assert report.impulse_friction_trailing > 10
    said = on_a_ramp(report, stable=True).sentence
    assert "the trailing foot may slip" in said and "landing foot needs" not in said


def test_more_friction_than_any_needed_breaks_no_friction_assumption(table_1_gait, table_1_step):
    """But in the last instants before toe-off, where no friction would do."""
    plenty = assess(table_1_gait[0], table_1_step, 1e3)
    assert "needs friction" not in on_a_ramp(dataclasses.replace(plenty, time_outside_cone=0.0), stable=True).sentence
    assert plenty.time_outside_cone < 2e-3 and plenty.impulse_outside_cone < 2e-3


def test_the_trailing_foot_leaves_the_friction_cone_in_double_stance(report, table_1_gait, table_1_step):
    """By shares that do not depend on where samples lie; by the ratio itself they would, it has no bound."""
    walker, _ = table_1_gait
    double = table_1_step[0]
    times = np.linspace(0.0, double.duration, 40001)
    states = states_at(double.phase, double.times, double.states, times, walker.p)
    tangential, normal = np.abs(accelerations_and_forces(double.phase, states, walker.p)[:, 6:8]).T
    outside = tangential > 1.1 * normal
    assert report.time_outside_cone == pytest.approx(outside.mean(), abs=1e-3)
    assert report.impulse_outside_cone == pytest.approx(tangential[outside].sum() / tangential.sum(), abs=1e-3)
    assert 0.0 < report.time_outside_cone < 1.0
    ratio = tangential[:-1] / normal[:-1]
    assert ratio[-1] > 100 * report.friction_double_stance_loaded


def test_the_friction_of_a_loaded_foot_is_the_same_at_every_tolerance(table_1_gait):
    walker, point = table_1_gait
    found = [assess(walker, record(walker, section_state(point.z, walker.p), 1, tolerance, DOUBLE_STANCE), 1.1)
             for tolerance in (1e-6, 1e-8, 1e-12)]  # fmt: skip
    for one in found[:-1]:
        assert one.friction_double_stance_loaded == pytest.approx(found[-1].friction_double_stance_loaded, rel=1e-2)
        assert one.time_outside_cone == pytest.approx(found[-1].time_outside_cone, abs=1e-3)


def test_without_an_impact_the_landing_foot_moves_on_as_it_came(table_1_gait, table_1_step):
    """s'' = 0 keeps s': slip .139 m/s and descent .264 m/s, and the ground is left behind by descent times duration."""
    found = without_impact(table_1_gait[0], table_1_step)
    assert abs(found.slip_at_landing) == pytest.approx(0.139, abs=5e-4)
    assert found.descent_at_landing == pytest.approx(0.264, abs=5e-4)
    assert found.slip_at_end == pytest.approx(found.slip_at_landing, rel=1e-9)
    assert found.descent_at_end == pytest.approx(found.descent_at_landing, rel=1e-9)
    assert found.depth_at_end == pytest.approx(found.descent_at_landing * found.duration, rel=1e-6)
    assert found.duration == pytest.approx(table_1_step[0].duration * table_1_gait[0].time)


def test_rigid_legs_have_no_double_stance_to_integrate(rigid_gait):
    walker, point = rigid_gait
    found = without_impact(walker, record(walker, section_state(point.z, walker.p), 1, 1e-10, RIGID))
    assert found.duration == found.slip_at_end == 0.0


def test_scuffing_is_reported(report):
    """The legs are equally long: the swing foot passes millimetres below ground near the upright stance leg."""
    assert 1e-3 < report.deepest_scuff < 2e-2
    assert abs(report.deepest_scuff_angle) < 0.1
    assert "stepping blocks" in on_a_ramp(report, stable=True).sentence


def test_ground_only_pushes_in_the_gait_of_table_1(report):
    assert report.feet_push_only
    assert report.least_normal_force_stance > 0


def test_pull_on_a_foot_is_infinite_friction():
    assert friction_used(np.array([[0.1, 1.0], [0.2, -0.1]])) == float("inf")
    assert friction_used(np.array([[0.3, 1.0], [-0.5, 1.0]])) == pytest.approx(0.5)
    assert friction_used(np.zeros((3, 2))) == 0.0


def test_pulling_ground_is_reported(table_1_gait):
    """A walker that vaults too fast would leave the ground; the constraint holds it down and the report says so."""
    walker, _ = table_1_gait
    fast = np.array([-0.25, 1.0, 0.99, 1.25, -0.3])
    segments = record(walker, section_state(fast, walker.p), 1, 1e-10, DOUBLE_STANCE)
    report = assess(walker, segments, 1.1)
    assert report.least_normal_force_stance < 0 and not report.feet_push_only
    assert "pull the stance foot" in on_a_ramp(report, stable=True).sentence


def test_forces_of_both_feet_carry_the_weight_on_average(table_1_gait, table_1_step):
    """Over a periodic step the ground's impulse is weight times period, along both axes, impacts included."""
    from stages.analytic.walk.recording import states_at
    from stages.analytic.walk.validity import impulses

    walker, point = table_1_gait
    points, weights = np.polynomial.legendre.leggauss(8)
    total = sum(impulses(walker, table_1_step[-1].end))
    for segment in table_1_step:
        edges = np.append(segment.times, segment.duration)
        middle, half = (edges[1:] + edges[:-1]) / 2, (edges[1:] - edges[:-1]) / 2
        times = (middle[:, None] + half[:, None] * points).ravel()
        states = states_at(segment.phase, segment.times, segment.states, times, walker.p)
        forces = accelerations_and_forces(segment.phase, states, walker.p)[:, 4:].reshape(-1, 2, 2).sum(axis=1)
        total = total + (forces * (half[:, None] * weights).ravel()[:, None]).sum(axis=0)
    weight = -np.array([walker.p.g_x, walker.p.g_y])
    assert np.abs(total - weight * point.steps[0].period).max() <= 1e-9


def test_single_stance_foot_carries_everything(table_1_gait, table_1_step):
    rows = accelerations_and_forces(SINGLE_STANCE, table_1_step[-1].states, table_1_gait[0].p)
    assert (rows[:, 6:8] == 0).all()


def test_rigid_report_has_no_double_stance(rigid_gait):
    walker, point = rigid_gait
    report = assess(walker, record(walker, section_state(point.z, walker.p), 1, 1e-12, RIGID), 1.1)
    assert report.friction_double_stance_loaded == 0 and report.impulse_friction_trailing == 0
