"""Compliant legs with Coulomb friction at the hip: derivatives by the numbers of the design, through all its events."""

from __future__ import annotations

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives, step_tangents
from stages.analytic.derivatives.multipliers import multiplier_derivatives
from stages.analytic.derivatives.numbers import left_by_dimensions, moved, sensitive_names
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.poincare import fixed_point, poincare_derivative
from stages.analytic.integration.phase import EVENT, NO_NODES, integrate
from stages.analytic.model.kinds import directions
from stages.analytic.phases.motion import HIP_STICKS, ON_BOTH, RUBS_BACK, RUBS_FORWARD
from stages.analytic.phases.section import section_state, section_tangent
from stages.analytic.phases.succession import succeed
from stages.analytic.walk.recording import record
from tests.analytic.designs import SLOPE, changed, found_gait
from tests.analytic.differences import extrapolated, gait_slope, shares, step_slope
from tests.analytic.differences import together as along_all
from tests.analytic.test_compliant_hip import FREE, rubbing, together

#: One change of each of the numbers that the hip's events, toe-off, heel strike and impact feel in ways of their own.
NUMBERS = ("tau_h", "k", "b_2", "l", "m_2", "phi_h", "g_x", "b_h", "l_f_2", "r_2", "L_nat")
STUCK = (HIP_STICKS, HIP_STICKS + ON_BOTH)


@pytest.fixture(scope="module")
def free():
    return found_gait(FREE)


@pytest.mark.parametrize(("friction", "angle", "rate", "phases"), [
    (0.003, -0.24, 0.35, (RUBS_BACK + ON_BOTH, RUBS_FORWARD + ON_BOTH, RUBS_FORWARD)),
    (0.01, -0.30, 0.42, (RUBS_BACK + ON_BOTH, RUBS_BACK, RUBS_FORWARD, RUBS_BACK)),
])
def test_a_step_s_derivatives_are_exact_through_turning_in_either_stance(free, friction, angle, rate, phases):
    """Against extrapolated differences: coordinates after the step, and its period."""
    walker, z = rubbing(friction, hip_stiffness=1e-3), free[1].z.copy()
    z[0], z[3] = angle, rate
    assert tuple(segment.phase for segment in record(walker, section_state(z, walker.p), 1, 1e-12)) == phases
    along = shares(walker, NUMBERS)
    exact = step_tangents(walker, z, along, 1e-13)
    by_state = poincare_derivative(walker, z, 1e-13)[1]
    assert np.abs(exact.by_start - by_state).max() < 1e-9 * max(1.0, np.abs(by_state).max())
    for row, name in enumerate(NUMBERS):
        found = np.append(exact.along[:, row], exact.time_along[row])
        wanted = step_slope(walker, z, along[row], 4e-6)
        assert found == pytest.approx(wanted, rel=0, abs=2e-6 * max(1.0, np.abs(found).max())), name


@pytest.mark.parametrize(("friction", "both", "phases"), [
    (0.5, None, 1), (0.04, None, 2), (10.0, (-0.1, 1.0, 0.1), 1), (12.6, (-0.2, 0.99, 0.1), 2)])
def test_derivatives_by_numbers_are_exact_where_the_hip_sticks(friction, both, phases):
    """In single stance to the landing, or until it lets go and on; in double stance to toe-off, or the same."""
    walker = rubbing(friction)
    start = together(walker, *both) if both else np.array([-0.05, 1.0, 0.3, 1.0, 0.5, 0.0, -0.5, 0.0])
    along = shares(walker, NUMBERS)

    def walked(p, y, numbers=None):
        """The state at the last event, and how long all took."""
        phase, duration = HIP_STICKS + (ON_BOTH if both else 0), 0.0
        for each in range(phases):
            phase = phase if each == 0 else succeed(phase, y, p, numbers)[0]
            status, more, *_ = integrate(phase, y, p, 1e-13, 30.0, 100_000, 0.02, NO_NODES, numbers)
            assert status == EVENT
            duration += more
        assert phases == 1 or phase not in STUCK
        return y, duration

    def begun(p):
        y = start.copy()
        if both:  # both feet stay on the ground where the numbers change
            y = section_state(np.array([start[0], start[1], start[3], start[4], start[5]]), p)
        return y

    numbers = directions(along, len(along))
    own = np.zeros(8 * len(along))
    if both:
        own = section_tangent(start[[0, 1, 3, 4, 5]], start, walker.p, numbers)[40:]
    y, _ = walked(walker.p, np.concatenate([start, own]), numbers)
    for row, name in enumerate(NUMBERS):

        def there(share):
            beside = moved(walker, share * along[row]).p  # noqa: B023
            return np.append(*walked(beside, begun(beside)))

        found = np.append(y[8 * row + 8 : 8 * row + 16], numbers.delays[row])
        wanted = extrapolated(there, 1e-5)
        assert found == pytest.approx(wanted, rel=0, abs=3e-6 * max(1.0, np.abs(found).max())), name


@pytest.mark.parametrize("values", [{}, {"other_foot_mass": 0.3345}])
def test_a_gait_s_derivatives_are_those_of_differences(free, values):
    """Period and step length of the gait, by the friction and by what else there is; a stride where the legs differ."""
    design = DesignPoint(changed(FREE, hip_friction=1e-3, **values), SLOPE)
    point = fixed_point(design.walker(), free[1].z, 1e-13)
    names = ("biped.hip_friction", "biped.foot_mass", "biped.frame_com", "ground.slope_deg", "biped.damping")
    gait = gait_derivatives(design, point, names, 1e-13)
    exact = np.array([gait.period * gait.walker.time, gait.step_length * gait.walker.length])
    for group, weights in along_all(np.abs(exact).max(axis=0), 5):
        wanted = gait_slope(design, point.z, {names[row]: by for row, by in zip(group, weights, strict=True)})
        # what each of them may be off by at most, if it is alone
        allowed = np.abs(weights) * np.maximum(1e-8, 2e-6 * np.abs(exact[:, group]))
        assert (np.abs(exact[:, group] @ weights - wanted) <= allowed.min(axis=1)).all(), group


def test_dimensions_set_the_sums_of_elasticities(free):
    """Of period and step length, and of the magnitudes of the multipliers, which no unit moves."""
    design = DesignPoint(changed(FREE, hip_friction=1e-3), SLOPE)
    point = fixed_point(design.walker(), free[1].z, 1e-13)
    gait = gait_derivatives(design, point, sensitive_names(design), 1e-13)
    assert "biped.hip_friction" in gait.changes.names
    there = [row for row, value in enumerate(gait.changes.values) if value != 0.0]
    units = [gait.changes.units[row] for row in there]
    for measure, unit in (("period_s", "s"), ("step_length_m", "m")):
        assert np.abs(left_by_dimensions(gait.elasticities()[measure][there], units, unit)).max() < 1e-8
    of_multipliers = multiplier_derivatives(gait.only([gait.changes.names[row] for row in there]))
    assert np.abs(left_by_dimensions(of_multipliers.elasticities()[0], units, "1")).max() < 1e-6
