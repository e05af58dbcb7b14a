"""A driven robot that is followed by its encoders: its states held against those its steps were made from."""

import dataclasses

import numpy as np
import pytest

from stages.biped.question import WrongOption
from stages.calibration.angles.recording import DrivenStep, read_steps
from stages.calibration.angles.robot import OF_STATE, Robot, drive_of, setup_of
from stages.calibration.angles.same import FittedEncoders, read
from stages.calibration.following import encoders
from stages.calibration.following.encoders import follow, with_noise
from stages.calibration.following.robot_file import NAME
from stages.calibration.intervals.model_error import whiteness
from stages.calibration.reports.angle_report import calibrated
from tests.calibration.runs import BIPED
from tests.calibration.test_angles import AUTHORS, LEVEL, RECORDED, ROBOT, about, needs_real
from tests.commands import run
from tests.similar import factor, similar

NAMES = ("biped.foot_com", "biped.other_foot_com", "torque_constant", "hip_zero", "stance_zero_0")
NOISE, SAMPLES = 3e-4, 100


def robot_and_sizes(scale):
    """A robot of masses, lengths and times so many times as large, and how well its numbers are known."""
    design = dataclasses.replace(ROBOT.design, biped=similar(ROBOT.design.biped, scale),
                                 slope=similar(ROBOT.design.slope, scale))  # fmt: skip
    robot = Robot(design, {**ROBOT.numbers, "torque_constant": 0.018 * factor("N", scale) * scale[1]})
    return robot, np.array([3e-4 * scale[1], 3e-4 * scale[1], 0.02 * robot.value("torque_constant"), 2e-3, 2e-3])


def fitted(robot, sizes):
    """The robot with numbers known so well, and encoders' noise."""
    setup = dataclasses.replace(setup_of(about("recording: {left_out_samples: 0}"), BIPED, LEVEL), robot=robot,
                                free=NAMES)  # fmt: skip
    return FittedEncoders(setup, np.diag(sizes**2), NOISE, 20, (0.0, 1.0), dict(zip(NAMES, sizes, strict=True)),
                          np.full((2, 2), NOISE), np.full((2, 2), 1e-12))  # fmt: skip


def driven(robot, sizes, rng, scale, leg):
    """A step of half a second of a robot that is not quite this one, and its states."""
    truth = robot.with_values({name: robot.value(name) + size * rng.normal()
                               for name, size in zip(NAMES, sizes, strict=True)})  # fmt: skip
    times = np.linspace(0.0, 0.5, SAMPLES)
    signal = rng.normal() + 6.0 * np.sin(2 * np.pi * (times * rng.uniform(1, 3) + rng.uniform()))
    step = DrivenStep(0, leg, float(times[1]) * scale[2], times, times, signal)
    drive = drive_of(truth, step, ())
    start = np.array([-0.16, -0.2, 0.68 / scale[2], -0.3 / scale[2]])
    states = drive.along(start, step.interval, slice(None)).states
    angles = states @ OF_STATE.T + drive.zeros + NOISE * rng.normal(size=(SAMPLES, 2))
    return dataclasses.replace(step, stance=angles[:, 0], between=angles[:, 1]), states


@pytest.mark.parametrize("scale", [(1, 1, 1), (8, 2, 3)], ids=["the compass", "another size and gravity"])
def test_a_state_is_known_as_well_as_it_says_and_what_is_new_is_white(scale):
    robot, sizes = robot_and_sizes(scale)
    follower = fitted(robot, sizes)
    rng, squares, new = np.random.default_rng(3), [], []
    for number in range(24):
        step, states = driven(robot, sizes, rng, scale, number % 2)
        seen = list(follow(follower, step))
        assert len(seen) == SAMPLES - encoders.BEGIN
        for one, state in zip(seen[::8], states[encoders.BEGIN :: 8], strict=True):
            squares.append((one.state - state) @ np.linalg.solve(one.covariance, one.state - state) / 4)
        new.append([one.innovation for one in seen])
    assert 0.7 < np.mean(squares) < 1.4
    assert np.mean(np.square(new)) == pytest.approx(1.0, abs=0.1)
    assert np.mean([whiteness(column) > 0.01 for each in new for column in np.transpose(each)]) > 0.9


def test_only_samples_up_to_a_time_tell_of_it():
    robot, sizes = robot_and_sizes((1, 1, 1))
    follower = fitted(robot, sizes)
    step, _ = driven(robot, sizes, np.random.default_rng(5), (1, 1, 1), 0)
    part = dataclasses.replace(step, stance=step.stance[:50], between=step.between[:50])
    for one, other in zip(follow(follower, part), follow(follower, step), strict=False):
        assert np.array_equal(one.state, other.state)


def test_what_moves_it_in_no_model_is_told_by_the_steps():
    """Steps of robots that differ, followed as if one were known: the noise that they want makes innovations one."""
    robot, sizes = robot_and_sizes((1, 1, 1))
    rng = np.random.default_rng(7)
    steps = [driven(robot, 3.0 * sizes, rng, (1, 1, 1), number % 2)[0] for number in range(12)]
    found = with_noise(fitted(robot, 0.0 * sizes), steps)
    assert found.encoded == pytest.approx(np.full((2, 2), NOISE), rel=0.2) and (found.unmodelled > 0.0).all()
    new = np.array([[one.innovation for one in follow(found, step)] for step in steps])
    assert (new**2).mean(axis=(0, 1)) == pytest.approx([1.0, 1.0], abs=0.15)


def test_a_robots_file_gives_it_back_and_goes_with_angles_alone(tmp_path):
    robot, sizes = robot_and_sizes((1, 1, 1))
    kept = fitted(robot, sizes)
    (tmp_path / NAME).write_bytes(kept.content())
    assert read(tmp_path).content() == kept.content()
    rng, lines = np.random.default_rng(4), ["time_s,stance_angle_rad,hip_angle_rad,motor_signal,outer_pair_stands"]
    for number in range(2):
        step, _ = driven(robot, sizes, rng, (1, 1, 1), number)
        lines += [f"{(number * SAMPLES + k) * step.interval},{-step.stance[k]},{-step.turn * step.between[k]},"
                  f"{-step.turn * step.signal[k]},{1 - number}" for k in range(SAMPLES)]  # fmt: skip
    (tmp_path / "steps.csv").write_text("\n".join(lines) + "\n")
    ended = run("follow", "steps.csv", "--as", ".", "--run", "step 1", "--csv", cwd=tmp_path)
    rows = ended.stdout.splitlines()
    assert ended.returncode == 0 and len(rows) == 1 + SAMPLES - encoders.BEGIN
    assert rows[0].startswith("run,time_s,stance_leg,phase,stance_leg_angle_rad,") and rows[1].startswith("step 1,")
    other = run("follow", "lab.sqlite", "--as", ".", cwd=tmp_path)
    assert other.returncode == 2 and "fitted to recordings of the other kind" in other.stderr
    (tmp_path / NAME).write_bytes(kept.content().replace(b"0.018", b"0.019"))
    with pytest.raises(WrongOption, match="was changed"):
        read(tmp_path)


@needs_real
def test_a_real_robots_other_steps_are_followed():
    """Innovations are as large as said; they are white in most steps, and where not the model lacks forces."""
    result = calibrated(BIPED, LEVEL, about(AUTHORS + "held_out: every other pair"), RECORDED)
    _, out = result.setup.split(read_steps(RECORDED, {}, 7))
    new = [np.array([one.innovation for one in follow(result.robot, step)]) for step in out]
    assert np.mean([(one**2).mean(axis=0) for one in new], axis=0) == pytest.approx([1.0, 1.0], abs=0.2)
    white = np.mean([[whiteness(column) > 0.01 for column in one.T] for one in new], axis=0)
    assert (white > [0.55, 0.75]).all()
