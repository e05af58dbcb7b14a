"""The stage as a whole, from a stand-in for the analytic result."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from stages.twin.run import run


@pytest.fixture(scope="module")
def analytic(rough):
    force = np.array([[[0.0, 9.4], [0.0, 0.0]]])
    return {"analytic": SimpleNamespace(mid_stance=rough, walk=SimpleNamespace(ground_reaction=force))}


@pytest.fixture(scope="module")
def result(parameters, analytic):
    settings = dataclasses.replace(parameters.settings, steps=6)
    return run(dataclasses.replace(parameters, settings=settings), analytic)


def test_it_walks_and_says_so(result):
    assert result.outcome == "completed" and result.steps == 6
    assert "6 steps" in result.summary() and "\n" not in result.summary()
    assert len(result.walk.heel_strike_time) == 6 and len(result.settling.step_period) == 5
    assert result.energy.relative_residual < 1e-4


def test_signals_share_one_grid(result, parameters):
    n, signals = len(result.walk.time), result.signals
    spacing = np.diff(result.walk.time)
    assert spacing.min() > 0 and spacing.max() <= 1.000001 / parameters.settings.sampling_rate_hz
    for name in (
        "hip_imu_specific_force",
        "hip_imu_angular_velocity",
        "foot_imu_specific_force",
        "foot_imu_angular_velocity",
    ):
        assert getattr(signals, name).shape == (n, 3)
    assert signals.roll.shape == signals.yaw.shape == signals.lateral.shape == (n,)
    values = (signals.coordinates, signals.foot_force, *vars(result.walk).values())
    assert all(np.isfinite(value).all() for value in values)


def test_snapshots_show_legs_of_the_right_length(result):
    poses = result.snapshots
    along = np.einsum("kij,kij->ki", poses.leg_top - poses.foot_centre, poses.leg_up)
    assert along + poses.foot_radius == pytest.approx(0.333, abs=0.01)
    assert poses.foot_centre[:, :, 1].min() > 0.9 * poses.foot_radius[0]


def test_tables_name_every_part_and_every_sum(result, parameters):
    (_, columns, bill), (_, _, sums), (_, _, steps) = result.tables()
    assert [row[0] for row in bill] == [part.name for part in parameters.settings.parts]
    assert all(len(row) == len(columns) for row in bill)
    assert len(sums) == 7 and len(steps) == 5


def test_a_fall_is_a_result(parameters, rough, analytic):
    slow = dataclasses.replace(rough, stance_rate=-0.4, swing_rate=0.0)
    stand_in = SimpleNamespace(mid_stance=slow, walk=analytic["analytic"].walk)
    result = run(parameters, {"analytic": stand_in})
    assert result.outcome != "completed" and result.reason and result.reason in result.summary()
    assert np.isnan(result.settling.period_s) and len(result.walk.time) > 10


@pytest.mark.slow
def test_it_walks_a_hundred_steps(parameters, analytic):
    settings = dataclasses.replace(parameters.settings, steps=100)
    result = run(dataclasses.replace(parameters, settings=settings), analytic)
    assert result.outcome == "completed" and result.steps == 100
    assert 0 <= result.settling.steps_to_settle < 20
