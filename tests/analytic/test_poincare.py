"""The step map: its fixed point and derivative, however they are computed, up to the edges of what is legal."""

import numpy as np
import pytest

from benchmarks.round_off import eliminate, orders_of_summation, precisions, similarity, step, system
from stages.analytic.gait.gait_report import audit
from stages.analytic.gait.gait_search import find_gaits, step_length
from stages.analytic.gait.poincare import fixed_point, poincare_derivative
from stages.analytic.integration.readable import accelerations
from stages.analytic.model import terms as eq
from stages.analytic.phases.motion import RIGID
from stages.analytic.phases.section import section_state
from stages.analytic.walk.recording import record
from stages.analytic.walk.validity import dense_states
from stages.ground.slope import Friction
from tests.analytic.designs import (
    FRICTION,
    TABLE_1,
    TABLE_1_RIGID,
    changed,
    double_stance_states,
    found_gait,
    walker_of,
)
from tests.analytic.differences import map_slope

#: Walkers, and sizes of differences: stiff springs make the map curved on the scale of their deflection.
KINDS = [(TABLE_1, None, (4e-4, 8e-6, 8e-6, 4e-4, 4e-4)), (TABLE_1_RIGID, None, (4e-4,) * 3),
         *((TABLE_1, Friction(*pair), (2e-4, 4e-6, 4e-6, 2e-4, 2e-4, 2e-5, 2e-4))
           for pair in ((1.1, 1.0), (1.1, 1.1), (0.0, 0.0), (0.5, 0.4)))]  # fmt: skip
#: Walkers with the paper's friction, or none: design, friction.
WALKERS = pytest.mark.parametrize("biped, friction", [(TABLE_1, None), (TABLE_1_RIGID, None), (TABLE_1, FRICTION)])


def test_gait_of_table_1(table_1_gait):
    """Step frequency within 1% of the paper's 2.08 Hz at 2 degrees, nothing fitted; stable, as the paper says."""
    walker, point = table_1_gait
    assert 1 / (point.steps[0].period * walker.time) == pytest.approx(2.08, rel=0.01)
    assert np.abs(point.floquet_multipliers).max() < 1


@pytest.mark.parametrize(("biped", "friction", "sizes"), KINDS)
def test_a_fixed_point_closes_and_its_derivative_is_that_of_central_differences(biped, friction, sizes):
    """Through all events, of feet that slip too."""
    walker, point = found_gait(biped, friction)
    _, exact = poincare_derivative(walker, point.z, 1e-13)
    assert point.residual <= 1e-11
    assert np.abs(exact - map_slope(walker, point.z, sizes)).max() <= 1e-7 * np.abs(exact).max()


@WALKERS
def test_period_and_multipliers_do_not_depend_on_the_tolerance(biped, friction):
    """Trap 3: an event located to 1e-6 would show here at every tolerance."""
    walker, start = found_gait(biped, friction)
    coarse, alike, less = (1e-10, 1e-10, 3e-10) if friction is None else (1e-9, 1e-9, 1e-8)
    loose, tight = fixed_point(walker, start.z, coarse), fixed_point(walker, start.z, 1e-13)
    assert loose.steps[0].period == pytest.approx(tight.steps[0].period, rel=alike)
    largest = [np.sort(np.abs(point.floquet_multipliers))[::-1][:2] for point in (loose, tight)]
    assert np.abs(largest[0] / largest[1] - 1).max() <= less


def test_constraints_hold_through_double_stance(table_1_step, table_1_gait):
    """Height of the trailing foot, its rolled distance against its turning, and both rates stay within 1e-10."""
    walker, _ = table_1_gait
    states, radius = dense_states(walker, table_1_step[0]), walker.p.r
    theta, stance, psi, swing = states[:, :4].T
    height = (stance - radius) * np.cos(theta) - (swing - radius) * np.cos(psi)
    travel = radius * (theta + psi) + (stance - radius) * np.sin(theta) + (swing - radius) * np.sin(psi)
    assert np.abs(height).max() <= 1e-10
    assert np.abs(travel - travel[0]).max() <= 1e-10
    for y in states:
        c = np.array(eq.contact_terms(*y, walker.p))
        assert abs(c[0:4] @ y[4:]) <= 1e-10 and abs(c[4:8] @ y[4:]) <= 1e-10


# --- Rigid legs at the edges of what is legal: no hip mass, point feet, mass at the foot's bottom, leg inertia.


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
    found = map_slope(walker, point.z, (1e-5,) * 3)
    assert np.abs(found - exact).max() <= 1e-5 * max(1.0, np.abs(exact).max())


def test_all_of_it_at_once_is_refused_with_a_reason():
    """No hip mass, point feet and all mass at the foot's bottom: two loose masses, no gait at 1 degree."""
    from stages.analytic.gait.gait_search import why_no_gait

    walker = walker_of(changed(TABLE_1_RIGID, hip_mass=0.0, foot_radius=0.0, foot_com=0.0), slope_deg=1.0)
    assert find_gaits(walker, 1e-11, unstable=True) == []
    assert "no periodic gait in the range searched" in why_no_gait(walker)


# --- Round-off of one step: similar bipeds, three precisions, orders of summation.


EXTENDED = pytest.mark.skipif(np.finfo(np.longdouble).nmant < 60, reason="longdouble is double on this machine")


@pytest.mark.parametrize("factors", [(1e-3, 1e-2, 0.165), (1e6, 30.0, 2.53)])
def test_similar_bipeds_walk_alike(factors):
    """Scaled in mass, length and gravity, the dimensionless gait is the same."""
    assert similarity(factors) < 1e-10


def test_elimination_solves(table_1_gait):
    """Against numpy's solver through the readable accelerations."""
    walker = table_1_gait[0]
    for y in double_stance_states(walker, 10):
        qdd, force = accelerations(walker, y, True)
        found = eliminate(*system(walker, y, True, np.float64))
        assert found == pytest.approx(np.concatenate([qdd, force]), rel=1e-10, abs=1e-12)


def test_fixed_steps_follow_the_gait(table_1_gait):
    """The scheme that measures round-off integrates the gait: its end is the compiled step's, to its truncation."""
    walker, point = table_1_gait
    taken = point.steps[0]
    start = section_state(point.z, walker.p)
    end = step(walker, start, (taken.double_stance, taken.period - taken.double_stance), np.float64)
    clearance = (end[1] - walker.p.r) * np.cos(end[0]) - (end[3] - walker.p.r) * np.cos(end[2])
    assert abs(clearance) < 1e-6, "the step ends at heel strike"
    assert -end[2] == pytest.approx(taken.state[0], abs=1e-6), "whose new stance leg is the compiled step's"


@EXTENDED
def test_double_precision_is_enough_and_single_is_not(table_1_gait):
    """Round-off scales with the precision: 2^29 lies between single and double."""
    found = precisions(*table_1_gait)
    assert found["double"] < 1e-12
    assert 1e-6 < found["single"] < 1e-2
    assert 1e7 < found["single"] / found["double"] < 1e10


def test_order_of_summation_does_not_matter(table_1_gait):
    assert orders_of_summation(table_1_gait[0], double_stance_states(table_1_gait[0], 20)) < 1e-12
