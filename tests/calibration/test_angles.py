"""A driven robot with encoders: derivatives, blind recordings of its own model, refusals, and how it is followed."""

import csv
import dataclasses
import os
import re
from pathlib import Path

import numpy as np
import pytest

from pipeline.parameters import yaml_text
from pipeline.questions.command import Described
from stages.analytic.gait.design_point import DesignPoint
from stages.biped.design import Biped
from stages.biped.question import WrongOption
from stages.calibration.angles.fit import fit_robot
from stages.calibration.angles.recording import DrivenStep, read_steps
from stages.calibration.angles.robot import OF_ROBOT, OF_STATE, USUAL, Robot, drive_of, late, setup_of, show
from stages.calibration.angles.same import FittedEncoders
from stages.calibration.estimation.least_squares import Known, NotIdentified
from stages.calibration.following import encoders
from stages.calibration.following.encoders import follow, with_noise
from stages.calibration.following.robot_file import NAME
from stages.calibration.intervals.model_error import whiteness
from stages.calibration.reports.angle_report import calibrated, parameters_left_of_angles
from stages.ground.slope import Slope
from tests.calibration.runs import BIPED
from tests.commands import run
from tests.similar import factor, similar

LEVEL = Slope(0.0, 9.81)
COMPASS = Biped(
    "rigid", 2.0, 0.7, 0.28, 0.0, 0.23, 1000.0, 0.0, 0.0026, hip_gravity_mass=-0.4, hip_damping=0.0016,
    hip_friction=0.006, other_foot_com=0.235, other_leg_inertia=0.0029)
ROBOT = Robot(DesignPoint(COMPASS, LEVEL), {**dict.fromkeys(OF_ROBOT, 0.0), "torque_constant": 0.018})
NAMES = USUAL
HALF_WIDTH = 1.959964
#: Where eighty steps of a real compass robot are; docs/calibration_tests.md says how to get them.
REAL = Path(os.environ.get("BIPEDSTUDY_REAL_ROBOT", Path(__file__).parents[3] / "shared/real_robot"))
RECORDED = REAL / "walking_80_steps.csv"
needs_real = pytest.mark.skipif(not RECORDED.exists(), reason=f"{RECORDED} is not there; see docs/calibration_tests.md")


def sizes(robot):
    return {name: robot.usual_change(name) for name in NAMES}


def driven(robot, seed, steps, noise, samples=100):
    """Steps of half a second of a robot that is driven at random, with white noise on its angles."""
    rng, found, interval = np.random.default_rng(seed), [], 0.5 / samples
    for number in range(steps):
        time = interval * np.arange(samples)
        signal = rng.normal(scale=6.0) + 6.0 * np.sin(2 * np.pi * (time * rng.uniform(1, 3) + rng.uniform()))
        start = np.array([-0.16, -0.2, 0.68, -0.3]) + np.array([0.02, 0.02, 0.05, 0.1]) * rng.normal(size=4)
        step = DrivenStep(number, number % 2, interval, time, time, signal)
        shown, _, _ = show(robot, step, start, ())
        if len(shown) < samples:
            continue
        seen = shown + noise * rng.normal(size=shown.shape)
        found.append(DrivenStep(number, number % 2, interval, seen[:, 0], seen[:, 1], signal))
    return found


@pytest.mark.parametrize("leg", [0, 1])
def test_derivatives_are_those_of_differences(leg):
    robot = ROBOT.with_values({"torque_lag": 0.006, "torque_offset": 0.01, "hip_zero": 0.02})
    step = driven(robot, 5, 2, 0.0)[leg]
    start = np.array([-0.15, -0.2, 0.7, -0.3])
    _, by_start, by_numbers = show(robot, step, start, NAMES)
    by, changes = np.concatenate((by_numbers, by_start), axis=2), []
    for name in NAMES:
        change = 1e-4 * sizes(robot)[name]
        ends = [robot.with_values({name: robot.value(name) + part * change}) for part in (1, -1)]
        changes.append((change, [(end, start) for end in ends]))
    changes += [(1e-6, [(robot, start + moved), (robot, start - moved)]) for moved in 1e-6 * np.eye(4)]
    for place, (change, ends) in enumerate(changes):
        ahead, behind = (show(end, step, begin, ())[0] for end, begin in ends)
        expected = (ahead - behind) / (2 * change)
        np.testing.assert_allclose(by[:, :, place], expected, atol=1e-6 * max(1e-9, np.abs(expected).max()))


def test_a_late_signal_is_the_one_before():
    signal = np.sin(np.linspace(0, 6, 200))
    shifted, slope = late(DrivenStep(0, 0, 0.005, signal, signal, signal), 3.0)
    np.testing.assert_allclose(shifted[3:], signal[:-3], atol=1e-12)
    np.testing.assert_allclose(slope[5:-5], np.gradient(shifted)[5:-5], atol=1e-4)


@pytest.mark.parametrize(("recordings", "samples"), [(4, 70), pytest.param(8, 100, marks=pytest.mark.slow)])
def test_blind_recordings_give_back_the_robot(recordings, samples):
    """Recordings of the model's own, each with another robot: 95 % intervals hold the truth about as often."""
    rng, held, errors = np.random.default_rng(7), [], []
    for seed in range(recordings):
        truth = ROBOT.with_values({
            name: ROBOT.value(name) + (3e-3 if name.endswith("com") else sizes(ROBOT)[name]) * (
                abs(rng.normal()) if ROBOT.value(name) == 0 else rng.normal()) for name in NAMES})
        steps = driven(truth, seed, 24, 1e-3, samples)
        fit = fit_robot(ROBOT, steps, NAMES, sizes(ROBOT), {}, (), 1e-3)
        assert fit.converged
        spread = np.sqrt(np.diag(fit.covariance(np.array([sizes(ROBOT)[name] for name in NAMES]))))
        error = np.array([fit.robot.value(name) - truth.value(name) for name in NAMES]) / spread
        held.append(np.abs(error) < HALF_WIDTH)
        errors.append(error)
        count = sum(len(step.stance) for step in steps)  # of values in each: chi-square, five standard deviations
        assert fit.rms() == pytest.approx((1e-3, 1e-3), rel=5 / np.sqrt(2 * count))
    assert 0.88 < np.mean(held) < 0.99
    assert np.abs(np.mean(errors, axis=0)).max() < 1.0


@pytest.mark.parametrize("seed", [6, 22, 31])
def test_a_fit_comes_to_rest_where_residuals_bend(seed):
    """The start of a step in which the hip comes to rest went too far each time: six of sixty robots were lost."""
    rng = np.random.default_rng([9, seed])
    truth = ROBOT.with_values({
        name: ROBOT.value(name) + (3e-3 if name.endswith("com") else sizes(ROBOT)[name]) * (
            abs(rng.normal()) if ROBOT.value(name) == 0 else rng.normal()) for name in NAMES})
    fit = fit_robot(ROBOT, driven(truth, seed, 12, 1e-3, 70), NAMES, sizes(ROBOT), {}, (), 1e-3)
    assert fit.converged and fit.size < 1.05


def test_changes_of_numbers_that_are_zero_are_of_the_robots_size():
    """A 3 m robot's torques were looked for in millinewton metres: none of its fits came to rest."""
    large, _ = robot_and_sizes((900, 10, 3))
    for name in (*NAMES, "biped.other_leg_inertia"):
        expected = ROBOT.usual_change(name) * factor(ROBOT.unit(name), (900, 10, 3))
        assert large.usual_change(name) == pytest.approx(expected, rel=1e-9), name


def test_a_known_value_pulls_as_much_as_it_is_worth():
    steps = driven(ROBOT, 3, 6, 1e-3)
    known = Known("torque_constant", 0.02, 1e-8)
    fit = fit_robot(ROBOT, steps, NAMES, sizes(ROBOT), {}, (known,), 1e-3)
    assert fit.robot.value("torque_constant") == pytest.approx(0.02, abs=1e-6)


def about(text):
    return Described(yaml_text.parse(text, "robot.yaml"), "robot.yaml")


@pytest.mark.parametrize(("text", "message"), [
    ("motor: 1", "robot.yaml:1: motor: there is no such entry"),
    ("design:\n  legs: rigid\n  hip_mas: {value: 2, unit: kg}", "robot.yaml:3: design.hip_mas: no such key"),
    ("design:\n  legs: rigid\n  hip_mass: {value: 2, unit: g}", "robot.yaml:3: design.hip_mass.unit: g, must be kg"),
    ("design:\n  legs: rigid\n  hip_mass: {value: 2}", "robot.yaml:3: design.hip_mass: expected {value, unit, source}"),
    ("design:\n  legs: rigid\n  foot_com: {value: 2, unit: m}", "robot.yaml:3: design.foot_com: 2.0, must be <"),
    ("known:\n  torque_constant: {value: 0.1, unit: N m, uncertainty: -1}", "robot.yaml:2: known.torque_constant.unc"),
    ("free:\n  - hip_mass\n  - knee", "robot.yaml:3: free.1: knee is no number of the robot"),
    ("design: 3", "robot.yaml:1: design: expected lines of the form key: value"),
    ("free: 3", "robot.yaml:1: free: expected a list of numbers of the robot"),
    ("known: 3", "robot.yaml:1: known: expected names with {value, uncertainty, unit, source}"),
    ("recording: {begun_s: soon}", "robot.yaml:1: recording.begun_s: 'soon', must be a number from 0.02"),
    ("held_out: some", 'robot.yaml:1: held_out: some, must be "every other pair"'),
])
def test_a_wrong_file_is_refused_with_line_and_key(text, message):
    with pytest.raises(WrongOption) as refused:
        setup_of(about(text), BIPED, LEVEL)
    assert str(refused.value).startswith(message)


#: Six steps of 0.3 s with 100 rows a second, as read_steps takes them.
PLAIN = "time_s,stance_angle_rad,hip_angle_rad,motor_signal,outer_pair_stands\n" + "".join(
    f"{row / 100:.2f},{np.sin(row / 9):.6f},{np.cos(row / 9):.6f},0.5,{row // 30 % 2}\n" for row in range(180))


@pytest.mark.parametrize(("sign", "decimal", "encoding", "end"), [
    (",", ".", "utf-8-sig", ""), (";", ",", "utf-8", "\n\n"), ("\t", ",", "utf-16", ";;\n"),
    (", ", ".", "cp1252", ",,,,\n"), ('","', ",", "utf-8", "")])
def test_a_table_as_spreadsheets_and_loggers_write_it(tmp_path, sign, decimal, encoding, end):
    path, expected = tmp_path / "steps.csv", tmp_path / "plain.csv"
    expected.write_text(PLAIN)
    around = '"' * sign.count('"', 1)
    rows = re.sub("(?m)^(.+)$", rf"{around}\1{around}", PLAIN.replace(".", "#").replace(",", sign))
    path.write_text(rows.replace("#", decimal) + end.replace(";", sign), encoding=encoding)
    for step, plain in zip(read_steps(path, {}, 7), read_steps(expected, {}, 7), strict=True):
        np.testing.assert_array_equal(step.angles, plain.angles)
        assert (step.interval, step.leg, step.begins) == (plain.interval, plain.leg, plain.begins)


@pytest.mark.parametrize(("old", "new", "said"), [
    (r"(?s),outer_pair_stands.*", "\n", "steps.csv:1: no column outer_pair_stands for stands"),
    (r"(?s).*", "", "its first line is empty, and names no columns"),
    (r"(?m)^(0.10,[-.0-9]*),[-.0-9]*", r"\1,x", "steps.csv:12: hip_angle_rad: 'x' is no number"),
    (r"(?m)^0.10,[-.0-9]*", "0.10,nan", "steps.csv:12: stance_angle_rad: 'nan' is no number"),
    (",0.5,0", ",0.5,2", "column outer_pair_stands must be 1 while leg 0 stands, else 0"),
    (r"(?m)^(1\.[2-7]\d,[-.0-9]*),[-.0-9]*", r"\1,0.5", "the angle between the legs is the same all .* from 1.27 s on"),
    (r"(?m)^(\d)\.", r"\1", r"rows are 1 s apart, must be at most 0.25 s; .* looks like milliseconds"),
    ("motor_signal", "x" * 200_000, "cannot be read: field larger than field limit"),
])
def test_a_wrong_recording_is_refused_with_line_and_column(tmp_path, old, new, said):
    path = tmp_path / "steps.csv"
    path.write_text(re.sub(old, new, PLAIN))
    with pytest.raises(WrongOption, match=said):
        read_steps(path, {}, 7)


def test_an_encoder_may_count_a_turn_from_zero(tmp_path):
    """It looked like degrees, it said, and to be multiplied."""
    path, expected = tmp_path / "steps.csv", tmp_path / "plain.csv"
    expected.write_text(PLAIN)
    head, *rows = PLAIN.splitlines()
    counted = [",".join([one if place not in (1, 2) else str(float(one) % (2 * np.pi))
                         for place, one in enumerate(row.split(","))]) for row in rows]  # fmt: skip
    path.write_text("\n".join([head, *counted]))
    for step, plain in zip(read_steps(path, {}, 7), read_steps(expected, {}, 7), strict=True):
        np.testing.assert_allclose(step.angles, plain.angles, atol=1e-12)


@pytest.mark.parametrize("rate", [119.0, 400.0])
def test_rows_are_where_their_stamps_have_them(tmp_path, rate):
    """Of 119 Hz stamps of whole milliseconds are 8 or 9 apart: neither is the interval. Lost rows are no shorter step,
    and a recording that was put together at an interruption is cut there."""
    path, steps, long = tmp_path / "steps.csv", 6, round(rate / 2)
    rows = np.arange(steps * long)
    time, stands = rows / rate + np.where(rows > 3.4 * long, 5.0, 0.0), rows // long % 2 == 0
    stance = np.sin(3.0 * time)
    kept = np.random.default_rng(1).random(len(rows)) > 0.03
    path.write_text("time_s,stance_angle_rad,hip_angle_rad,motor_signal,outer_pair_stands\n" + "".join(
        f"{time[row]:.3f},{stance[row]:.9f},{-stance[row]:.9f},0,{int(stands[row])}\n" for row in rows[kept]))
    found = read_steps(path, {}, 5)
    assert len(found) == steps + 1
    for step in found:
        assert step.interval == pytest.approx(1.0 / rate, rel=5e-4)  # stamps are good to a millisecond of 3 s
        seen = step.begins + step.interval * np.arange(len(step.stance))
        np.testing.assert_allclose(-step.stance, np.sin(3.0 * seen), atol=4e-3)  # a millisecond at 3 rad/s
    head, *lines = path.read_text().splitlines()
    path.write_text("\n".join([head, *reversed(lines)]))
    with pytest.raises(WrongOption, match="time does not grow from row to row"):
        read_steps(path, {}, 5)


AUTHORS = """
design:
  legs: rigid
  hip_mass: {value: 2.0, unit: kg}
  hip_gravity_mass: {value: -0.409, unit: kg}
  foot_mass: {value: 0.7, unit: kg}
  leg_length: {value: 0.2778, unit: m}
  foot_radius: {value: 0.0, unit: m}
  foot_com: {value: 0.2276, unit: m}
  other_foot_com: {value: 0.2330, unit: m}
  leg_inertia: {value: 2.6054e-3, unit: kg m^2}
  other_leg_inertia: {value: 2.91883e-3, unit: kg m^2}
  hip_friction: {value: 0.00611, unit: N m}
  hip_damping: {value: 0.00156, unit: N m s/rad}
robot:
  torque_constant: {value: 0.0182, unit: N m}
"""


@needs_real
@pytest.mark.slow
@pytest.mark.parametrize("fitted_first", [True, False])
def test_a_real_robot_is_told_from_half_of_its_steps(fitted_first):
    """Half of the pairs of steps fitted, the other half predicted; the limits are those of a trial by other hands."""
    pairs = [number for number in range(80) if (number // 2) % 2 == (1 if fitted_first else 0)]
    found = calibrated(BIPED, LEVEL, about(AUTHORS + f"held_out: {pairs}"), RECORDED)
    assert len(found.found.residuals) == 40
    assert (np.array([found.found.fit, found.found.predicted]) < [[5.2e-3, 4.0e-3], [18e-3, 13e-3]]).all()
    assert found.fit.robot.value("biped.hip_damping") >= 0.0
    assert any("friction falls with speed" in remark for remark in found.remarks)


@needs_real
def test_steps_of_one_leg_are_refused():
    inner = list(range(1, 80, 2))
    with pytest.raises(NotIdentified, match="leg 1 never stands"):
        calibrated(BIPED, LEVEL, about(AUTHORS + f"held_out: {inner}"), RECORDED)


@needs_real
@pytest.mark.slow
@pytest.mark.parametrize(("old", "new", "words"), [
    ("", "", ""),
    ("0.0182, unit", "-0.0182, unit", "torque_constant comes out with the other sign"),
    ("  leg_inertia: {value: 2.6054e-3, unit: kg m^2}\n  other_leg_inertia: {value: 2.91883e-3, unit: kg m^2}",
     "  leg_inertia: {value: 2.91883e-3, unit: kg m^2}\n  other_leg_inertia: {value: 2.6054e-3, unit: kg m^2}",
     "hip_zero comes out"),
])
def test_what_a_real_robot_contradicts_is_said(old, new, words):
    found = calibrated(BIPED, LEVEL, about(AUTHORS.replace(old, new)), RECORDED)
    assert found.refuted is bool(words)
    assert any(words in remark for remark in found.remarks)
    assert len(found.remarks) == 3 or found.refuted


# --- A driven robot that is followed by its encoders: its states held against those its steps were made from.


OF_STEPS = ("biped.foot_com", "biped.other_foot_com", "torque_constant", "hip_zero", "stance_zero_0")
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
                                free=OF_STEPS)  # fmt: skip
    return FittedEncoders(setup, np.diag(sizes**2), NOISE, 20, (0.0, 1.0), dict(zip(OF_STEPS, sizes, strict=True)),
                          np.full((2, 2), NOISE), np.full((2, 2), 1e-12))  # fmt: skip


def stepped(robot, sizes, rng, scale, leg):
    """A step of half a second of a robot that is not quite this one, and its states."""
    truth = robot.with_values({name: robot.value(name) + size * rng.normal()
                               for name, size in zip(OF_STEPS, sizes, strict=True)})  # fmt: skip
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
        step, states = stepped(robot, sizes, rng, scale, number % 2)
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
    step, _ = stepped(robot, sizes, np.random.default_rng(5), (1, 1, 1), 0)
    part = dataclasses.replace(step, stance=step.stance[:50], between=step.between[:50])
    for one, other in zip(follow(follower, part), follow(follower, step), strict=False):
        assert np.array_equal(one.state, other.state)


def test_what_moves_it_in_no_model_is_told_by_the_steps():
    """Steps of robots that differ, followed as if one were known: the noise that they want makes innovations one."""
    robot, sizes = robot_and_sizes((1, 1, 1))
    rng = np.random.default_rng(7)
    steps = [stepped(robot, 3.0 * sizes, rng, (1, 1, 1), number % 2)[0] for number in range(12)]
    found = with_noise(fitted(robot, 0.0 * sizes), steps)
    assert found.encoded == pytest.approx(np.full((2, 2), NOISE), rel=0.2) and (found.unmodelled > 0.0).all()
    new = np.array([[one.innovation for one in follow(found, step)] for step in steps])
    assert (new**2).mean(axis=(0, 1)) == pytest.approx([1.0, 1.0], abs=0.15)


def test_a_robots_file_gives_it_back_and_goes_with_angles_alone(tmp_path):
    robot, sizes = robot_and_sizes((1, 1, 1))
    kept = fitted(robot, sizes)
    given = {"legs": "rigid", "hip_mass": 2.0}  # with a design of its own in the file of --with it could not be read
    kept = dataclasses.replace(kept, setup=dataclasses.replace(kept.setup, given=given))
    (tmp_path / NAME).write_bytes(kept.content())
    assert FittedEncoders.read(tmp_path).content() == kept.content()
    rng, lines = np.random.default_rng(4), ["time_s,stance_angle_rad,hip_angle_rad,motor_signal,outer_pair_stands"]
    for number in range(2):
        step, _ = stepped(robot, sizes, rng, (1, 1, 1), number)
        lines += [f"{(number * SAMPLES + k) * step.interval},{-step.stance[k]},{-step.turn * step.between[k]},"
                  f"{-step.turn * step.signal[k]},{1 - number}" for k in range(SAMPLES)]  # fmt: skip
    (tmp_path / "steps.csv").write_text("\n".join(lines) + "\n")
    ended = run("follow", "steps.csv", "--as", ".", "--run", "step 1", "--csv", cwd=tmp_path)
    rows = ended.stdout.splitlines()
    assert ended.returncode == 0 and len(rows) == 1 + SAMPLES - encoders.BEGIN
    assert rows[0].startswith("run,time_s,stance_leg,phase,stance_leg_angle_rad,") and rows[1].startswith("step 1,")
    opened = [float(row["leg_opening_angle_rad"]) for row in csv.DictReader(rows)]
    np.testing.assert_allclose(np.abs(opened), np.abs(step.between[encoders.BEGIN :]), atol=0.02)
    other = run("follow", "lab.sqlite", "--as", ".", cwd=tmp_path)
    assert other.returncode == 2 and "fitted to recordings of the other kind" in other.stderr
    (tmp_path / NAME).write_bytes(kept.content().replace(b"0.018", b"0.019"))
    with pytest.raises(WrongOption, match="was changed"):
        FittedEncoders.read(tmp_path)


def test_a_robot_of_angles_is_left_with_its_errors_and_a_twin_of_its_own():
    """They were left out, so that every answer took what was fitted for exact; the twin was of the paper's parts."""
    robot, sizes = robot_and_sizes((1, 1, 1))
    kept = fitted(robot, sizes)
    covariance = kept.covariance + np.outer(sizes, sizes) * (0.3 - 0.3 * np.eye(len(sizes)))
    given = {"legs": "rigid", "hip_gravity_mass": -0.4}
    left = parameters_left_of_angles(dataclasses.replace(
        kept, covariance=covariance, setup=dataclasses.replace(kept.setup, given=given)))  # fmt: skip
    for name, size in zip(OF_STEPS[:2], sizes, strict=False):
        assert left.pop(name) == {"value": robot.value(name), "uncertainty": pytest.approx(HALF_WIDTH * size),
                                  "unit": "m"}  # fmt: skip
    assert left == {
        "biped.legs": {"value": "rigid", "unit": "-"}, "biped.hip_gravity_mass": {"value": -0.4, "unit": "kg"},
        "twin.inertia": "planar", "biped.correlations": {"rows": [
            {"one": OF_STEPS[0], "other": OF_STEPS[1], "correlation": pytest.approx(0.3)}]}}  # fmt: skip


@needs_real
@pytest.mark.slow
def test_a_real_robots_other_steps_are_followed():
    """Innovations are as large as said; they are white in most steps, and where not the model lacks forces."""
    result = calibrated(BIPED, LEVEL, about(AUTHORS + "held_out: every other pair"), RECORDED)
    _, out = result.setup.split(read_steps(RECORDED, {}, 7))
    new = [np.array([one.innovation for one in follow(result.robot, step)]) for step in out]
    assert np.mean([(one**2).mean(axis=0) for one in new], axis=0) == pytest.approx([1.0, 1.0], abs=0.2)
    white = np.mean([[whiteness(column) > 0.01 for column in one.T] for one in new], axis=0)
    assert (white > [0.55, 0.75]).all()
