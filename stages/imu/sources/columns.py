"""From the cells of any source to devices, experiments and arrays, refusing what has no meaning."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from stages.imu.errors import SourceRefused, printable
from stages.imu.sources.schema import (
    ACCELERATION_UNITS,
    ANGULAR_RATE_UNITS,
    SAMPLE_VALUES,
    Device,
    Experiment,
    Recording,
)
from stages.imu.sources.stamps import in_seconds, moment

AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
FASTEST_RATE_HZ = 1e5
LARGEST_VALUE = 1e15
AT_ONCE = 10_000  # rows that a processor has at hand
LARGEST_STAMP = 1e19  # nanoseconds since 1970 are a fifth of it


def numbers(rows: Sequence[Sequence[Any]], width: int) -> np.ndarray:
    """An array (n, width) of the cells; a cell that is no number and no time becomes NaN."""
    if not rows:
        return np.empty((0, width))
    try:
        table = np.array(rows, dtype=float)
    except (TypeError, ValueError):
        table = np.array([[number_or_moment(cell) for cell in row] for row in rows], dtype=float)
    return table


def number(cell: Any) -> float:
    """The cell as a float; NaN where it is none."""
    try:
        return float(cell)
    except (TypeError, ValueError, OverflowError):
        return math.nan


def number_or_moment(cell: Any) -> float:
    """The cell as a float, or the seconds of a date and time as a database or a text holds it; NaN for neither."""
    found = number(cell)
    return found if found == found or cell is None else moment(cell)


def recording_from_columns(experiment: Experiment, device: Device, columns: np.ndarray) -> Recording:
    """A recording from an array (n, 11) whose columns are those of `SAMPLE_VALUES`, stamps in any unit.

    Values that no sensor gives become NaN, in `columns` itself, of which the recording's arrays are parts.
    """
    limit = np.where([name.endswith("_stamp") for name in SAMPLE_VALUES], LARGEST_STAMP, LARGEST_VALUE)
    for first in range(0, len(columns), AT_ONCE):
        rows = columns[first : first + AT_ONCE]
        np.copyto(rows, np.nan, where=~(np.abs(rows) < limit))
    packet, position = columns[:, :2].T
    sensor, phone, server = (in_seconds(stamp, device.rate_hz) for stamp in columns[:, 2:5].T)
    return Recording(experiment, device, packet, position, sensor, phone, server, columns[:, 5:8], columns[:, 8:11])


def device_from_row(row: Mapping[str, Any], where: str) -> Device:
    """A device from named cells. Raises SourceRefused where rate, unit or axes have no meaning."""
    return Device(
        place=_text(row.get("place")) or "unknown",
        rate_hz=_positive(row.get("rate_hz"), f"{where}: rate_hz", FASTEST_RATE_HZ),
        accelerometer_unit=_one_of(row.get("accelerometer_unit"), ACCELERATION_UNITS, f"{where}: accelerometer_unit"),
        gyroscope_unit=_one_of(row.get("gyroscope_unit"), ANGULAR_RATE_UNITS, f"{where}: gyroscope_unit"),
        name=_text(row.get("name")),
        bandwidth_hz=_optional(row, "bandwidth_hz", where),
        accelerometer_range_g=_optional(row, "accelerometer_range_g", where),
        gyroscope_range_deg_s=_optional(row, "gyroscope_range_deg_s", where),
        bits=_whole(row, "bits", where, 64),
        batch_size=_whole(row, "batch_size", where, 4096),
        counter_modulus=_whole(row, "counter_modulus", where, 2**53),
        forward_axis=_axis(row.get("forward_axis"), f"{where}: forward_axis"),
        up_axis=_axis(row.get("up_axis"), f"{where}: up_axis"),
    )


def experiment_from_row(row: Mapping[str, Any]) -> Experiment:
    """An experiment from named cells."""
    slope = number(row.get("slope_deg"))
    return Experiment(
        name=_text(row.get("name")) or f"run {_text(row.get('experiment_id'))}",
        origin=_text(row.get("origin")) or "unknown",
        slope_deg=slope if abs(slope) < 90 else None,
    )


def _text(cell: Any) -> str:
    """A short line of text without control characters."""
    text = "" if cell is None else cell.decode("utf-8", "replace") if isinstance(cell, bytes) else str(cell)
    return "".join(character if character.isprintable() else "?" for character in text)[:80]


def _positive(cell: Any, what: str, largest: float) -> float:
    value = number(cell)
    if not 0 < value <= largest:
        raise SourceRefused(f"{what} is {printable(cell)}, must be a number above 0 and at most {largest:g}")
    return value


def _optional(row: Mapping[str, Any], key: str, where: str) -> float | None:
    return None if row.get(key) is None else _positive(row[key], f"{where}: {key}", 1e6)


def _whole(row: Mapping[str, Any], key: str, where: str, largest: int) -> int | None:
    return None if row.get(key) is None else max(1, int(_positive(row[key], f"{where}: {key}", largest)))


def _one_of(cell: Any, choices: Mapping[str, Any], what: str) -> str:
    text = _text(cell).replace("m/s2", "m/s^2").replace("m/s²", "m/s^2")
    if text not in choices:
        raise SourceRefused(f"{what} is {printable(cell)}, must be one of {', '.join(choices)}")
    return text


def _axis(cell: Any, what: str) -> str | None:
    if cell is None or cell == "":
        return None
    text = _text(cell).lower()
    text = text if text.startswith(("+", "-")) else f"+{text}"
    if text not in AXES:
        raise SourceRefused(f"{what} is {printable(cell)}, must be one of {', '.join(AXES)}")
    return text
