"""Rigid legs at the edges of what is legal: no hip mass, point feet, mass at the foot's bottom, leg inertia."""

import numpy as np
import pytest

from stages.analytic.gait.gait_report import audit
from stages.analytic.gait.gait_search import find_gaits, step_length
from stages.analytic.gait.poincare import poincare_derivative, poincare_map
from stages.analytic.phases.motion import RIGID
from stages.analytic.phases.section import section_state
from stages.analytic.walk.recording import record
from tests.analytic.designs import TABLE_1_RIGID, changed, walker_of

EDGES = {
    "no hip mass": {"hip_mass": 0.0},
    "point feet": {"foot_radius": 0.0},
    "mass at the foot's bottom": {"foot_com": 0.0},
    "no hip mass, point feet, inertia": {"hip_mass": 0.0, "foot_radius": 0.0, "leg_inertia": 1e-3},
    "high mass centre, inertia": {"foot_com": 0.2, "leg_inertia": 3e-3},
}


@pytest.mark.parametrize("name", EDGES)
def test_gait_closes_and_keeps_its_books(name):
    """A gait is found; its energy audit closes; its exact derivative is that of differences."""
    walker = walker_of(changed(TABLE_1_RIGID, **EDGES[name]))
    point = find_gaits(walker, 1e-12, unstable=True)[0]
    assert point.residual <= 1e-11
    segments = record(walker, section_state(point.z, walker.p), 1, 1e-12, RIGID)
    assert abs(audit(walker, segments, step_length(walker, point)).residual) <= 1e-9
    _, exact = poincare_derivative(walker, point.z, 1e-13)

    def differences(h):
        return np.column_stack([
            (poincare_map(walker, point.z + e, 1e-13).z - poincare_map(walker, point.z - e, 1e-13).z) / (2 * h)
            for e in h * np.eye(3)])  # fmt: skip

    found = (4 * differences(5e-6) - differences(1e-5)) / 3  # the second order cancels
    assert np.abs(found - exact).max() <= 1e-5 * max(1.0, np.abs(exact).max())


def test_all_of_it_at_once_is_refused_with_a_reason():
    """No hip mass, point feet and all mass at the foot's bottom: two loose masses, no gait at 1 degree."""
    from stages.analytic.gait.gait_search import why_no_gait

    walker = walker_of(changed(TABLE_1_RIGID, hip_mass=0.0, foot_radius=0.0, foot_com=0.0), slope_deg=1.0)
    assert find_gaits(walker, 1e-11, unstable=True) == []
    assert "no periodic gait in the range searched" in why_no_gait(walker)


def test_rigid_legs_build_no_springs():
    """Stiffness and damping do not enter a walk on rigid legs."""
    z = np.array([-0.276, 0.416, -0.309])
    images = [poincare_map(walker_of(changed(TABLE_1_RIGID, stiffness=k, damping=b)), z, 1e-12).z
              for k, b in ((1.0, 0.0), (1e9, 1e4))]
    assert (images[0] == images[1]).all() and images[0].size == 3
