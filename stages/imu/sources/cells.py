"""From the cells of any source to numbers, seconds, devices, experiments and arrays, refusing what has no meaning.

Stamps are as labs write them: seconds, ms, us, ns, ISO 8601 with zones, dates with points, and times of day. A number
does not say its unit. But a sensor's nominal rate is known, and the units are a factor of 1000 apart: the one in which
the stamps advance at about that rate is meant. Where none is, the stamps are left as they are, and the rate that
follows from them is refused later, with both rates named.
"""

import math
import re
from collections.abc import Mapping, Sequence
from datetime import datetime, timezone
from typing import Any

import numpy as np

from stages.imu.sources.opening import printable, refuse
from stages.imu.sources.schema import (
    ACCELERATION_UNITS,
    ANGULAR_RATE_UNITS,
    SAMPLE_VALUES,
    Device,
    Experiment,
    Recording,
)

AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
FASTEST_RATE_HZ = 1e5
LARGEST_VALUE = 1e15
AT_ONCE = 10_000  # rows that a processor has at hand
LARGEST_STAMP = 1e19  # nanoseconds since 1970 are a fifth of it
UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
CONFIRMED = 3.0  # factor within which stamps advance at the nominal rate
FEWEST = 10  # stamps from which a rate is read
APART = 30  # rows between which it is, so that packets and jitter hardly count, and pauses neither
COUNTERS = tuple(2.0**bits for bits in (16, 24, 31, 32))
LATE = 5  # rows at most that one comes late
DAY = 86400.0
PAUSE = 1e-3  # of a day, or of what a counter counts to: so much may be missing when it begins anew
_CLOCK = re.compile(r"\s*(\d{1,2}):(\d{2}):(\d{2})(?:[.,:](\d+))?\s*$")
_POINTS = re.compile(r"\s*(\d{1,2})\.(\d{1,2})\.(\d{4})[ T](.*)$")
#: What Python 3.10 reads of a date and time: six decimals, and a zone as +02:00.
_FRACTION = re.compile(r"[.,](\d+)")
_ZONE = re.compile(r"(:\d\d(?:\.\d{6})?)(?:Z|([+-]\d\d):?(\d\d)?)$")


def numbers(rows: Sequence[Sequence[Any]], width: int) -> np.ndarray:
    """An array (n, width) of the cells; a cell that is no number and no time becomes NaN."""
    try:
        return np.array(rows, dtype=float).reshape(-1, width)
    except (TypeError, ValueError):
        return np.array([[number_or_moment(cell) for cell in row] for row in rows], dtype=float)


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


def as_stored(cell: Any) -> Any:
    """The cell as SQLite keeps it: a date and time in seconds since 1970, another number as float, the rest as text."""
    if cell is None or isinstance(cell, (float, str, bytes)) or (isinstance(cell, int) and abs(cell) < 2**63):
        return cell
    value = number_or_moment(cell)
    return value if value == value else str(cell)


def text_of(cell: Any) -> str:
    """The cell of a book or a database as it would stand in a text; nothing for none."""
    if isinstance(cell, datetime):
        return cell.isoformat()
    return "" if cell is None else str(cell).strip()


def step_of(stamp: np.ndarray) -> float:
    """By how much stamps (n,) advance from row to row; NaN where they do not, or are too few."""
    known = stamp[np.isfinite(stamp)]
    if len(known) < FEWEST:
        return math.nan
    apart = min(APART, len(known) // 2)
    step = float(np.median(known[apart:] - known[:-apart])) / apart
    return step if step > 0 else math.nan


def unit_of(stamp: np.ndarray, rate_hz: float) -> str | None:
    """The unit in which stamps (n,) advance at about the nominal rate; None where that is no unit, or too few."""
    step = step_of(stamp)
    if math.isnan(step):
        return None
    near = {unit: abs(math.log(step * size * rate_hz)) for unit, size in UNITS.items()}
    best = min(near, key=near.__getitem__)
    return best if near[best] < math.log(CONFIRMED) else None


def counted_on(stamp: np.ndarray, counters: Sequence[float] = COUNTERS) -> np.ndarray:
    """The stamps (n,) of a counter that began anew after one of these numbers, as if it had gone on.

    It falls by nearly that many, where a sensor that restarts falls by another number; soon after that a rise by as
    many is a row from before it that comes late.
    """
    known, usual = np.flatnonzero(np.isfinite(stamp)), APART * step_of(stamp)
    steps, turns = np.diff(stamp[known]), np.zeros(max(len(known) - 1, 0))
    for modulus in (one for one in counters if one > 2.0 * usual):
        near = max(usual, PAUSE * modulus)
        fell, rose = np.abs(steps + modulus) < near, np.abs(steps - modulus) < near
        soon = np.convolve(fell, np.ones(LATE), "full")[: len(steps)] > 0
        turns += modulus * (fell * 1.0 - (rose & soon))
    found = stamp.copy()
    found[known[1:]] += np.cumsum(turns)
    return found


def in_seconds(stamp: np.ndarray, rate_hz: float) -> np.ndarray:
    """The stamps (n,) in seconds, whatever unit the nominal rate confirms; of a counter that began anew, or a time of
    day after midnight, counted on."""
    stamp = counted_on(stamp)
    size = UNITS[unit_of(stamp, rate_hz) or "s"]
    if size != 1.0:
        start = stamp[np.isfinite(stamp)][0]
        # Apart from their start, so that nanoseconds since 1970 lose nothing that they have.
        stamp = (stamp - start) * size + start * size
    return counted_on(stamp, (DAY,))


def moment(cell: Any) -> float:
    """Seconds since 1970 of a date and time, or since midnight of a time of day; NaN for what is neither."""
    if isinstance(cell, datetime):
        return cell.replace(tzinfo=cell.tzinfo or timezone.utc).timestamp()
    if not isinstance(cell, str):
        return math.nan
    clock = _CLOCK.match(cell)
    if clock:
        hours, minutes, seconds, fraction = clock.groups()
        return 3600 * int(hours) + 60 * int(minutes) + int(seconds) + float(f"0.{fraction or 0}")
    points = _POINTS.match(cell)
    text = f"{points[3]}-{points[2]:>02}-{points[1]:>02} {points[4]}" if points else cell.strip()
    text = _FRACTION.sub(lambda found: f".{found[1]:0<6.6}", text)
    text = _ZONE.sub(lambda found: f"{found[1]}{found[2] or '+00'}:{found[3] or '00'}", text)
    try:
        return moment(datetime.fromisoformat(text))
    except ValueError:
        return math.nan


def moments(cells: Sequence[str]) -> np.ndarray:
    """Times (n,) [s] of written stamps; NaN for what is none."""
    return np.array([moment(cell) for cell in cells])


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
    return Recording(packet, position, sensor, phone, server, columns[:, 5:8], columns[:, 8:11], experiment, device)


def device_from_row(row: Mapping[str, Any], where: str) -> Device:
    """A device from named cells. Raises SourceRefused where rate, unit or axes have no meaning."""
    return Device(
        place=_text(row.get("place")) or "unknown",
        rate_hz=_positive(row.get("rate_hz"), f"{where}: rate_hz", FASTEST_RATE_HZ),
        accelerometer_unit=_unit(row.get("accelerometer_unit"), ACCELERATION_UNITS, f"{where}: accelerometer_unit"),
        gyroscope_unit=_unit(row.get("gyroscope_unit"), ANGULAR_RATE_UNITS, f"{where}: gyroscope_unit"),
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
    return "".join(character if character.isprintable() else "?" for character in text[:80])


def _positive(cell: Any, what: str, largest: float) -> float:
    value = number(cell)
    refuse((
        not 0 < value <= largest, f"{what} is {printable(cell)}, must be a number above 0 and at most {largest:g}"
    ))
    return value


def _optional(row: Mapping[str, Any], key: str, where: str, largest: float = 1e6) -> float | None:
    return None if row.get(key) is None else _positive(row[key], f"{where}: {key}", largest)


def _whole(row: Mapping[str, Any], key: str, where: str, largest: int) -> int | None:
    value = _optional(row, key, where, largest)
    return None if value is None else max(1, int(value))


def _one_of(cell: Any, choices: Mapping[str, Any] | Sequence[str], what: str, text: str) -> str:
    refuse((text not in choices, f"{what} is {printable(cell)}, must be one of {', '.join(choices)}"))
    return text


def _unit(cell: Any, choices: Mapping[str, Any], what: str) -> str:
    return _one_of(cell, choices, what, _text(cell).replace("m/s2", "m/s^2").replace("m/s²", "m/s^2"))


def _axis(cell: Any, what: str) -> str | None:
    text = _text(cell).lower()
    text = text if text.startswith(("+", "-")) else f"+{text}"
    return None if cell is None or cell == "" else _one_of(cell, AXES, what, text)
