"""Angles of a compass walker from motion capture: markers at the hip and at both feet, from a C3D file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from stages.analytic.model.walker import Vector
from stages.biped.question import WrongOption
from stages.imu.errors import SourceRefused
from stages.imu.sources.files.optional import library

#: Labels of the markers and of the analog channel with the motor's signal, and the axes of the laboratory, where a file
#: does not say others. Axes are x, y, z, or -x, -y, -z; "up" is normal to the ground.
MARKERS = {"hip": "HIP", "leg_0": "LEG0", "leg_1": "LEG1", "signal": "MOTOR", "forward": "x", "up": "z"}
AXES = ("x", "y", "z", "-x", "-y", "-z")
#: Frames in a row that a marker may be hidden for: they are bridged by a straight line.
MOST_HIDDEN = 3


def captured(path: Path, markers: Mapping[str, str]) -> dict[str, Vector]:
    """Time [s], angles [rad], signal, and 1 while leg 0 stands, (n,) each, as the CSV file of encoders has them.

    A leg's angle is that of the line from the hip's marker to its foot's from "up", foot ahead positive; the foot that
    is slower along the ground stands. Without a channel of the signal there is none. Raises WrongOption.
    """
    named = {**MARKERS, **markers}
    for axis in ("forward", "up"):
        if named[axis] not in AXES:
            raise WrongOption(f"{path}: {axis} is {named[axis]}, must be one of {', '.join(AXES)}")
    rate, labels, points, channels, analog = _read(path)
    places = {}
    for marker in ("hip", "leg_0", "leg_1"):
        if named[marker] not in labels:
            raise WrongOption(f"{path}: no marker {named[marker]} for {marker}; there are {', '.join(labels)}")
        places[marker] = _seen(points[:, labels.index(named[marker])], path, named[marker])
    forward, up = ({name: _along(place, named[axis]) for name, place in places.items()} for axis in ("forward", "up"))
    angles = [np.arctan2(forward[leg] - forward["hip"], up["hip"] - up[leg]) for leg in ("leg_0", "leg_1")]
    speeds = [np.abs(np.gradient(forward[leg])) for leg in ("leg_0", "leg_1")]
    stands = speeds[0] < speeds[1]
    count = len(angles[0])
    signal = analog[:, channels.index(named["signal"])] if named["signal"] in channels else np.zeros(count)
    if count < 8:
        raise WrongOption(f"{path}: has {count} frames, at least 8 are needed")
    return {"time": np.arange(count) / rate, "stance": np.where(stands, angles[0], angles[1]),
            "between": angles[1] - angles[0], "signal": signal, "stands": stands.astype(float)}  # fmt: skip


def _read(path: Path) -> tuple[float, list[str], np.ndarray, list[str], np.ndarray]:
    """Frames a second, labels of markers, their places and residuals (n, m, 4), labels of channels, their means over
    each frame (n, c). Raises WrongOption."""
    try:
        c3d: Any = library("c3d", "files", path)
        with path.open("rb") as handle:
            reader = c3d.Reader(handle)
            frames = [(points[:, :4], analog.mean(axis=1) if analog.size else np.zeros(0))
                      for _, points, analog in reader.read_frames()]
            labels, channels = ([str(one).strip() for one in given] for given in
                                (reader.point_labels, reader.analog_labels if reader.analog_used else ()))
            rate = float(reader.point_rate)
    except SourceRefused as reason:
        raise WrongOption(str(reason)) from None
    except OSError as error:
        raise WrongOption(f"{path}: cannot be read: {error.strerror}") from None
    except Exception as error:  # a library's own: it raises assertions, struct errors and warnings of many kinds
        raise WrongOption(f"{path}: is no C3D file that can be read: {str(error) or type(error).__name__}") from None
    if not frames or not rate > 0:
        raise WrongOption(f"{path}: has no frames")
    return rate, labels, np.array([one for one, _ in frames]), channels, np.array([one for _, one in frames])


def _seen(track: np.ndarray, path: Path, label: str) -> np.ndarray:
    """Places (n, 3) of a marker, with short gaps bridged. Raises WrongOption where it is hidden for longer."""
    hidden = (track[:, 3] < 0) | ~np.isfinite(track).all(axis=1)
    longest = max((len(run) for run in "".join("x" if one else " " for one in hidden).split()), default=0)
    if longest > MOST_HIDDEN:
        raise WrongOption(f"{path}: marker {label} is hidden for {longest} frames in a row, at most {MOST_HIDDEN}")
    rows = np.arange(len(track))
    return np.column_stack([np.interp(rows, rows[~hidden], track[~hidden, axis]) for axis in range(3)])


def _along(places: np.ndarray, axis: str) -> Vector:
    """Places along an axis (n,)."""
    column = places[:, "xyz".index(axis[-1])]
    return np.asarray(-column if axis.startswith("-") else column, dtype=float)
