"""Steps of a driven compass walker as its encoders saw them, from a CSV file, or markers at hip and feet, from C3D."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np
from scipy.ndimage import gaussian_filter1d

from stages.analytic.model.walker import Vector
from stages.biped.question import WrongOption, at_hand, refuse
from stages.imu.sources.cells import number
from stages.imu.sources.opening import SourceRefused, library
from stages.imu.sources.text_table import encoding_of

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

#: What a column holds, and the names that are looked for where none are given.
COLUMNS = {
    "time": "time_s",
    "stance": "stance_angle_rad",
    "between": "hip_angle_rad",
    "signal": "motor_signal",
    "stands": "outer_pair_stands",
}
#: Labels of the markers and of the analog channel with the motor's signal, and the axes of the laboratory, where a file
#: does not say others. Axes are x, y, z, or -x, -y, -z; "up" is normal to the ground.
MARKERS = {"hip": "HIP", "leg_0": "LEG0", "leg_1": "LEG1", "signal": "MOTOR", "forward": "x", "up": "z"}
AXES = ("x", "y", "z", "-x", "-y", "-z")
#: Frames in a row that a marker may be hidden for, and rows that may be lost: they are bridged by a straight line.
MOST_HIDDEN = 3
#: Samples that a step needs, and the longest time between two [s]: with it a step would last two seconds.
FEWEST, SLOWEST = 9, 0.25
#: What nine of ten samples of an angle stay below while a robot walks [rad].
LARGEST = {"stance": math.pi / 2, "between": math.pi}
#: A sample is an outlier so many robust standard deviations away from what its neighbours on both sides say, of which
#: the farthest are so many samples away. Curves are bent here and there ten times as much as usual.
OUTLYING, REACH = 15.0, 3
#: Share of rows that repeat the one before from which an encoder's values are held.
HELD = 0.2
#: Noise of a foot's speed, and by how much one foot is clearly slower, in what nine of ten speeds stay below.
NOISY, CLEARLY = 0.05, 0.3
#: Standard deviations of Gaussian noise in its median absolute deviation.
SIGMAS = 1.4826


@dataclass(frozen=True)
class DrivenStep:
    """One single stance. Samples `interval` [s] apart, (n,) each, those that ring from an impact left out.

    `stance` and `between` [rad]: angle of the standing leg, hip ahead positive, and that angle plus the swing leg's,
    foot ahead positive. `signal` is what the motor's torque on `between` is a multiple of. `leg` stands, 0 or 1; signs
    turn with it, so `turn` is 1 or -1 for what keeps its sign in the recording. `outliers` were bridged. Of the angles
    those are `new` (n, 2) that no row repeats and none was interpolated for; without it all are.
    """

    number: int
    leg: int
    interval: float
    stance: Vector
    between: Vector
    signal: Vector
    outliers: int = 0
    begins: float = 0.0
    new: np.ndarray | None = None

    @property
    def turn(self) -> float:
        """1 while leg 0 stands, -1 while leg 1 does."""
        return 1.0 if self.leg == 0 else -1.0

    @cached_property
    def angles(self) -> np.ndarray:
        """Stance angle and angle between the legs, (n, 2)."""
        return np.column_stack([self.stance, self.between])

    @cached_property
    def weights(self) -> np.ndarray:
        """What the angles count, (n, 2): one, and nothing where they are not new."""
        return np.ones(self.angles.shape) if self.new is None else self.new[: len(self.stance)].astype(float)

    @cached_property
    def spline(self) -> CubicSpline:
        """The signal as a cubic spline of the sample's number."""
        from scipy.interpolate import CubicSpline

        return CubicSpline(np.arange(len(self.signal)), self.signal)


def read_steps(
    path: Path, columns: Mapping[str, str], left_out: int, markers: Mapping[str, str] | None = None,
    reading: Callable[..., Iterator[Any]] = at_hand,
) -> tuple[DrivenStep, ...]:  # fmt: skip
    """The steps of a file, cut where the standing leg changes or time jumps, `left_out` samples shorter at both ends.

    In the file the stance angle is positive with the foot ahead, the angle between the legs is that of leg 1 before leg
    0, and 1 marks that leg 0 stands; a C3D file of motion capture has `markers` instead. Raises WrongOption with file,
    line and column.
    """
    (table,) = reading(tables, path, dict(columns), dict(markers or {}))
    interval, places = sampled(table["time"], path)
    stands = table["stands"] > 0.5
    jumps = (np.diff(places) < 1) | (np.diff(places) > MOST_HIDDEN + 1)
    cuts = (np.diff(stands) != 0) | jumps
    edges = [0, *(np.flatnonzero(cuts) + 1), len(stands)]
    new = {what: fresh(table[what], np.cumsum(np.append(0, cuts))) for what in LARGEST}
    steps = list[DrivenStep]()
    for first, last in pairwise(edges):
        at = places[first:last] - places[first]
        rows = {what: at >= 0 if one[first:last].sum() < 2 else one[first:last] for what, one in new.items()}
        grid = np.arange(max(left_out, *(at[one][0] for one in rows.values())),
                         min(at[-1] - left_out, *(at[one][-1] for one in rows.values())) + 1)  # fmt: skip
        if len(grid) < FEWEST:
            continue
        leg, turn = (0, 1.0) if stands[first] else (1, -1.0)
        stance, between = (np.interp(grid, at[one], table[what][first:last][one]) for what, one in rows.items())
        signal = np.interp(grid, at, table["signal"][first:last])
        begins = float(table["time"][first] + grid[0] * interval)
        shown = {"the stance angle": stance, "the angle between the legs": between}
        refuse(*((float(np.ptp(angle)) == 0.0, f"{path}: {what} is the same all through the step from {begins:.4g} s "
                  "on: did its encoder stop, or the robot?") for what, angle in shown.items()))  # fmt: skip
        (stance, first_odd), (between, odd) = bridged(stance), bridged(between)
        steps.append(DrivenStep(len(steps), leg, interval, -stance, -turn * between, -turn * signal, first_odd + odd,
                                begins, np.column_stack([np.isin(grid, at[one]) for one in rows.values()])))
    refuse((not steps, f"{path}: no step is longer than the {2 * left_out} samples that are left out"))
    return tuple(steps)


def sampled(time: Vector, path: Path) -> tuple[float, np.ndarray]:
    """The interval between samples [s] of rows at times (n,) [s], and the sample that each row is (n,).

    Stamps may be rounded, so that no two of them show the interval: 8 and 9 ms of 119 Hz, 2 and 3 ms of 400 Hz. Raises
    WrongOption.
    """
    steps = np.diff(time)
    middle = float(np.median(steps))
    refuse((not middle > 0.0, f"{path}: time does not grow from row to row"))
    between = np.rint(steps / steps[(steps > 0.0) & (steps < 1.75 * middle)].mean()).astype(int)
    close = (between >= 1) & (between <= MOST_HIDDEN + 1)
    interval = float(steps[close].sum() / between[close].sum())
    refuse((interval > SLOWEST, f"{path}: rows are {interval:.3g} s apart, must be at most {SLOWEST} s; the time is in "
            "seconds, and this looks like milliseconds"))  # fmt: skip
    return interval, np.concatenate([[0], np.cumsum(between)])


def fresh(values: Vector, step: np.ndarray) -> np.ndarray:
    """Which of an encoder's values (n,) are new; all, unless it is read less often than rows are written.

    Then more than a fifth of the rows repeat the one before, also where it moves two of its counts a row within a
    `step` (n,): by noise one in eight does at most.
    """
    changes, inner = np.abs(np.diff(values, prepend=np.nan)), slice(REACH, -REACH)
    count = changes[changes > 0.0].min(initial=math.inf)
    moves = np.abs(values[2 * REACH :] - values[: -2 * REACH]) > 4 * REACH * count
    moves &= step[2 * REACH :] == step[: -2 * REACH]
    held = np.count_nonzero(moves & (changes[inner] == 0.0)) > HELD * np.count_nonzero(moves)
    return np.asarray((changes != 0.0) | (not held))


def tables(path: Path, columns: Mapping[str, str], markers: Mapping[str, str]) -> Iterator[dict[str, Vector]]:
    """The table of a file, as another process hands it over. Raises WrongOption."""
    of_markers = path.suffix.lower() == ".c3d"
    yield captured(path, markers) if of_markers else _table(path, {**COLUMNS, **columns})


def bridged(values: Vector) -> tuple[Vector, int]:
    """Samples (n,) of one step with outliers replaced by what their neighbours say, and how many there were.

    Each is compared with the median of what pairs of neighbours say (Hampel's identifier on what is left of a curve);
    of those that are close together the farthest off goes first. No outlier is within two counts of an encoder.
    """
    steps = np.abs(np.diff(values))
    count = 2.0 * steps[steps > 0.0].min(initial=math.inf)
    rows, odd, found = np.arange(len(values)), np.zeros(len(values), dtype=bool), values
    while True:
        off = np.where(odd, 0.0, np.abs(found - _by_neighbours(found)))
        worst = np.lib.stride_tricks.sliding_window_view(np.pad(off, REACH), 2 * REACH + 1).max(axis=1)
        more = (off > max(OUTLYING * SIGMAS * np.median(off), count)) & (off == worst)
        if not more.any() or 2 * (odd | more).sum() > len(values):
            return found, int(odd.sum())
        odd |= more
        found = np.interp(rows, rows[~odd], values[~odd])
        found[odd] = _by_neighbours(found)[odd]


def _by_neighbours(values: Vector) -> Vector:
    """The median of the middles of pairs of neighbours (n,); near an end, of lines through two on its inner side."""
    n, said = len(values), np.full((3 * REACH, len(values)), np.nan)
    for k in range(1, REACH + 1):
        said[k - 1, k : n - k] = 0.5 * (values[: n - 2 * k] + values[2 * k :])
        said[REACH + k - 1, :REACH] = 2 * values[k : REACH + k] - values[2 * k : REACH + 2 * k]
        said[2 * REACH + k - 1, n - REACH :] = 2 * values[n - REACH - k : n - k] - values[n - REACH - 2 * k : n - 2 * k]
    return np.asarray(np.nanmedian(said, axis=0))


def _table(path: Path, columns: Mapping[str, str]) -> dict[str, Vector]:
    """The columns that are needed, by what they hold. Raises WrongOption."""
    try:
        with path.open(encoding=encoding_of(path), errors="replace", newline="") as file:
            rows = list(_numbers(file, path, columns))
    except (OSError, csv.Error) as error:
        raise WrongOption(f"{path}: cannot be read: {getattr(error, 'strerror', error)}") from None
    refuse((len(rows) < 8, f"{path}: has {len(rows)} rows, at least 8 are needed"))
    table = dict(zip(columns, np.array(rows).T, strict=True))
    for what in LARGEST:
        shown = table[what]
        if shown.min() >= 0.0 and shown.max() <= 2.0 * math.pi:  # an encoder that counts on to a turn, and from 0 again
            table[what] = np.where(shown > math.pi, shown - 2.0 * math.pi, shown)
    usual = {what: float(np.quantile(np.abs(table[what]), 0.9)) for what in LARGEST}
    refuse(*((usual[what] > largest, f"{path}: column {columns[what]} reaches {usual[what]:.3g}: angles are in rad, "
              f"and this one stays below {largest:.3g} rad in a walk; it looks like degrees, so multiply it by "
              "pi / 180") for what, largest in LARGEST.items()),
           (not np.isin(table["stands"], (0, 1)).all(),
            f"{path}: column {columns['stands']} must be 1 while leg 0 stands, else 0"))  # fmt: skip
    return table


def _numbers(file: TextIO, path: Path, columns: Mapping[str, str]) -> Iterator[list[float]]:
    """The rows of a CSV file, in the order of `columns`. Raises WrongOption with line and column.

    The sign between columns is the one that stands most often among their names. Numbers may have decimal commas,
    quoted where that sign is one.
    """
    first = file.readline()
    delimiter = max(",;\t", key=first.count)
    rows = csv.reader(chain([first], file), delimiter=delimiter)
    head = [name.strip() for name in next(rows, [])]
    refuse((not head, f"{path}: its first line is empty, and names no columns"),
           *((name not in head, f"{path}:1: no column {name} for {what}; there are {', '.join(head)}")
             for what, name in columns.items()))  # fmt: skip
    places = [head.index(name) for name in columns.values()]
    for row in filter(any, rows):
        found = []
        for name, place in zip(columns.values(), places, strict=True):
            cell = row[place] if place < len(row) else "nothing"
            value = number(cell.replace(",", "."))
            refuse((not math.isfinite(value), f"{path}:{rows.line_num}: {name}: {cell!r} is no number"))
            found.append(value)
        yield found


def captured(path: Path, markers: Mapping[str, str]) -> dict[str, Vector]:
    """Time [s], angles [rad], signal, and 1 while leg 0 stands, (n,) each, as the CSV file of encoders has them.

    A leg's angle is that of the line from the hip's marker to its foot's from "up", foot ahead positive; the foot that
    is slower along the ground stands. Without a channel of the signal there is none. Raises WrongOption.
    """
    named = {**MARKERS, **markers}
    refuse(*((named[axis] not in AXES, f"{path}: {axis} is {named[axis]}, must be one of {', '.join(AXES)}")
             for axis in ("forward", "up")))  # fmt: skip
    rate, labels, points, channels, analog = _read(path)
    labelled = {marker: named[marker] for marker in ("hip", "leg_0", "leg_1")}
    refuse(*((label not in labels, f"{path}: no marker {label} for {marker}; there are {', '.join(labels)}")
             for marker, label in labelled.items()))  # fmt: skip
    places = {marker: _seen(points[:, labels.index(label)], path, label) for marker, label in labelled.items()}
    forward, up = ({name: _along(place, named[axis]) for name, place in places.items()} for axis in ("forward", "up"))
    angles = [np.arctan2(forward[leg] - forward["hip"], up["hip"] - up[leg]) for leg in ("leg_0", "leg_1")]
    count = len(angles[0])
    refuse((count < 8, f"{path}: has {count} frames, at least 8 are needed"))
    stands = standing(np.column_stack([forward["leg_0"], forward["leg_1"]]))
    signal = analog[:, channels.index(named["signal"])] if named["signal"] in channels else np.zeros(count)
    return {"time": np.arange(count) / rate, "stance": np.where(stands, angles[0], angles[1]),
            "between": angles[1] - angles[0], "signal": signal, "stands": stands.astype(float)}  # fmt: skip


def standing(feet: np.ndarray) -> np.ndarray:
    """In which frames leg 0 stands (n,), by both feet's places along the ground (n, 2): its foot is slower.

    Places are smoothed by a Gaussian, as wide as their noise needs (none without noise). Between two frames in which
    another foot is clearly slower, it changes where the one has gone farthest beyond the other.
    """
    noise = SIGMAS * np.median(np.abs(np.diff(feet, 2, axis=0))) / math.sqrt(6.0)
    speeds, left = np.abs(np.gradient(feet, axis=0)), noise / math.sqrt(2.0)
    for width in range(1, len(feet) // 8):
        if left <= NOISY * np.quantile(speeds, 0.9):
            break
        speeds = np.abs(gaussian_filter1d(feet, width, axis=0, order=1))
        left = noise / (2.0 * math.pi**0.25 * width**1.5)
    slower = speeds[:, 1] - speeds[:, 0]
    clear = np.flatnonzero(np.abs(slower) > CLEARLY * np.quantile(speeds, 0.9))
    if not len(clear):
        return np.asarray(slower > 0.0)
    stands = np.full(len(feet), slower[clear[0]] > 0.0)
    for before, after in pairwise(clear):
        if (slower[before] > 0.0) != (slower[after] > 0.0):
            gone = np.cumsum(slower[before:after]) * np.sign(slower[before])
            stands[before + int(gone.argmax()) + 1 :] = slower[after] > 0.0
    return stands


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
    refuse((not frames or not rate > 0, f"{path}: has no frames"))
    return rate, labels, np.array([one for one, _ in frames]), channels, np.array([one for _, one in frames])


def _seen(track: np.ndarray, path: Path, label: str) -> np.ndarray:
    """Places (n, 3) of a marker, with short gaps bridged. Raises WrongOption where it is hidden for longer."""
    hidden = (track[:, 3] < 0) | ~np.isfinite(track).all(axis=1)
    longest = max((len(run) for run in "".join("x" if one else " " for one in hidden).split()), default=0)
    refuse((longest > MOST_HIDDEN,
            f"{path}: marker {label} is hidden for {longest} frames in a row, at most {MOST_HIDDEN}"))
    rows = np.arange(len(track))
    return np.column_stack([np.interp(rows, rows[~hidden], track[~hidden, axis]) for axis in range(3)])


def _along(places: np.ndarray, axis: str) -> Vector:
    """Places along an axis (n,)."""
    column = places[:, "xyz".index(axis[-1])]
    return np.asarray(-column if axis.startswith("-") else column, dtype=float)
