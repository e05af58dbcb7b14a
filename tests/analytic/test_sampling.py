"""The sampled walk: its signals belong together."""

import dataclasses

import numpy as np
import pytest

from stages.analytic.gait import gait_search
from stages.analytic.gait.gait_report import record_steps, report_gait
from stages.analytic.gait.gait_search import gaits_kept
from stages.analytic.parameters import Parameters, Settings
from stages.analytic.walk.recording import ROOM
from tests.analytic.designs import FRICTION, RUBBER, SLOPE, TABLE_1, TABLE_1_RIGID, run_alone, stiff_gait

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


def test_step_length_is_the_advance_of_the_hip(result):
    """Mean speed from hip position over whole steps, against the gait's own numbers."""
    walk, gait = result.walk, result.gait
    advance = np.interp(walk.time[0] + 2 * gait.period_s, walk.time, walk.hip_position[:, 0]) - walk.hip_position[0, 0]
    assert advance == pytest.approx(2 * gait.step_length_m, rel=1e-6)
    assert gait.speed_m_s == pytest.approx(gait.step_length_m / gait.period_s)


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
