"""One log written down in many ways that change nothing: units, axes, stamps, clocks, order, layout."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from stages.imu.parameters import Parameters
from stages.imu.sources.column_map import CsvSource
from stages.imu.sources.schema import Device, Recording
from stages.imu.sources.units import scale_of
from stages.imu.trial.body import mounting
from stages.imu.trial.trial import Trial, read_trials
from tests.imu.made_logs import Log

UNITS = {"m/s^2": 1.0, "g": 1 / 9.80665, "mg": 1e3 / 9.80665, "rad/s": 1.0, "deg/s": 180 / np.pi, "mdps": 180e3 / np.pi}
SIGNS = {"comma": ",", "semicolon": ";", "tab": "\t"}
NAMES = ("packet", "position", "phone_stamp", "ax", "ay", "az", "gx", "gy", "gz")
TURNS = [one.as_matrix().round() for one in Rotation.create_group("O")]


@dataclass(frozen=True)
class Rewriting:
    """How a log is written: `turn` new axes by old ones, `late` the foot's stamps against the hip's [s]."""

    units: tuple[str, str] = ("m/s^2", "rad/s")
    turn: np.ndarray = field(default_factory=lambda: np.eye(3))
    mirrored: bool = False
    stamp: tuple[float, float] = (1.0, 0.0)
    late: float = 0.0
    order: Sequence[int] = range(len(NAMES))
    foot_first: bool = False
    delimiter: str = "comma"
    decimal_comma: bool = False
    number: str = "{:.9g}"
    quote: str = ""
    end: str = "\n"
    mark: str = ""


REWRITINGS: Mapping[str, Rewriting] = {
    "g, deg/s": Rewriting(units=("g", "deg/s")),
    "m/s^2, rad/s": Rewriting(),
    "mg, mdps": Rewriting(units=("mg", "mdps")),
    "axes turned": Rewriting(turn=TURNS[7]),
    "axes turned otherwise": Rewriting(turn=TURNS[18], units=("g", "rad/s")),
    "mounted 20 degrees off": Rewriting(turn=Rotation.from_rotvec([-0.2, 0.2, 0.2]).as_matrix()),
    "mirrored": Rewriting(mirrored=True),
    "columns and files in another order": Rewriting(order=(8, 3, 0, 6, 2, 5, 1, 7, 4), foot_first=True),
    "1000 s later": Rewriting(stamp=(1.0, 1000.0)),
    "ms since 1970": Rewriting(stamp=(1e3, 1.7e9)),
    "us": Rewriting(stamp=(1e6, 0.0)),
    "ns since 1970": Rewriting(stamp=(1e9, 1.7e9)),
    "clocks an hour apart": Rewriting(late=3600.0),
    "clocks apart, the foot's behind": Rewriting(late=-17.3),
    "decimal comma": Rewriting(delimiter="semicolon", decimal_comma=True),
    "decimal comma, exponents, quoted": Rewriting(
        delimiter="semicolon", decimal_comma=True, number="{:.8E}", quote='"', units=("mg", "deg/s")),
    "tabs, line ends, byte-order mark": Rewriting(delimiter="tab", end="\r\n", mark="\ufeff"),
}  # fmt: skip


def axis_of(device: Device, turn: np.ndarray, row: int) -> str:
    """Name of the sensor axis that lies along the body's axis `row` once the sensor's axes are turned."""
    along = turn @ mounting(device)[row]
    place = int(np.abs(along).argmax())
    return ("+" if along[place] > 0 else "-") + "xyz"[place]


def text_of(recording: Recording, how: Rewriting) -> str:
    """The file of one sensor."""
    scale = scale_of(recording)
    force, rate = recording.acceleration * scale.acceleration, recording.angular_rate * scale.angular_rate
    if how.mirrored:
        seen = mounting(recording.device)
        force, rate = ((value @ seen.T * signs) @ seen for value, signs in ((force, [1, 1, -1]), (rate, [-1, -1, 1])))
    force, rate = force @ how.turn.T * UNITS[how.units[0]], rate @ how.turn.T * UNITS[how.units[1]]
    size, shift = how.stamp
    late = how.late if recording.device.place == "foot" else 0.0
    from_start = recording.phone_stamp - np.floor(recording.phone_stamp.min())
    stamps = [f"{size * (t + late) + size * shift:.{0 if size > 1e3 else 7}f}" for t in from_start]
    rows = [[str(int(n)), str(int(p)), t, *(how.number.format(value) for value in (*a, *w))]
            for n, p, t, a, w in zip(recording.packet, recording.position, stamps, force, rate)]  # fmt: skip
    names = [f"{how.quote}{name}{how.quote}" for name in NAMES]
    if how.decimal_comma:
        rows = [[cell.replace(".", ",") for cell in row] for row in rows]
    sign = SIGNS[how.delimiter]
    return how.mark + how.end.join(sign.join(row[i] for i in how.order) for row in (names, *rows)) + how.end


def described(log: Log, how: Rewriting) -> dict[str, Any]:
    """The map of the files."""
    files = []
    for one in log.recordings:
        device = one.device
        said = {"place": device.place, "rate_hz": device.rate_hz, "bandwidth_hz": device.bandwidth_hz,
                "accelerometer_unit": how.units[0], "gyroscope_unit": how.units[1],
                "accelerometer_range_g": device.accelerometer_range_g,
                "gyroscope_range_deg_s": device.gyroscope_range_deg_s, "counter_modulus": device.counter_modulus,
                "batch_size": device.batch_size, "forward_axis": axis_of(device, how.turn, 0),
                "up_axis": axis_of(device, how.turn, 1)}  # fmt: skip
        files.append({"file": f"{device.place}.csv", "delimiter": how.delimiter, "device": said,
                      "decimal": "comma" if how.decimal_comma else "point",
                      "columns": dict(zip(NAMES, NAMES))})  # fmt: skip
    experiment = {"name": log.experiment.name, "origin": log.experiment.origin, "slope_deg": log.experiment.slope_deg}
    return {"experiment": experiment, "files": files[::-1] if how.foot_first else files}


def rewritten(log: Log, how: Rewriting, folder: Path, parameters: Parameters) -> Trial:
    """The trial as it is read from the log's files."""
    for one in log.recordings:
        (folder / f"{one.device.place}.csv").write_bytes(text_of(one, how).encode())
    ((experiment, recordings),) = CsvSource(described(log, how), folder).runs()
    return next(read_trials(experiment, recordings, parameters))


def differs(one: Trial, other: Trial) -> float:
    """Largest difference of two trials' curves over each curve's own size, holes included."""
    curves = [(trial.strides.reshape(-1, trial.strides.shape[2]), trial.leg.angle[:, None],
               trial.leg.step_length[:, None]) for trial in (one, other)]  # fmt: skip
    largest = 0.0
    for mine, its in zip(*curves):
        if mine.shape != its.shape or (np.isnan(mine) != np.isnan(its)).any():
            return np.inf
        largest = max(largest, float(np.nanmax(np.abs(mine - its) / np.nanmax(np.abs(mine), axis=0))))
    return largest
