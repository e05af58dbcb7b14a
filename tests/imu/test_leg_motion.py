"""Leg angle, step length and hip path against a motion that is known exactly."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from stages.campaign.parameters import Parameters
from stages.campaign.twin_run import TwinRun
from stages.imu.strikes.step_times import UNKNOWN, HeelStrikes
from stages.imu.trial.body import leg_angle
from stages.imu.trial.trial import Trial, read_trial
from stages.imu.trial.walk import hip_at, leg_motion, stance_angle
from tests.imu.conftest import RUNS
from tests.imu.made_logs import Log, made_log, with_errors
from tests.imu.made_walks import REST_S
from tests.imu.stand_in import BIPED, DRAWING, PARAMETERS, STUDY

AMPLITUDE = 0.24  # of the stand-in's leg


@pytest.fixture(scope="module")
def trials(parameters: Parameters, walks: list[TwinRun]) -> list[tuple[Log, Trial]]:
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


def test_the_angle_is_a_tenth_of_a_degree_off_and_its_error_is_what_is_said(trials: list[tuple[Log, Trial]]) -> None:
    """Two standard errors hold nearly all; the stand of these walks is exact, so errors are below what is said."""
    every = [angle_errors(*one) for one in trials]
    assert np.degrees(np.sqrt(np.mean([np.mean(error**2) for error, _ in every]))) < 0.1
    assert np.mean([np.mean(np.abs(error) <= 2 * said) for error, said in every]) > 0.95


def test_a_step_is_half_a_percent_off(trials: list[tuple[Log, Trial]]) -> None:
    """Travel of the hip between the true landings; the gyroscopes' gains alone leave 0.35 %."""
    found, true, said = [], [], []
    for log, trial in trials:
        travel = np.diff(log.leg.hip_at_strike[:, 0])[log.strike_leg[:-1] == 0]
        found.append(trial.leg.step_length)
        true.append(travel[-len(found[-1]) :])  # the first stances lie in the transient that is left out
        said.append(trial.leg.step_length_error)
    lengths, exact, errors = (np.concatenate(column) for column in (found, true, said))
    assert len(lengths) >= 3 * RUNS
    off = lengths / exact - 1
    assert abs(off.mean()) < 0.004
    assert np.sqrt(np.mean(off**2)) < 0.006
    assert np.mean(np.abs(lengths - exact) <= 1.96 * errors) > 0.9


def test_the_hips_path_is_that_of_a_rolling_foot(trials: list[tuple[Log, Trial]]) -> None:
    """Upright in mid-stance, lowest at both landings, forward all the way."""
    for _, trial in trials:
        path = trial.leg.hip_path
        assert (np.diff(path[:, :, 0], axis=1) > 0).all()
        assert path[:, :, 1].max() == pytest.approx(BIPED.leg_length, abs=1e-4)
        lowest = BIPED.foot_radius + (BIPED.leg_length - BIPED.foot_radius) * np.cos(AMPLITUDE)
        np.testing.assert_allclose(path[:, [0, -1], 1], lowest, atol=1e-3)


def test_a_rolling_wheel_travels_its_arc() -> None:
    wheel = dataclasses.replace(DRAWING, foot_radius=0.3, leg_length=0.3 + 1e-12)
    angle = np.linspace(0.5, -0.5, 11)
    np.testing.assert_allclose(hip_at(angle, wheel), np.column_stack([-0.3 * angle, np.full(11, 0.3)]), atol=1e-11)


def test_a_step_over_a_strike_that_was_missed_has_no_length() -> None:
    strikes = HeelStrikes(np.array([0.0, 0.4, 0.9, 1.3, 2.2, 2.7]), np.array([0, 1, 0, 1, 1, 0]))
    motion = leg_motion(np.linspace(0, 3, 50), np.zeros(50), 0.0, 0.0, (0.0, 0.0), strikes, UNKNOWN, DRAWING)
    assert len(motion.stance_start) == 2


def test_an_angle_is_continued_to_the_landings_from_inside_the_stance() -> None:
    """Corners that a low pass has rounded off come back: a rate that jumps at both landings."""
    time = np.arange(0.0, 1.0, 0.005)
    angle = 0.2 - 1.2 * np.clip(time - 0.3, 0, 0.4) + 0.5 * np.clip(time - 0.3, 0, 0.4) ** 2
    kernel = np.exp(-0.5 * (np.arange(-4, 5) / 1.0) ** 2)
    rounded = np.convolve(np.pad(angle, 4, mode="edge"), kernel / kernel.sum(), "valid")
    at = np.linspace(0.3, 0.7, len(stance_angle(time, angle, 0.3, 0.7)))
    exact = 0.2 - 1.2 * (at - 0.3) + 0.5 * (at - 0.3) ** 2
    assert np.abs(np.interp(at, time, rounded) - exact).max() > 1e-3
    np.testing.assert_allclose(stance_angle(time, rounded, 0.3, 0.7), exact, atol=2e-4)


def test_the_drawing_is_that_of_the_biped(parameters: Parameters) -> None:
    """What params/imu.yaml leaves null is what params/biped.yaml and params/campaign.yaml say."""
    outsole, drawing = parameters.runs.of(BIPED).outsole, STUDY.drawing
    assert (drawing.leg_length, drawing.foot_radius, STUDY.limits.lever_arm) == pytest.approx(
        (BIPED.leg_length + outsole, BIPED.foot_radius + outsole, BIPED.leg_length - BIPED.foot_com))
