"""The report on what a gait needs of the ground, and the sampled walk: its signals belong together."""

import dataclasses
from math import inf

import numpy as np
import pytest

from stages.analytic.gait import gait_search
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_report import record_steps, report_gait
from stages.analytic.gait.gait_search import find_gait, gaits_kept
from stages.analytic.gait.poincare import fixed_point
from stages.analytic.parameters import Parameters, Settings
from stages.analytic.phases.motion import DOUBLE_STANCE, RIGID
from stages.analytic.phases.section import section_state
from stages.analytic.result import Validity
from stages.analytic.run import without_impact
from stages.analytic.walk.on_a_ramp import DOES_NOT, WALKS, WALKS_IF, on_a_ramp
from stages.analytic.walk.recording import ROOM, record, states_at
from stages.analytic.walk.sampling import accelerations_and_forces
from stages.analytic.walk.validity import assess, friction_used, impulses
from tests.analytic.designs import FRICTION, RUBBER, SLOPE, TABLE_1, TABLE_1_RIGID, changed, run_alone, stiff_gait


@pytest.fixture(scope="module")
def report(table_1_gait, table_1_step):
    return assess(table_1_gait[0], table_1_step, 1.1)


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


@pytest.mark.parametrize(("changes", "slip", "descent"), [
    ({}, 0.139, 0.264), ({"hip_mass": 0.1, "foot_radius": 0.15}, 0.397, 0.220)], ids=["Table 1", "no double stance"])
def test_without_an_impact_the_landing_foot_moves_on_as_it_came(changes, slip, descent):
    """s'' = 0 keeps slip downhill and descent [m/s], and the ground is left behind by descent times duration.

    They are those of the leg's turning and shortening before heel strike, under a hip that moves.
    """
    walker, point = find_gait(changed(TABLE_1, **changes), SLOPE, 1e-10)
    found = without_impact(walker, record(walker, section_state(point.z, walker.p), 1, 1e-12, DOUBLE_STANCE))
    assert (found.slip_at_landing, found.descent_at_landing) == pytest.approx((slip, descent), abs=5e-4)
    assert found.slip_at_end == pytest.approx(found.slip_at_landing, rel=1e-9)
    assert found.descent_at_end == pytest.approx(found.descent_at_landing, rel=1e-9)
    assert found.depth_at_end == pytest.approx(found.descent_at_landing * found.duration, rel=1e-6)
    assert found.duration == pytest.approx(point.steps[0].double_stance * walker.time)


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


def test_rigid_legs_have_no_double_stance(rigid_gait):
    walker, point = rigid_gait
    step = record(walker, section_state(point.z, walker.p), 1, 1e-12, RIGID)
    report, found = assess(walker, step, 1.1), without_impact(walker, step)
    assert report.friction_double_stance_loaded == report.impulse_friction_trailing == 0
    assert found.duration == found.slip_at_end == 0.0


# --- What `gait` says first: whether a gait walks so on a plain ramp, by the forces it needs.


#: A gait that asks for nothing a plain ramp has not.
GOOD = Validity(5.0, 1.0, 0.2, 0.4, 1.1, 0.0, 0.0, 0.3, 0.5, 0.01, 0.0, 0.0, True)


def test_table_1_needs_blocks_and_a_trailing_foot_that_slips():
    walker, point = find_gait(TABLE_1, SLOPE, 1e-10)
    found = report_gait(walker, point, 1e-10, 1.1)
    said = on_a_ramp(found.validity, found.gait.stable)
    assert said.verdict == WALKS_IF and len(said.because) == 2 and found.validity.feet_push_only
    assert abs(found.validity.deepest_scuff_angle) < 0.1, "legs equally long scuff where the stance leg is upright"
    assert "4.1 mm below ground" in said.because[0] and "needs friction 24 and the ground has 1.1" in said.because[1]
    large = on_a_ramp(dataclasses.replace(found.validity, deepest_scuff=0.1234), stable=True)
    assert "passes 120 mm below ground" in large.sentence, "it was 1.2e+02"
    enough = dataclasses.replace(found.validity, friction_there_is=30.0, time_outside_cone=0.0, deepest_scuff=0.0)
    assert on_a_ramp(enough, True).verdict == WALKS


@pytest.mark.parametrize(("change", "verdict", "word"), [
    ({}, WALKS, "walks on a plain ramp"),
    ({"deepest_scuff": 2e-3}, WALKS_IF, "stepping blocks or feet that retract"),
    ({"impulse_friction_trailing": 1.2}, WALKS_IF, "trailing foot may slip"),
    ({"impulse_friction_trailing": 1318.0}, WALKS_IF, "needs friction 1320 and"),
    ({"impulse_friction_landing": 1318.0}, DOES_NOT, "landing foot needs friction 1320, the ground has 1.1"),
    ({"time_outside_cone": 0.1}, WALKS_IF, "foot may slip, as it needs more friction than there is in 10 % of double"),
    ({"impulse_normal_trailing": -1e-3}, WALKS_IF, "may lift"),
    ({"friction_single_stance": 1.2}, DOES_NOT, "the stance foot needs friction 1.2, the ground has 1.1"),
    ({"impulse_friction_landing": 1.2, "deepest_scuff": 2e-3}, DOES_NOT, "the impulse on the landing foot needs"),
    ({"least_normal_force_stance": -0.5, "friction_single_stance": inf}, DOES_NOT, "pull the stance foot with 0.5 N"),
    ({"impulse_friction_landing": inf}, DOES_NOT, "pull the landing foot"),
    ({"impulse_friction_trailing": inf}, WALKS_IF, "may lift"),
])
def test_each_force_that_the_ground_has_not_decides(change, verdict, word):
    said = on_a_ramp(dataclasses.replace(GOOD, **change), True)
    assert said.verdict == verdict and word in said.sentence and "inf" not in said.sentence


def test_an_unstable_gait_does_not_walk():
    said = "does not walk so on a plain ramp: a step enlarges what disturbs it"
    assert on_a_ramp(GOOD, False).sentence == said
    assert on_a_ramp(GOOD, False, 2).sentence == f"{said}; there is a stable cycle of 2 steps"


def test_a_gait_without_double_stance_has_no_force_in_it():
    """The trailing foot, which the ground would have to pull, leaves at once: -.69 N was the least force in no time."""
    walker = DesignPoint(TABLE_1, dataclasses.replace(SLOPE, slope_deg=4.8)).walker()
    point = fixed_point(walker, np.array([-0.3458118, 1.00189515, 0.99582865, 0.59129316, -0.25192298]), 1e-9)
    report = assess(walker, record_steps(walker, point, 1e-9), 1.1)
    assert point.steps[0].double_stance == report.least_normal_force_trailing == 0.0


# --- The sampled walk: its signals belong together.


RATE = 20_000.0
SETTINGS = Settings(tolerance=1e-11, steps=2, sampling_rate_hz=RATE)


@pytest.fixture(scope="module", params=["compliant", "rigid"])
def result(request):
    biped = TABLE_1 if request.param == "compliant" else TABLE_1_RIGID
    return run_alone(Parameters(biped, SLOPE, FRICTION, RUBBER, SETTINGS))


def smooth(walk):
    """Indices of samples whose neighbours (two each side) lie between the same two events."""
    events = np.sort(np.concatenate([walk.heel_strike_time, walk.toe_off_time]))
    phase = np.searchsorted(events, walk.time)
    inside = np.arange(2, walk.time.size - 2)
    return inside[(phase[inside - 2] == phase[inside + 2])]


def derivative(values, indices):
    """Central difference of fourth order."""
    return (8 * (values[indices + 1] - values[indices - 1]) - (values[indices + 2] - values[indices - 2])) * RATE / 12


def test_rates_are_the_derivatives_of_their_signals(result):
    walk = result.walk
    inside = smooth(walk)
    for value, rate in ((walk.hip_position, walk.hip_velocity), (walk.leg_angle, walk.leg_rate),
                        (walk.leg_length, walk.leg_length_rate)):
        assert np.abs(derivative(value, inside) - rate[inside]).max() <= 1e-6


def test_hip_sensor_measures_acceleration_minus_gravity(result):
    """Specific force from finite differences of hip velocity and the inner leg's angle alone."""
    walk = result.walk
    inside = smooth(walk)
    felt = derivative(walk.hip_velocity, inside) - np.array(SLOPE.gravity_vector)
    phi = walk.leg_angle[inside, 0]
    forward = felt[:, 0] * np.cos(phi) + felt[:, 1] * np.sin(phi)
    upward = -felt[:, 0] * np.sin(phi) + felt[:, 1] * np.cos(phi)
    assert np.abs(np.stack([forward, upward], axis=-1) - walk.hip_specific_force[inside]).max() <= 2e-4


def test_foot_sensor_sits_at_the_foot_mass_of_the_inner_leg(result):
    walk = result.walk
    inside = smooth(walk)
    phi, length = walk.leg_angle[:, 0], walk.leg_length[:, 0] - TABLE_1.foot_com
    foot = walk.hip_position + length[:, None] * np.stack([np.sin(phi), -np.cos(phi)], axis=-1)
    velocity = derivative(foot, inside)
    middle = np.flatnonzero((np.diff(inside[:-4]) == 1) & (inside[4:-1] - inside[:-5] == 4)) + 2
    i = inside[middle]
    acceleration = (velocity[middle + 1] - velocity[middle - 1]) * RATE / 2
    felt = acceleration - np.array(SLOPE.gravity_vector)
    forward = felt[:, 0] * np.cos(phi[i]) + felt[:, 1] * np.sin(phi[i])
    upward = -felt[:, 0] * np.sin(phi[i]) + felt[:, 1] * np.cos(phi[i])
    difference = np.abs(np.stack([forward, upward], axis=-1) - walk.foot_specific_force[i])
    assert i.size > 1000
    assert np.median(difference) <= 1e-4 and difference.max() <= 2e-2


def test_leg_signals_are_continuous_and_names_alternate(result):
    walk = result.walk
    assert np.abs(np.diff(walk.leg_angle, axis=0)).max() <= 20 / RATE
    assert np.abs(np.diff(walk.hip_position, axis=0)).max() <= 2 / RATE
    assert walk.heel_strike_leg.tolist() == [1, 0, 1]
    assert walk.toe_off_leg[0] == 0


def test_walk_starts_upright_on_leg_zero(result):
    walk = result.walk
    assert walk.leg_angle[0, 0] == 0.0
    assert walk.ground_reaction[0, 0, 1] > 0 and (walk.ground_reaction[0, 1] == 0).all()
    assert result.mid_stance.stance_angle == 0.0


def test_two_runs_give_the_same_bits(result, monkeypatch):
    biped = TABLE_1 if result.gait.double_stance_s else TABLE_1_RIGID
    monkeypatch.setattr(gait_search, "gaits_kept", gaits_kept.__wrapped__)  # this run searches as well
    again = run_alone(Parameters(biped, SLOPE, FRICTION, RUBBER, SETTINGS))
    assert again.walk.hip_specific_force.tobytes() == result.walk.hip_specific_force.tobytes()
    assert again.gait.floquet_multipliers.tobytes() == result.gait.floquet_multipliers.tobytes()


def test_a_stiff_phase_is_recorded_whole():
    """Stiff legs, damped little, take more steps than there is room for at first; energy balances over all of them."""
    stiff = dataclasses.replace(TABLE_1, stiffness=2e8, damping=224.0)
    walker, point = stiff_gait(stiff, 1e-10)
    report = report_gait(walker, point, 1e-10, FRICTION.static_friction)
    longest = max(len(segment.times) for segment in record_steps(walker, point, 1e-10))
    assert longest > ROOM
    assert abs(report.energy.residual) < 1e-10 * np.sqrt(longest)  # of each step a tolerance, as chance has its sign
