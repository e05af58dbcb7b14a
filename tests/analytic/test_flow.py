"""Energy and momentum, in the compiled flow and over a periodic step."""

from functools import partial

import numpy as np
import pytest

from stages.analytic.gait.gait_report import audit, report_gait
from stages.analytic.gait.gait_search import step_length
from stages.analytic.gait.poincare import poincare_derivative, poincare_map
from stages.analytic.integration.dop853_tableau import A as EXPLICIT, B
from stages.analytic.integration.integrator import DOP853, STAGES, step_factor
from stages.analytic.integration.radau import A_INVERSE, A, C, error_norm, jacobian, take_step
from stages.analytic.integration.readable import take_step as readable_step
from stages.analytic.model import terms as eq
from stages.analytic.model.kinds import directions
from stages.analytic.model.stiffness import axial_rates
from stages.analytic.phases.motion import (
    DOUBLE_STANCE,
    NORMAL,
    PHASES,
    RIGID,
    ROLL,
    RUB,
    SINGLE_STANCE,
    SLIDE,
    STICKS,
    accelerations,
    flow,
)
from stages.analytic.phases.section import section_state
from stages.analytic.walk.recording import record
from stages.ground.slope import Friction
from tests.analytic.designs import (
    FRICTION,
    HEAVY_LEGS,
    TABLE_1,
    TABLE_1_RIGID,
    changed,
    double_stance_states,
    found_gait,
    random_states,
    stiff_gait,
    walker_of,
)
from tests.analytic.differences import extrapolated
from tests.analytic.test_detailed import LAME, LAME_RIGID


def energy(walker, y):
    return sum((eq.rigid_energy if walker.rigid else eq.compliant_energy)(*y, walker.p))


def energy_rate(phase, walker, y):
    """dE/dt along the flow, by a central difference in time."""
    rates, h = np.empty(y.size), 1e-5
    flow(phase, y, walker.p, rates)
    return (energy(walker, y + h * rates) - energy(walker, y - h * rates)) / (2 * h)


@pytest.mark.parametrize("design, phase", [
    (TABLE_1_RIGID, RIGID),
    (changed(TABLE_1_RIGID, leg_inertia=2e-3, hip_mass=0.0, foot_radius=0.0), RIGID),
    (changed(LAME_RIGID, hip_damping=0.0), RIGID),
    (changed(HEAVY_LEGS, damping=0.0), SINGLE_STANCE),
    (changed(LAME, hip_damping=0.0, damping=0.0, other_damping=0.0), SINGLE_STANCE),
], ids=["rigid", "rigid without hip mass and with point feet", "rigid, in detail", "springs", "springs, in detail"])
def test_undamped_single_stance_keeps_its_energy(design, phase):
    walker = walker_of(design)
    for y in random_states(walker, 50):
        assert abs(energy_rate(phase, walker, y)) <= 1e-8


def test_energy_falls_by_what_the_dampers_take():
    walker = walker_of(HEAVY_LEGS)
    both = double_stance_states(walker, 50)
    for phase, states in ((SINGLE_STANCE, random_states(walker, 50)), (DOUBLE_STANCE, both)):
        for y in states:
            assert energy_rate(phase, walker, y) == pytest.approx(-walker.p.b * (y[5] ** 2 + y[7] ** 2), abs=1e-7)


BOTH = changed(HEAVY_LEGS, frame_mass=0.01, frame_com=0.02, other_foot_mass=0.33, hip_stiffness=0.05, hip_damping=5e-4)


@pytest.mark.parametrize("phase", range(SINGLE_STANCE, len(PHASES)))
def test_each_phase_holds_what_its_row_says(phase):
    """And tangents are differences of the flow: along a variation of the state, and along one of all numbers too."""
    p, rng = walker_of(BOTH).p._replace(mu_s=0.9, mu_d=0.7, tau_h=0.01), np.random.default_rng(phase)
    row = PHASES[phase]
    for y in random_states(walker_of(BOTH), 4, seed=phase):
        qdd, (normal, along_ground, torque) = map(np.array, accelerations(phase, y, p))
        c = np.array(eq.contact_terms(*y, p))
        rows = ((row[NORMAL], c[0:4], c[8]), (row[ROLL], c[4:8], c[9]), (row[STICKS], [1, 0, 1, 0], 0))
        for held, part, bias in rows:
            assert not held or abs(np.dot(part, qdd) + bias) <= 1e-9 * max(1.0, np.abs(qdd).max())
        assert row[ROLL] or along_ground == pytest.approx(-row[SLIDE] * p.mu_d * normal)
        assert (row[NORMAL] or normal == 0.0) and (row[STICKS] or torque == -row[RUB] * p.tau_h)
        moves, numbers = rng.normal(size=(2, 8)), rng.normal(size=len(p)) * np.array(p)

        def rates(move, by, h, y=y):
            found = np.empty(8)
            flow(phase, y + h * move, p._make((np.array(p) + h * by).tolist()), found)
            return found

        whole = np.empty(24)
        flow(phase, np.concatenate([y, *moves]), p, whole, directions(numbers[None, :], 2))
        for column, by in enumerate((0.0 * numbers, numbers)):
            wanted = extrapolated(partial(rates, moves[column], by), 2e-5)
            found = whole[8 * column + 8 : 8 * column + 16]
            assert found == pytest.approx(wanted, rel=0, abs=1e-6 * max(1.0, np.abs(wanted).max()))


# --- The energy audit of a periodic step.


@pytest.mark.parametrize("design, friction", [
    (TABLE_1, None), (HEAVY_LEGS, None), (TABLE_1_RIGID, None), (changed(TABLE_1_RIGID, foot_radius=0.0), None),
    (TABLE_1, FRICTION), (TABLE_1, Friction(0.3, 0.2)), (TABLE_1, Friction(0.0, 0.0)),
    (LAME, None), (LAME, FRICTION), (LAME_RIGID, None),
], ids=["Table 1", "leg inertia", "rigid", "rigid, point feet", "friction", "little friction", "ice",
        "in detail", "in detail, friction", "rigid, in detail"])
def test_gravity_pays_for_dampers_impacts_and_sliding(design, friction):
    """Closes to 1e-9 of gravity's work; every term is counted where it arises, none as the rest of the others."""
    walker, point = found_gait(design, friction)
    report = report_gait(walker, point, 1e-12, 1.1).energy
    assert abs(report.residual) <= 1e-9
    assert report.impact_loss > 0 and report.gravity_work > 0
    assert (report.damper_loss > 0) == (not walker.rigid or design.hip_damping > 0)
    assert report.friction_loss > 1e-8 if friction and friction.dynamic_friction else report.friction_loss == 0


def test_audit_notices_a_walk_that_is_not_periodic(table_1_gait):
    """Off the gait the state's energy changes over a step, and the audit does not close."""
    walker, point = table_1_gait
    segments = record(walker, section_state(point.z * [1, 1, 1, 1.02, 1], walker.p), 1, 1e-12, DOUBLE_STANCE)
    assert abs(audit(walker, segments, step_length(walker, point)).residual) > 1e-3


# --- The explicit and the implicit Runge-Kutta step: tableaus, orders, damping of stiff motion, the choice of
# steps.


def fixed_steps(walker, y, duration, count, *, take_step=DOP853.take_step):
    """State after `count` equal steps of single stance."""
    stages, new, y = np.empty((STAGES, y.size)), np.empty(y.size), y.copy()
    for _ in range(count):
        flow(SINGLE_STANCE, y, walker.p, stages[0])
        take_step(SINGLE_STANCE, y, duration / count, walker.p, stages, new)
        y[:] = new
    return y


def test_tableau_meets_the_conditions_of_quadrature_to_order_eight():
    nodes = EXPLICIT.sum(axis=1)[:12]
    for power in range(8):
        assert abs(B[:12] @ nodes**power - 1 / (power + 1)) <= 1e-14


STATE = np.array([-0.2, 0.995, -0.25, 1.001, 0.4, -0.1, -0.3, 0.05])


@pytest.mark.parametrize(("steps", "design", "duration", "counts", "least", "low", "high"), [
    (DOP853.take_step, TABLE_1, 0.5, [10, 20, 40], 1e-14, 7.3, 9.0),
    (take_step, changed(TABLE_1, stiffness=300.0, damping=5.0), 1.2, [2, 3, 4], 1e-13, 11.0, 15.0),
], ids=["explicit", "implicit"])
def test_single_stance_converges_with_order_eight_or_thirteen(steps, design, duration, counts, least, low, high):
    """Implicit steps of soft legs: 13 in the limit, at least the stage order plus one on the way there."""
    walker = walker_of(design)
    best = fixed_steps(walker, STATE, duration, 320)
    errors = np.array([np.abs(fixed_steps(walker, STATE, duration, n, take_step=steps) - best).max() for n in counts])
    orders = np.diff(np.log(errors)) / -np.diff(np.log(counts))
    assert errors[-1] > least, "the finest step must still show its error"
    assert low < orders[-1] < high, (errors, orders)


def test_not_a_number_is_never_accepted():
    """An error norm of NaN must not pass as small: `err > 1` is false for it."""
    stages = np.full((STAGES, 8), np.nan)
    error = DOP853.error_norm(np.ones(8), np.full(8, np.nan), 0.1, walker_of().p, stages, 1e-10)
    assert not error <= 1.0


def test_step_factor_is_bounded():
    assert step_factor(0.0) == 6.0
    assert step_factor(1e-30) == 6.0
    assert step_factor(1e30) == 0.2


# --- The implicit step: its coefficients, its order, its damping of stiff motion, and that it is taken where it
# pays.


#: Designs at the stiff end: a damper alone, and a damped spring.
STIFF = [
    changed(TABLE_1, damping=1e4),
    changed(TABLE_1, damping=1e5),
    changed(TABLE_1, stiffness=1e8, damping=1.1e4),
    changed(TABLE_1, stiffness=1e10, damping=1e5),
]


def test_tableau_integrates_polynomials_as_collocation_does():
    """Weights (the last row of A) to degree 12, that is order 13; every stage to degree 6."""
    for power in range(13):
        assert abs(A[-1] @ C**power - 1 / (power + 1)) <= 1e-15
    for power in range(7):
        np.testing.assert_allclose(A @ C**power, C ** (power + 1) / (power + 1), atol=1e-15)
    assert C[-1] == 1.0


def test_stability_function_vanishes_at_infinity():
    """R(z) = 1 + z b (I - z A)^-1 1 tends to zero, and is at most one on the imaginary axis and left of it."""

    def growth(z):
        return abs(1 + z * (A[-1] @ np.linalg.solve(np.eye(7) - z * A, np.ones(7))))

    assert growth(-1e8) <= 1e-6
    for angle in np.linspace(np.pi / 2, np.pi, 7):
        for size in (0.1, 1.0, 10.0, 100.0):
            assert growth(size * np.exp(1j * angle)) <= 1 + 1e-12
    np.testing.assert_allclose(A_INVERSE @ A, np.eye(7), atol=1e-12)


def test_jacobian_is_that_of_the_rates():
    walker = walker_of(changed(TABLE_1, leg_inertia=1e-3))
    for y in random_states(walker, 4):
        found = jacobian(SINGLE_STANCE, y, walker.p)
        for i in range(8):
            ahead, behind = np.empty(8), np.empty(8)
            step = 1e-5 * np.eye(8)[i]
            flow(SINGLE_STANCE, y + step, walker.p, ahead)
            flow(SINGLE_STANCE, y - step, walker.p, behind)
            np.testing.assert_allclose(found[:, i], (ahead - behind) / 2e-5, rtol=1e-7, atol=1e-6)


def test_estimate_is_not_smaller_than_the_error():
    walker = walker_of(STIFF[0])
    for step in (2e-4, 1e-3, 5e-3):
        stages, new = np.empty((STAGES, 8)), np.empty(8)
        flow(SINGLE_STANCE, STATE, walker.p, stages[0])
        take_step(SINGLE_STANCE, STATE, step, walker.p, stages, new)
        estimate = error_norm(STATE, new, step, walker.p, stages, 1.0)
        error = np.abs(new - fixed_steps(walker, STATE, step, 4000)).max() / 2
        assert error <= estimate + 1e-13


@pytest.mark.parametrize("design", STIFF, ids=lambda d: f"k {d.stiffness:g}, b {d.damping:g}")
def test_stiff_legs_take_implicit_steps_and_few_of_them(design):
    walker, point = stiff_gait(design, 1e-9)
    assert walker.stiff
    assert point.residual <= max(1e-10, np.finfo(float).eps * walker.p.k)  # the spring force's round-off
    assert abs(report_gait(walker, point, 1e-9, FRICTION.static_friction).energy.residual) <= 1e-7
    rate, _ = axial_rates(walker.p)
    stability_limit = point.steps[0].period * rate / 6 * STAGES  # what explicit steps would need at least
    assert poincare_map(walker, point.z, 1e-9).evaluations < stability_limit


def test_step_of_no_length_stays_where_it_is():
    """Event location asks for it where the event is the start of a step."""
    walker, stages, new = walker_of(STIFF[0]), np.empty((STAGES, 8)), np.empty(8)
    flow(SINGLE_STANCE, STATE, walker.p, stages[0])
    take_step(SINGLE_STANCE, STATE, 0.0, walker.p, stages, new)
    np.testing.assert_array_equal(new, STATE)


def test_variations_through_implicit_steps_are_the_derivative():
    walker, point = stiff_gait(STIFF[0], 1e-12)
    _, derivative = poincare_derivative(walker, point.z, 1e-12)
    for i, size in enumerate((1e-4, 1e-6, 1e-6, 1e-4, 1e-4)):
        step = size * np.eye(5)[i]
        images = [poincare_map(walker, point.z + factor * step, 1e-12).z for factor in (2, 1, -1, -2)]
        difference = (-images[0] + 8 * images[1] - 8 * images[2] + images[3]) / (12 * size)
        np.testing.assert_allclose(derivative[:, i], difference, atol=1e-6)


def test_implicit_path_agrees_with_an_integrator_of_another_make():
    """SciPy's on lambdified equations, with events of its own."""
    walker, point = stiff_gait(changed(TABLE_1, damping=1.5e3), 1e-11)
    assert walker.stiff
    other = readable_step(walker, point.z, 1e-10)
    np.testing.assert_allclose(other.z, point.z, atol=2e-8)
    assert other.period == pytest.approx(point.steps[0].period, abs=2e-8)
