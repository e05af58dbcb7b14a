"""Stamps as labs write them: seconds, ms, us, ns, ISO 8601 with zones, dates with points, and times of day.

A number does not say its unit. But a sensor's nominal rate is known, and the units are a factor of 1000 apart: the one
in which the stamps advance at about that rate is meant. Where none is, the stamps are left as they are, and the rate
that follows from them is refused later, with both rates named.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from datetime import datetime, timezone
from typing import Any

import numpy as np

UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
CONFIRMED = 3.0  # factor within which stamps advance at the nominal rate
FEWEST = 10  # stamps from which a rate is read
APART = 30  # rows between which it is, so that packets and jitter hardly count, and pauses neither
DAY = 86400.0
_CLOCK = re.compile(r"\s*(\d{1,2}):(\d{2}):(\d{2})(?:[.,:](\d+))?\s*$")
_POINTS = re.compile(r"\s*(\d{1,2})\.(\d{1,2})\.(\d{4})[ T](.*)$")
_FRACTION = re.compile(r"([.,])(\d{6})\d+")


def unit_of(stamp: np.ndarray, rate_hz: float) -> str | None:
    """The unit in which stamps (n,) advance at about the nominal rate; None where that is no unit, or too few."""
    known = stamp[np.isfinite(stamp)]
    if len(known) < FEWEST:
        return None
    apart = min(APART, len(known) // 2)
    step = float(np.median(known[apart:] - known[:-apart])) / apart
    if not step > 0:
        return None
    near = {unit: abs(math.log(step * size * rate_hz)) for unit, size in UNITS.items()}
    best = min(near, key=lambda unit: near[unit])
    return best if near[best] < math.log(CONFIRMED) else None


def in_seconds(stamp: np.ndarray, rate_hz: float) -> np.ndarray:
    """The stamps (n,) in seconds, whatever unit the nominal rate confirms."""
    unit = unit_of(stamp, rate_hz)
    if unit in (None, "s"):
        return stamp
    assert unit is not None
    start = stamp[np.isfinite(stamp)][0]
    # Apart from their start, so that nanoseconds since 1970 lose nothing that they have.
    return np.asarray((stamp - start) * UNITS[unit] + start * UNITS[unit])


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
    try:
        return moment(datetime.fromisoformat(_FRACTION.sub(r"\1\2", text)))
    except ValueError:
        return math.nan


def moments(cells: Sequence[str]) -> np.ndarray:
    """Times (n,) [s] of written stamps, times of day counted on over midnight; NaN for what is none."""
    found = np.array([moment(cell) for cell in cells])
    known = np.flatnonzero(np.isfinite(found))
    if len(known) and np.all(found[known] < 2 * DAY):
        over = np.cumsum(np.append(0, np.diff(found[known]) < -DAY / 2))
        found[known] += DAY * over
    return found


