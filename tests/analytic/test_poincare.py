"""The step map: its fixed point, its derivative, and that neither depends on how it is computed."""

import numpy as np
import pytest

from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import fixed_point, poincare_derivative, poincare_map
from stages.analytic.model import terms as eq
from stages.analytic.phases.motion import DOUBLE_STANCE
from stages.analytic.phases.section import section_coordinates, section_state
from stages.analytic.walk.recording import record
from stages.analytic.walk.validity import dense_states
from stages.ground.slope import Slope
from tests.analytic.designs import SLOPE, TABLE_1, changed


def central_difference(walker, z, tolerance=1e-13):
    """Derivative of the step map by Richardson-extrapolated central differences, error O(h^4).

    Lengths get the smaller h: stiff springs make the map curved on the scale of their deflection.
    """
    columns, h = [], 4e-4
    for i in range(z.size):
        e = np.eye(z.size)[i] * (0.02 if z.size == 5 and i in (1, 2) else 1.0)

        def slope(step, e=e):
            ahead = poincare_map(walker, z + step * e, tolerance).z
            return (ahead - poincare_map(walker, z - step * e, tolerance).z) / (2 * step)

        columns.append((4 * slope(h / 2) - slope(h)) / 3 / e.sum())
    return np.column_stack(columns)


@pytest.mark.parametrize("kind", ["table_1_gait", "rigid_gait"])
def test_fixed_point_closes(kind, request):
    _, point = request.getfixturevalue(kind)
    assert point.residual <= 1e-11


def test_gait_of_table_1(table_1_gait):
    """Step frequency within 1% of the paper's 2.08 Hz at 2 degrees, nothing fitted; stable, as the paper says."""
    walker, point = table_1_gait
    assert 1 / (point.steps[0].period * walker.time) == pytest.approx(2.08, rel=0.01)
    assert np.abs(point.floquet_multipliers).max() < 1


@pytest.mark.parametrize("kind", ["table_1_gait", "rigid_gait"])
def test_multipliers_equal_those_of_central_differences(kind, request):
    walker, point = request.getfixturevalue(kind)
    _, exact = poincare_derivative(walker, point.z, 1e-13)
    found = central_difference(walker, point.z)
    assert np.abs(exact - found).max() <= 1e-7 * np.abs(exact).max()
    largest = np.sort(np.abs(np.linalg.eigvals(exact)))[::-1][:2]
    assert np.abs(largest - np.sort(np.abs(np.linalg.eigvals(found)))[::-1][:2]).max() <= 1e-7


@pytest.mark.parametrize("kind", ["table_1_gait", "rigid_gait"])
def test_period_and_multipliers_do_not_depend_on_the_tolerance(kind, request):
    """Trap 3: an event located to 1e-6 would show here at every tolerance."""
    walker, start = request.getfixturevalue(kind)
    loose, tight = fixed_point(walker, start.z, 1e-10), fixed_point(walker, start.z, 1e-13)
    assert loose.steps[0].period == pytest.approx(tight.steps[0].period, rel=1e-10)
    largest = [np.sort(np.abs(point.floquet_multipliers))[::-1][:2] for point in (loose, tight)]
    assert np.abs(largest[0] / largest[1] - 1).max() <= 3e-10


def test_image_lies_on_the_section(table_1_gait):
    """The state after a step keeps both constraints, in position and in velocity, and has five free numbers."""
    walker, point = table_1_gait
    y = poincare_map(walker, point.z + 1e-3, 1e-12).state
    assert np.abs(section_state(section_coordinates(y, walker.p), walker.p) - y).max() <= 1e-12


def test_one_multiplier_is_zero(table_1_gait):
    """Toe-off removes one of the five coordinates: the step map has at most four non-zero multipliers."""
    _, point = table_1_gait
    assert np.abs(point.floquet_multipliers).min() <= 1e-12
    assert abs(np.linalg.det(point.monodromy_matrix)) <= 1e-12


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


def test_double_stance_is_short_and_single_stance_follows(table_1_step, table_1_gait):
    _, point = table_1_gait
    double, single = table_1_step
    assert (double.phase, double.duration) == (DOUBLE_STANCE, pytest.approx(point.steps[0].double_stance, rel=1e-9))
    assert double.duration + single.duration == pytest.approx(point.steps[0].period, rel=1e-10)


def test_similar_bipeds_have_the_same_dimensionless_gait(table_1_gait):
    """Masses times 7, lengths times 3, gravity of Mars: same numbers in leg lengths and pendulum times."""
    mass, length, gravity = 7.0, 3.0, 3.71
    time = np.sqrt(length * 9.81 / gravity)
    similar = changed(
        TABLE_1, hip_mass=mass * 0.316, foot_mass=mass * 0.335, leg_length=length * 0.333, foot_radius=length * 0.083,
        foot_com=length * 0.1, stiffness=2800.0 * mass / time**2, damping=58.35 * mass / time)
    _, point = table_1_gait
    _, other = find_gait(similar, Slope(slope_deg=SLOPE.slope_deg, gravity=gravity), 1e-12)
    assert np.abs(other.z - point.z).max() <= 1e-10
    assert other.steps[0].period == pytest.approx(point.steps[0].period, rel=1e-10)
    assert np.abs(np.abs(other.floquet_multipliers) - np.abs(point.floquet_multipliers)).max() <= 1e-8


def test_a_stable_gait_draws_neighbours_in_at_the_rate_of_its_multiplier(table_1_gait):
    """Twelve steps from a disturbed start shrink the disturbance by the largest multiplier to the power."""
    walker, point = table_1_gait
    z, gaps = point.z + np.array([1e-4, 0, 0, 2e-4, 0]), []
    for _ in range(14):
        z = poincare_map(walker, z, 1e-13).z
        gaps.append(np.abs(z - point.z).max())
    assert (gaps[13] / gaps[3]) ** 0.1 == pytest.approx(np.abs(point.floquet_multipliers).max(), rel=0.02)


def test_walk_repeats_itself_over_ten_steps(table_1_gait):
    walker, point = table_1_gait
    segments = record(walker, section_state(point.z, walker.p), 10, 1e-12, DOUBLE_STANCE)
    periods = [a.duration + b.duration for a, b in zip(segments[::2], segments[1::2], strict=True)]
    assert np.ptp(periods) <= 1e-10
