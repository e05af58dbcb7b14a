"""Energy and momentum, in the compiled flow and over a periodic step."""

import numpy as np
import pytest

from stages.analytic.gait.gait_report import audit
from stages.analytic.gait.gait_search import step_length
from stages.analytic.model import terms as eq
from stages.analytic.model.kinds import directions
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
    walker_of,
)
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


def test_rolling_feet_feel_all_the_force_that_moves_the_mass_centre():
    """The reaction of both feet together is what Newton's law needs for the common mass centre."""
    walker = walker_of(HEAVY_LEGS)
    p = walker.p
    hip_mass, foot_mass, radius, com, gravity = p.M, p.m, p.r, p.l, np.array([p.g_x, p.g_y])

    def momentum(y):
        """Of hip and feet, by finite differences of their positions."""
        def positions(q):
            theta, stance, psi, swing = q
            up, down = np.array([np.sin(theta), np.cos(theta)]), np.array([np.sin(psi), -np.cos(psi)])
            centre = np.array([radius * theta, radius])
            hip = centre + (stance - radius) * up
            feet = centre + (com - radius) * up + hip + (swing - com) * down
            return hip_mass * hip + foot_mass * feet
        h = 1e-6
        return (positions(y[:4] + h * y[4:]) - positions(y[:4] - h * y[4:])) / (2 * h)

    rates, h = np.empty(8), 1e-4
    for y in double_stance_states(walker, 20):
        flow(DOUBLE_STANCE, y, walker.p, rates)
        force = (momentum(y + h * rates) - momentum(y - h * rates)) / (2 * h) - gravity
        found = eq.compliant_reaction(*y, *rates[4:], walker.p)
        assert np.allclose(found, force, atol=2e-5)


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

        def rates(h, move, by, y=y):
            found = np.empty(8)
            flow(phase, y + h * move, p._make((np.array(p) + h * by).tolist()), found)
            return found

        whole = np.empty(24)
        flow(phase, np.concatenate([y, *moves]), p, whole, directions(numbers[None, :], 2))
        for column, by in enumerate((0.0 * numbers, numbers)):
            ends = [(rates(h, moves[column], by) - rates(-h, moves[column], by)) / (2 * h) for h in (2e-5, 1e-5)]
            wanted, found = (4 * ends[1] - ends[0]) / 3, whole[8 * column + 8 : 8 * column + 16]
            assert found == pytest.approx(wanted, rel=0, abs=1e-6 * max(1.0, np.abs(wanted).max()))


# --- The energy audit of a periodic step.


@pytest.mark.parametrize("design, friction", [
    (TABLE_1, None), (HEAVY_LEGS, None), (TABLE_1_RIGID, None), (changed(TABLE_1_RIGID, foot_radius=0.0), None),
    (TABLE_1, FRICTION), (TABLE_1, Friction(0.3, 0.2)), (TABLE_1, Friction(0.0, 0.0)),
], ids=["Table 1", "leg inertia", "rigid", "rigid, point feet", "friction", "little friction", "ice"])
def test_gravity_pays_for_dampers_impacts_and_sliding(design, friction):
    """Closes to 1e-9 of gravity's work; every term is counted where it arises, none as the rest of the others."""
    walker, point = found_gait(design, friction)
    report = audit(walker, record(walker, section_state(point.z, walker.p), 1, 1e-12), step_length(walker, point))
    assert abs(report.residual) <= 1e-9
    assert report.impact_loss > 0 and report.gravity_work > 0
    assert report.damper_loss == 0 if walker.rigid else report.damper_loss > 0
    assert report.friction_loss > 1e-8 if friction and friction.dynamic_friction else report.friction_loss == 0


def test_audit_notices_a_walk_that_is_not_periodic(table_1_gait):
    """Off the gait the state's energy changes over a step, and the audit does not close."""
    walker, point = table_1_gait
    segments = record(walker, section_state(point.z * [1, 1, 1, 1.02, 1], walker.p), 1, 1e-12, DOUBLE_STANCE)
    assert abs(audit(walker, segments, step_length(walker, point)).residual) > 1e-3
