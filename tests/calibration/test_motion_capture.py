"""Angles from markers: a file that is written here is read back as what was put into it."""

import io
import sys

import numpy as np
import pytest

from stages.biped.question import WrongOption
from stages.calibration.angles.recording import MOST_HIDDEN, captured, read_steps

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


def written(path, places, hidden=()):
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
    found = captured(written(tmp_path / "walk.c3d", markers(up)), {"up": up})
    np.testing.assert_allclose(found["time"], TIME, atol=1e-12)
    np.testing.assert_allclose(found["between"], ANGLES[1] - ANGLES[0], atol=1e-6)
    # at the turn, where both legs are as slow, the first frame may count either way
    away = np.abs(TIME - 0.6) > 0.02
    away &= (TIME > 0.02) & (TIME[-1] - 0.02 > TIME)
    np.testing.assert_array_equal(found["stands"][away], FIRST[away].astype(float))
    np.testing.assert_allclose(found["stance"][away], np.where(FIRST, *ANGLES)[away], atol=1e-6)
    np.testing.assert_allclose(found["signal"], 0.01 * np.arange(FRAMES), atol=1e-3)


def test_steps_are_cut_as_those_of_encoders(tmp_path):
    steps = read_steps(written(tmp_path / "walk.c3d", markers()), {}, 7)
    long = [(step.leg, step.interval) for step in steps if len(step.stance) > 60]
    assert long == [(0, pytest.approx(1 / RATE)), (1, pytest.approx(1 / RATE))]


def test_a_marker_may_be_hidden_for_some_frames_only(tmp_path):
    places = markers()
    whole = captured(written(tmp_path / "whole.c3d", places), {})
    some = captured(written(tmp_path / "some.c3d", places, range(50, 50 + MOST_HIDDEN)), {})
    assert 0 < np.abs(some["between"] - whole["between"]).max() < 1e-3
    with pytest.raises(WrongOption, match=f"LEG0 is hidden for {MOST_HIDDEN + 1} frames"):
        captured(written(tmp_path / "long.c3d", places, range(50, 51 + MOST_HIDDEN)), {})


def test_what_is_wrong_is_said(tmp_path):
    written(tmp_path / "walk.c3d", markers())
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
