"""The energy audit of a periodic step."""

import pytest

from stages.analytic.gait.gait_report import audit
from stages.analytic.gait.gait_search import step_length
from stages.analytic.phases.motion import DOUBLE_STANCE, RIGID
from stages.analytic.phases.section import section_state
from stages.analytic.walk.recording import record
from tests.analytic.designs import HEAVY_LEGS, TABLE_1, TABLE_1_RIGID, changed, found_gait

DESIGNS = {
    "Table 1": TABLE_1,
    "leg inertia": HEAVY_LEGS,
    "rigid": TABLE_1_RIGID,
    "rigid, point feet": changed(TABLE_1_RIGID, foot_radius=0.0),
}


@pytest.mark.parametrize("name", DESIGNS)
def test_gravity_pays_for_dampers_and_impact(name):
    """Closes to 1e-9 of gravity's work; every term is counted where it arises, none as the rest of the others."""
    walker, point = found_gait(DESIGNS[name])
    start = section_state(point.z, walker.p)
    segments = record(walker, start, 1, 1e-12, RIGID if walker.rigid else DOUBLE_STANCE)
    report = audit(walker, segments, step_length(walker, point))
    assert abs(report.residual) <= 1e-9
    assert report.impact_loss > 0 and report.gravity_work > 0
    assert report.damper_loss == 0 if walker.rigid else report.damper_loss > 0


def test_audit_notices_a_walk_that_is_not_periodic(table_1_gait):
    """Off the gait the state's energy changes over a step, and the audit does not close."""
    walker, point = table_1_gait
    segments = record(walker, section_state(point.z * [1, 1, 1, 1.02, 1], walker.p), 1, 1e-12, DOUBLE_STANCE)
    assert abs(audit(walker, segments, step_length(walker, point)).residual) > 1e-3
