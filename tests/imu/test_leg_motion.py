"""Leg angle, step length and hip path against a motion that is known exactly."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from stages.imu.trial.events import HeelStrikes
from stages.imu.trial.leg_motion import hip_at, leg_angle, leg_motion, step_times
from stages.imu.trial.trial import Trial, read_trial
from tests.imu.made_logs import Log, made_log, true_signals, with_errors
from tests.imu.made_walks import REST_S, campaign_parameters, stand_in_walks
from tests.imu.stand_in import BIPED, DRAWING, PARAMETERS

AMPLITUDE = 0.24  # of the stand-in's leg
RUNS = 8


@pytest.fixture(scope="module")
def trials() -> list[tuple[Log, Trial]]:
    parameters = campaign_parameters()
    walks = stand_in_walks(RUNS, parameters)
    logs = [made_log(number, walk, with_errors(parameters, 1.0)) for number, walk in enumerate(walks)]
    return [(log, read_trial(log.experiment, log.recordings, PARAMETERS)) for log in logs]


def angle_errors(log: Log, trial: Trial) -> tuple[np.ndarray, np.ndarray]:
    """Error of the angle through the walk, and what is said of it, (m,) [rad]."""
    motion = log.motions["hip"]
    rate = motion.angular_velocity[:, 2]
    true = leg_angle(motion.time, rate, motion.time < motion.time[0] + REST_S, 0.0)
    recording = trial.sensors["hip"].trace.indexed.recording
    low_pass = np.sqrt(2) / (2 * np.pi * log.parameters.sensor.bandwidth_hz)
    late = np.median(trial.sensors["hip"].time - recording.true_time) + low_pass  # type: ignore[attr-defined]
    at = trial.leg.time - late
    walking = (at > 0.1) & (at < motion.time[-1] - 0.1)
    return (trial.leg.angle - np.interp(at, motion.time, true))[walking], trial.leg.angle_error[walking]


def test_the_angle_is_a_tenth_of_a_degree_off(trials: list[tuple[Log, Trial]]) -> None:
    errors = np.array([np.sqrt(np.mean(angle_errors(*one)[0] ** 2)) for one in trials])
    assert np.degrees(np.sqrt(np.mean(errors**2))) < 0.1


def test_the_angles_error_is_what_is_said(trials: list[tuple[Log, Trial]]) -> None:
    """Two standard errors hold nearly all; the stand of these walks is exact, so errors are below what is said."""
    share = [np.mean(np.abs(error) <= 2 * said) for error, said in (angle_errors(*one) for one in trials)]
    assert np.mean(share) > 0.95


def true_lengths(log: Log) -> np.ndarray:
    """Travel of the hip over the inner leg's steps by its true angle, behind the sensor's low pass as the signals are.

    The stand-in turns round at a landing without any time to do so; the low pass rounds that corner off by 1 %.
    """
    sensor, motion = log.parameters.sensor, log.motions["hip"]
    rate = true_signals(log, "hip", motion.time, sensor)[:, 3 + 2]
    angle = leg_angle(motion.time, rate, motion.time < motion.time[0] + REST_S, 0.0)
    late = np.sqrt(2) / (2 * np.pi * sensor.bandwidth_hz)
    hip = hip_at(np.interp(log.strike_time + late, motion.time, angle), DRAWING)[:, 0]
    return np.diff(hip)[log.strike_leg[:-1] == 0][1:]  # the first stance begins in the transient that is left out


def test_a_step_is_less_than_a_percent_off(trials: list[tuple[Log, Trial]]) -> None:
    pairs = [(trial.leg.step_length, true_lengths(log)[-len(trial.leg.step_length) :], trial.leg.step_length_error)
             for log, trial in trials]  # fmt: skip
    found, true, said = (np.concatenate(column) for column in zip(*pairs, strict=True))
    assert len(found) >= 3 * RUNS
    error = found / true - 1
    assert abs(error.mean()) < 0.005
    assert np.mean(np.abs(found - true) <= 2 * said) > 0.9
    assert np.sqrt(np.mean(error**2)) < 0.007


def test_the_hips_path_is_that_of_a_rolling_foot(trials: list[tuple[Log, Trial]]) -> None:
    """Upright in mid-stance, lowest at both landings, forward all the way."""
    for _, trial in trials:
        path = trial.leg.hip_path
        assert (np.diff(path[:, :, 0], axis=1) > 0).all()
        top = BIPED.leg_length
        assert path[:, :, 1].max() == pytest.approx(top, abs=1e-4)
        lowest = BIPED.foot_radius + (BIPED.leg_length - BIPED.foot_radius) * np.cos(AMPLITUDE)
        np.testing.assert_allclose(path[:, [0, -1], 1], lowest, atol=1e-3)


def test_a_rolling_wheel_travels_its_arc() -> None:
    wheel = dataclasses.replace(DRAWING, foot_radius=0.3, leg_length=0.3 + 1e-12)
    angle = np.linspace(0.5, -0.5, 11)
    np.testing.assert_allclose(hip_at(angle, wheel), np.column_stack([-0.3 * angle, np.full(11, 0.3)]), atol=1e-11)


def test_step_times_by_leg() -> None:
    strikes = HeelStrikes(np.array([0.0, 0.4, 0.9, 1.3, 2.2, 2.7]), np.array([0, 1, 0, 1, 1, 0]))
    assert step_times(strikes) == pytest.approx((0.5, 0.4))
    motion = leg_motion(np.linspace(0, 3, 50), np.zeros(50), 0.0, 0.0, 2, strikes, DRAWING)
    assert motion.asymmetry == pytest.approx(0.1 / 0.45)
    assert len(motion.stance_start) == 2, "a step over a strike that was missed has no length"


def test_the_drawing_is_that_of_the_biped() -> None:
    """params/imu.yaml repeats what params/biped.yaml and params/campaign.yaml say, for a lab's robot may differ."""
    from tests.imu.stand_in import STUDY

    outsole = campaign_parameters().runs.outsole
    assert STUDY.drawing.leg_length == pytest.approx(BIPED.leg_length + outsole)
    assert STUDY.drawing.foot_radius == pytest.approx(BIPED.foot_radius + outsole)
    assert STUDY.limits.lever_arm == pytest.approx(BIPED.leg_length - BIPED.foot_com)
