"""Gaits of compliant legs with Coulomb friction at the hip: events in both stances, sticking, energy, multipliers."""

from __future__ import annotations

import numpy as np
import pytest

from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import fixed_point, poincare_derivative
from stages.analytic.integration.phase import EVENT, NO_NODES, integrate
from stages.analytic.model.kinds import DetailedCompliant, with_legs_exchanged
from stages.analytic.model.terms import exchanged
from stages.analytic.model.walker import build_walker
from stages.analytic.phases.motion import HIP_STICKS, ON_BOTH, RUBS_BACK, RUBS_FORWARD, flow, holding_torque, motion
from stages.analytic.phases.section import section_state
from stages.analytic.phases.succession import ends_step, hip_phase, hip_succession
from stages.analytic.run import without_impact
from stages.analytic.walk.recording import crossing_state, record, walk_on
from stages.analytic.walk.sampling import sample_walk
from stages.biped.design import BeyondModel
from tests.analytic.designs import FRICTION, SLOPE, TABLE_1, changed, found_gait
from tests.analytic.differences import map_slope

FREE = changed(TABLE_1, frame_mass=0.01, frame_com=0.02)
#: Of differences: lengths change by less than the springs' deflection.
SIZES = (4e-6, 4e-7, 4e-7, 4e-6, 4e-6)


@pytest.fixture(scope="module")
def free():
    return found_gait(FREE)


def rubbing(friction, **values):
    return build_walker(changed(FREE, hip_friction=friction, **values), SLOPE)


def test_without_friction_nothing_rubs(free):
    """The gait goes to that of a free hip in proportion to the friction."""
    _, point = free
    moved = [fixed_point(rubbing(friction), point.z, 1e-12).period - point.period for friction in (1e-5, 2e-5)]
    assert abs(moved[0]) > 1e-8 and moved[1] == pytest.approx(2 * moved[0], rel=5e-3)


@pytest.mark.parametrize("friction", [1e-4, 3e-3])
def test_multipliers_are_those_of_differences(free, friction):
    walker = rubbing(friction)
    assert isinstance(walker.p, DetailedCompliant)
    point = fixed_point(walker, free[1].z, 1e-13)
    scale = np.abs(point.monodromy_matrix).max()
    assert np.abs(point.monodromy_matrix - map_slope(walker, point.z, SIZES)).max() < 2e-6 * scale
    assert np.abs(point.floquet_multipliers).max() < 1.0


@pytest.mark.parametrize(("friction", "angle", "rate", "phases"), [
    (0.003, -0.24, 0.35, (RUBS_BACK + ON_BOTH, RUBS_FORWARD + ON_BOTH, RUBS_FORWARD)),
    (0.01, -0.30, 0.42, (RUBS_BACK + ON_BOTH, RUBS_BACK, RUBS_FORWARD, RUBS_BACK)),
])
def test_the_map_is_exact_through_turning_in_either_stance(free, friction, angle, rate, phases):
    walker, z = rubbing(friction), free[1].z.copy()
    z[0], z[3] = angle, rate
    assert tuple(segment.phase for segment in record(walker, section_state(z, walker.p), 1, 1e-12)) == phases
    _, derivative = poincare_derivative(walker, z, 1e-13)
    assert np.abs(derivative - map_slope(walker, z, SIZES)).max() < 5e-6 * max(1.0, np.abs(derivative).max())


def to_event(walker, phase, y):
    status, duration, *_ = integrate(phase, y, walker.p, 1e-13, 30.0, 100_000, 0.02, NO_NODES)
    assert status == EVENT
    return duration


def together(walker, angle, length, rate_of_stance):
    """A state with both feet on the ground whose legs do not move against each other; legs are equally long."""
    def rate(speed):
        y = section_state(np.array([angle, length, length, rate_of_stance, speed]), walker.p)
        return y[4] + y[6], y

    low, high = rate(0.0)[0], rate(1.0)[0]
    return rate(-low / (high - low))[1]


@pytest.mark.parametrize(("friction", "both", "follows"), [
    (0.5, None, None), (0.04, None, (RUBS_FORWARD, RUBS_BACK)),
    (10.0, (-0.1, 1.0, 0.1), (HIP_STICKS,)), (12.6, (-0.2, 0.99, 0.1), (RUBS_FORWARD + ON_BOTH,)),
])
def test_a_hip_that_sticks_goes_on_to_what_comes_first(friction, both, follows):
    """In single stance to the landing or until it lets go, in double stance to toe-off or until it lets go.

    It moves as one body to that event, and variations are those of differences.
    """
    walker = rubbing(friction)
    start = together(walker, *both) if both else np.array([-0.05, 1.0, 0.3, 1.0, 0.5, 0.0, -0.5, 0.0])
    phase = hip_phase(bool(both), start, walker.p)
    assert phase == HIP_STICKS + (ON_BOTH if both else 0)
    y = np.concatenate([start, np.eye(8).ravel()])
    assert to_event(walker, phase, y) > 1e-3 and abs(y[4] + y[6]) < 1e-11
    landed = ends_step(phase, y, walker.p)
    assert landed == (follows is None)
    if not landed:
        assert hip_succession(phase, y, walker.p) in follows
    for column, unit in enumerate(np.eye(8)):
        slopes = []
        for h in (4e-6, 2e-6):
            ahead, behind = start + h * unit, start - h * unit
            to_event(walker, phase, ahead)
            to_event(walker, phase, behind)
            slopes.append((ahead - behind) / (2 * h))
        wanted, found = (4 * slopes[1] - slopes[0]) / 3, y[8 * column + 8 : 8 * column + 16]
        assert found == pytest.approx(wanted, rel=0, abs=2e-6 * max(1.0, np.abs(wanted).max())), column


@pytest.mark.parametrize("both", [True, False])
def test_the_holding_torque_holds(free, both):
    """Rates of a hip that sticks keep the angle between the legs; constraints stay; power of friction is negative."""
    walker = rubbing(0.3)
    y = section_state(free[1].z, walker.p)
    y[6] = -y[4]
    rates = np.empty(8)
    flow(HIP_STICKS + (ON_BOTH if both else 0), y, walker.p, rates)
    assert abs(rates[4] + rates[6]) < 1e-12
    rubs = RUBS_FORWARD + (ON_BOTH if both else 0)
    qdd, _, system = motion(rubs, y, walker.p._replace(tau_h=0.0))
    held = holding_torque(rubs, y, walker.p)
    assert rates[4:] == pytest.approx(np.array(qdd) + held * np.array(system.by_torque), abs=1e-12)


def test_energy_audit_closes_with_friction(free):
    walker = rubbing(3e-3)
    point = fixed_point(walker, free[1].z, 1e-12)
    report = report_gait(walker, point, 1e-12, 1.1)
    assert abs(report.energy.residual) < 1e-8
    turned = sum(abs(segment.end[[0, 2]].sum() - segment.states[0, [0, 2]].sum()) for segment in report.segments)
    assert walker.p.tau_h * turned * walker.energy > 1e-2 * report.energy.gravity_work  # the audit counts it
    plain = report_gait(*free, 1e-12, 1.1)
    assert report.validity.least_normal_force_stance == pytest.approx(plain.validity.least_normal_force_stance, rel=0.1)


def test_a_walk_is_sampled_through_its_events(free):
    walker = rubbing(3e-3)
    point = fixed_point(walker, free[1].z, 1e-12)
    walk = sample_walk(walker, walk_on(walker, crossing_state(walker, point.z, 1e-12), 3, 1e-12), 500.0)
    assert np.diff(walk.heel_strike_time) == pytest.approx(point.period * walker.time, abs=1e-9)
    assert len(walk.toe_off_time) == len(walk.heel_strike_time) - 1


def test_legs_that_differ_rub_as_well(free):
    walker = rubbing(1e-3, other_foot_mass=0.3345)
    assert exchanged(walker.p) == with_legs_exchanged(walker.p) != walker.p
    point = fixed_point(walker, free[1].z, 1e-12)
    assert point is not None and len(point.steps) == 2 and abs(point.steps[0].period - point.steps[1].period) > 1e-5


def test_the_search_finds_a_gait_by_itself():
    walker, point = find_gait(changed(FREE, hip_friction=2e-3), SLOPE, 1e-10)
    assert isinstance(walker.p, DetailedCompliant) and point.residual < 1e-9
    found = without_impact(walker, record(walker, section_state(point.z, walker.p), 1, 1e-10))
    assert found.slip_at_end == pytest.approx(found.slip_at_landing, rel=1e-9)  # the contact holds it, rubbing or not


def test_what_is_not_known_is_said(free):
    with pytest.raises(BeyondModel, match="together with a trailing foot that may slip"):
        build_walker(changed(FREE, hip_friction=1e-3), SLOPE, FRICTION)
