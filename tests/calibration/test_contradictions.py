"""Recordings of angles: what contradicts the file that came with them is said, and markers are read back as written."""

import dataclasses
import io
import math
import sys
from unittest.mock import ANY

import numpy as np
import pytest

from stages.biped.question import WrongOption
from stages.calibration.angles.fit import HeldOut, fit_robot
from stages.calibration.angles.recording import MOST_HIDDEN, bridged, captured, read_steps
from stages.calibration.angles.robot import FARTHEST_ZERO, setup_of
from stages.calibration.angles.same import FittedEncoders
from stages.calibration.estimation.least_squares import Known, NotIdentified
from stages.calibration.intervals.model_error import correlation_length
from stages.calibration.reports.angle_report import (
    Calibrated,
    answered,
    calibrated,
    contradictions,
    refuted,
)
from tests.calibration.runs import BIPED
from tests.calibration.test_angles import LEVEL, ROBOT, about, driven, sizes

LOOKED_FOR = ("biped.foot_com", "torque_constant", "hip_zero")
HEAD = "time_s,stance_angle_rad,hip_angle_rad,motor_signal,outer_pair_stands"


def setup(text="", known=()):
    plain = setup_of(about(text), BIPED, LEVEL)
    return dataclasses.replace(plain, robot=ROBOT, free=LOOKED_FOR, known=(*plain.known, *known))


def said(truth, known=(), turned=1.0, text="", mirrored=1.0):
    """Contradictions of a robot's steps, fitted from `ROBOT`."""
    steps = [dataclasses.replace(one, stance=mirrored * one.stance, between=mirrored * turned * one.between,
                                 signal=mirrored * one.signal) for one in driven(truth, 5, 4, 1e-3, 60)]  # fmt: skip
    asked = setup(text, known)
    fit = fit_robot(ROBOT, steps, LOOKED_FOR, sizes(ROBOT), {}, asked.known, 1e-3)
    sd = dict(zip(LOOKED_FOR, np.sqrt(np.diag(fit.covariance(np.array([sizes(ROBOT)[n] for n in LOOKED_FOR])))),
                  strict=True))  # fmt: skip
    return contradictions(asked, fit, sd, steps)


KNOWN, ZERO = "torque_constant", "robot: {hip_zero: {value: 0.0, unit: rad}}"
#: What is changed of the robot, said of it and turned; how each contradiction begins and its standard errors; whether
#: that refutes the robot.
SAID = {
    "as described": ({}, {"known": (Known(KNOWN, 0.018, 1e-3),)}, [], False),
    "a known value": ({}, {"known": (Known(KNOWN, 0.018 + 5e-4, 1e-4),)},
                      [("torque_constant is known as", pytest.approx(5.0, abs=1.0))], False),
    "a zero three degrees off": ({"hip_zero": math.radians(3.0)}, {}, [("hip_zero comes out +3.0 degrees off", 0.0)],
                                 False),
    "a zero that may be": ({"hip_zero": math.radians(1.5)}, {}, [], False),
    "a zero that the file gives": ({"hip_zero": math.radians(3.0)}, {"text": ZERO},
                                   [("hip_zero is known as 0", pytest.approx(4.5, abs=0.1))], False),
    "all signs turned": ({}, {"mirrored": -1.0}, [("the stance angle grows through a step", 0.0)], False),
    "a turned sign": ({KNOWN: -0.018}, {}, [("torque_constant comes out with the other sign", ANY)], True),
}  # fmt: skip


@pytest.mark.parametrize(("changed", "given", "expected", "refutes"), SAID.values(), ids=SAID)
def test_what_a_recording_contradicts_is_said_by_how_much(changed, given, expected, refutes):
    """A known value that pulls the fit to itself is tested as if it had not: z is the difference of two estimates."""
    found = said(ROBOT.with_values(changed), **given)
    assert [(one[0][: len(words)], one[1]) for one, (words, _) in zip(found, expected, strict=True)] == expected
    assert refuted(found) is refutes


def test_two_contradictions_refute_a_robot_or_one_beyond_doubt():
    one = ("known otherwise", 5.0)
    assert [refuted(found) for found in ([], [one], [one, one], [("", 10.1)])] == [False, False, True, True]
    assert setup(ZERO).known == (Known("hip_zero", 0.0, FARTHEST_ZERO / 3),)


def test_a_column_that_is_turned_shows_where_both_feet_are_on_the_ground():
    assert any("one of the columns" in one[0] and "is turned" in one[0] for one in said(ROBOT, turned=-1.0))


def written(path, steps, turn=1.0):
    """Steps as a recording; `turn` its angles' unit."""
    rows, time = [HEAD], 0.0
    for one in steps:
        for stance, between, signal in zip(one.stance, one.between, one.signal, strict=True):
            rows.append(f"{time:.4f},{-turn * stance!r},{-turn * one.turn * between!r},{-one.turn * signal!r},"
                        f"{int(one.leg == 0)}")  # fmt: skip
            time += one.interval
    path.write_text("\n".join(rows).replace("np.float64(", "").replace(")", "") + "\n")
    return path


@pytest.mark.parametrize("count", [0.0, 2e-3])
def test_values_that_an_encoder_holds_are_no_samples(tmp_path, count):
    """An encoder at half the rate of the rows: the motor's torque came 2 ms late, by twelve standard errors."""
    truth = ROBOT.with_values({"torque_lag": 0.006})
    steps = driven(truth, 5, 6, 1e-3)
    seen = [one.between if not count else count * np.rint(one.between / count) for one in steps]
    held = [dataclasses.replace(one, between=np.repeat(each[::2], 2)) for one, each in zip(steps, seen, strict=True)]
    whole, found = (read_steps(written(tmp_path / "steps.csv", each), {}, 3) for each in (steps, held))
    assert all(one.weights.all() for one in whole)
    assert all(0.4 < one.weights[:, 1].mean() < 0.6 for one in found)
    fit = fit_robot(ROBOT, found, ("torque_lag", *LOOKED_FOR), {**sizes(ROBOT), "torque_lag": 3e-3}, {}, (), 1e-3)
    sd = math.sqrt(fit.covariance(np.array([3e-3, *(sizes(ROBOT)[name] for name in LOOKED_FOR)]))[0, 0])
    assert abs(fit.robot.value("torque_lag") - 0.006) < 3.0 * sd


def test_angles_in_degrees_are_refused_by_column_and_unit(tmp_path):
    steps = driven(ROBOT, 3, 2, 0.0, 40)
    with pytest.raises(WrongOption, match=r"column stance_angle_rad reaches .* degrees, so multiply it by pi / 180"):
        read_steps(written(tmp_path / "steps.csv", steps, 180 / math.pi), {}, 2)
    with pytest.raises(NotIdentified, match="columns' units"):
        fit_robot(ROBOT.with_values({"stance_zero_0": math.inf}), steps, (), {}, {}, (), 1e-3)


def test_outliers_are_bridged_and_a_curve_without_any_is_left_alone():
    time = np.arange(100) * 0.005
    clean = 0.3 * np.sin(6.0 * time) + 0.2 * time**2
    noisy = clean + 1e-4 * np.random.default_rng(2).normal(size=100)
    same, none = bridged(noisy)
    counted = np.radians(np.round(np.degrees(0.3 * np.sin(4.0 * time))))
    np.testing.assert_array_equal(bridged(counted)[0], counted)  # every other one was taken for an outlier
    np.testing.assert_array_equal(same, noisy)
    spoiled = noisy.copy()
    spoiled[[0, 17, 18, 60, 99]] += np.array([0.2, -0.3, 0.1, 0.05, -0.2])
    mended, count = bridged(spoiled)
    assert (none, count) == (0, 5)
    np.testing.assert_allclose(mended, clean, atol=2e-3)


def test_samples_count_as_what_they_are_worth(tmp_path):
    """With residuals that hang together a known value weighs against as many samples as are worth one."""
    rng, steps = np.random.default_rng(4), driven(ROBOT, 3, 4, 0.0, 60)
    drifts = [np.convolve(rng.normal(size=79), np.full(20, 1e-3), mode="valid") for _ in steps]
    recorded = [dataclasses.replace(one, between=one.between + drift)
                for one, drift in zip(steps, drifts, strict=True)]  # fmt: skip
    path = written(tmp_path / "steps.csv", recorded)
    text = "held_out: []\nfree: [torque_constant]\nrecording: {left_out_samples: 0}\ndesign: {legs: rigid}"
    told = calibrated(ROBOT.design.biped, LEVEL, about(text), path)
    residuals = list(told.fit.residuals.values())
    length, rms = correlation_length(residuals), math.sqrt(np.mean(np.concatenate(residuals) ** 2))
    assert length > 2.0
    assert told.fit.noise == pytest.approx(rms * math.sqrt(length), rel=0.05)


@pytest.mark.parametrize("converged", [True, False])
def test_a_fit_that_is_not_at_rest_has_no_intervals_and_ends_with_3(converged):
    steps = driven(ROBOT, 5, 4, 1e-3, 60)
    fit = dataclasses.replace(fit_robot(ROBOT, steps, LOOKED_FOR, sizes(ROBOT), {}, (), 1e-3), converged=converged)
    tell = HeldOut((1e-3, 1e-3), (1e-3, 1e-3), fit.residuals)
    robot = FittedEncoders.of(setup(), fit) if converged else None
    answer = answered(Calibrated(setup(), fit, tell, tell, dict.fromkeys(LOOKED_FOR, 1e-3), [], not converged, robot))
    assert answer.no is not converged
    assert any("intervals" in title for title, _, _ in answer.tables) is converged
    assert all((row["sd"] is not None) is converged for row in answer.plain["numbers"].values())
    assert bool(answer.parameters) is converged


# --- Angles from markers: a file that is written here is read back as what was put into it.


RATE, LENGTH, FRAMES = 200.0, 400.0, 240
TIME = np.arange(FRAMES) / RATE
#: Angles [rad], foot ahead positive; leg 0 stands through the first half.
ANGLES = 0.2 * np.cos(np.pi * TIME / 0.6), -0.2 * np.cos(np.pi * TIME / 0.6)
FIRST = TIME < 0.6


def markers(up="z"):
    """Places (frames, 3, 3) [mm] of hip and feet of a compass that walks along x: the standing foot stays."""
    standing = np.where(FIRST, 0.0, 2 * LENGTH * np.sin(0.2))
    hip = standing - LENGTH * np.sin(np.where(FIRST, *ANGLES))
    lengths, angles = LENGTH * np.array([[0.0], [1.0], [1.0]]), np.array([0.0 * TIME, *ANGLES])
    along, height = hip + lengths * np.sin(angles), 1000.0 - lengths * np.cos(angles)
    across = np.zeros_like(along)
    return np.stack((along, height, across) if up == "y" else (along, across, height), axis=2).transpose(1, 0, 2)


def filmed(path, places, hidden=()):
    c3d = pytest.importorskip("c3d", reason="c3d is not installed: pip install 'bipedstudy[files]'")
    writer = c3d.Writer(point_rate=RATE, analog_rate=2 * RATE, point_units="mm")
    for frame in range(FRAMES):
        points = np.zeros((3, 5), dtype=np.float32)
        points[:, :3] = places[frame]
        points[1, 3] = -1.0 if frame in hidden else 0.0
        signal = np.full((1, 2), 0.01 * frame, dtype=np.float32)
        writer.add_frames([(points, signal)])
    writer.set_point_labels(["HIP", "LEG0", "LEG1"])
    writer.set_analog_labels(["MOTOR"])
    held = io.BytesIO()
    writer.write(held)
    path.write_bytes(held.getvalue())
    return path


@pytest.mark.parametrize("up", ["z", "y"])
def test_angles_and_standing_legs_are_those_of_the_walk(tmp_path, up):
    found = captured(filmed(tmp_path / "walk.c3d", markers(up)), {"up": up})
    np.testing.assert_allclose(found["time"], TIME, atol=1e-12)
    np.testing.assert_allclose(found["between"], ANGLES[1] - ANGLES[0], atol=1e-6)
    # at the turn, where both legs are as slow, the first frame may count either way
    away = np.abs(TIME - 0.6) > 0.02
    away &= (TIME > 0.02) & (TIME[-1] - 0.02 > TIME)
    np.testing.assert_array_equal(found["stands"][away], FIRST[away].astype(float))
    np.testing.assert_allclose(found["stance"][away], np.where(FIRST, *ANGLES)[away], atol=1e-6)
    np.testing.assert_allclose(found["signal"], 0.01 * np.arange(FRAMES), atol=1e-3)


def test_steps_are_cut_as_those_of_encoders(tmp_path):
    steps = read_steps(filmed(tmp_path / "walk.c3d", markers()), {}, 7)
    long = [(step.leg, step.interval) for step in steps if len(step.stance) > 60]
    assert long == [(0, pytest.approx(1 / RATE)), (1, pytest.approx(1 / RATE))]


@pytest.mark.parametrize("noise", [0.3, 1.0, 3.0])
def test_noisy_markers_cut_no_step_in_pieces(noise, tmp_path):
    """Noise of 1 mm at 200 Hz is .14 m/s of a foot's speed by two frames: steps were cut where it took turns."""
    for seed in range(5):
        places = markers() + np.random.default_rng(seed).normal(scale=noise, size=(FRAMES, 3, 3))
        stands = captured(filmed(tmp_path / f"{seed}.c3d", places), {})["stands"] > 0.5
        assert stands[0] and not stands[-1]
        (change,) = np.flatnonzero(np.diff(stands))
        assert abs(TIME[change] - 0.6) < 0.05


def test_a_marker_may_be_hidden_for_some_frames_only(tmp_path):
    places = markers()
    whole = captured(filmed(tmp_path / "whole.c3d", places), {})
    some = captured(filmed(tmp_path / "some.c3d", places, range(50, 50 + MOST_HIDDEN)), {})
    assert 0 < np.abs(some["between"] - whole["between"]).max() < 1e-3
    with pytest.raises(WrongOption, match=f"LEG0 is hidden for {MOST_HIDDEN + 1} frames"):
        captured(filmed(tmp_path / "long.c3d", places, range(50, 51 + MOST_HIDDEN)), {})


def test_what_is_wrong_is_said(tmp_path):
    filmed(tmp_path / "walk.c3d", markers())
    (tmp_path / "none.c3d").write_bytes(b"nothing of the kind")
    for name, said, words in (("walk", {"hip": "PELVIS"}, "no marker PELVIS for hip; there are HIP, LEG0, LEG1"),
                              ("walk", {"up": "w"}, "up is w, must be one of x, y, z"),
                              ("none", {}, "none.c3d: is no C3D file"),
                              ("gone", {}, "gone.c3d: cannot be read: No such file")):  # fmt: skip
        with pytest.raises(WrongOption, match=words):
            captured(tmp_path / f"{name}.c3d", said)


def test_without_the_library_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "c3d", None)
    (tmp_path / "walk.c3d").write_bytes(b"")
    with pytest.raises(WrongOption, match=r"c3d is needed: pip install 'bipedstudy\[files\]'"):
        captured(tmp_path / "walk.c3d", {})
