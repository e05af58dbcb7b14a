"""Clock repair: the time of each sample from its index and from when its packet arrived.

The clock is the line below the arrivals, and its error what the floor of lateness shows of it, window by window (both
`lateness.py`), where settings of the phone's clock and the sensor's own wander are taken out as well.

A restart of the sensor begins a segment with an index and an offset of its own, but not with another oscillator: all
segments share the rate of the longest, and none ends after the next has begun. Both only bound `a` from above, as the
stamps do, so the smallest bound holds.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from stages.biped.quantity import quantity
from stages.imu.clock.lateness import (
    Straightened,
    least_squares_line,
    moments,
    put_on,
    robust_line,
    straighten,
    unevenness,
)
from stages.imu.clock.packet_index import BY_ROWS, IndexedRecording, arrival_stamp
from stages.imu.result import NOT_OBSERVABLE, ClockFit

FASTEST = 100.0  # times the nominal rate: faster, or backwards, the stamps mean nothing


@dataclass(frozen=True)
class Clock(ClockFit):
    """Repaired time of every sample, and what the fit says about itself."""

    time: np.ndarray = quantity("s", "time of every sample, shape (n,)")
    settings: np.ndarray = quantity("s", "settings of the phone's clock that were taken out, shape (k,)")


def repair_clock(indexed: IndexedRecording, tolerance: float) -> Clock:
    """Time of every sample on the clock of the arrival stamps; without stamps, index over the nominal rate.

    A floor uneven by more than `tolerance` [s] is looked into for settings and bends. Device stamps are not arrivals
    but readings of the sensor's own clock: with nothing else to date the samples, they are taken as they are.
    """
    nominal = indexed.recording.device.rate_hz
    name, stamp = arrival_stamp(indexed.recording)
    arrival = packet_arrivals(indexed, stamp)
    longest = arrival[:, 0] == np.bincount(arrival[:, 0].astype(int), minlength=1).argmax()
    x, y = arrival[longest, 1], arrival[longest, 2]
    if name == "none" or len(np.unique(x)) < 2:
        return _unfitted(indexed, "none", nominal, 0.0, np.nan)
    found = straighten(x, y, tolerance, indexed.numbered_by != BY_ROWS)
    rate = 1.0 / found.period if found.period > 0 else np.inf
    if not rate < FASTEST * nominal:
        return _unfitted(indexed, name, rate, np.inf, float(np.std(y)))
    level = arrival.copy()
    level[longest, 2] -= put_on(found.steps, x) + found.bent(x)
    time = segment_times(indexed, level, found.period)
    time += np.where(indexed.segment == arrival[longest, 0][0], found.bent(indexed.index), 0.0)
    error = _error(found, arrival[~longest])
    # A floor that is even shows no loss, but one packet less tilts it as a slower clock does. Nothing shows
    # the error of the sensor's own clock.
    if name == "device" or (indexed.numbered_by == BY_ROWS and error <= tolerance):
        error = np.nan
    if name == "device" and indexed.lost_packets == NOT_OBSERVABLE and indexed.batch_size == 1:
        time = stamp.copy()
    return Clock(
        time=time,
        stamp=name,
        rate_hz=float(rate),
        rate_ppm=float((rate / nominal - 1) * 1e6),
        jitter_before_s=float(np.std(y - least_squares_line(x, y)(x))),
        clock_error_s=error,
        robust_ppm=float((found.period / robust_line(x, y).coef[1] - 1) * 1e6),
        settings=found.steps[:, 1],
        clock_bend_s=float(np.ptp(found.bend[:, 1])) if len(found.bend) else 0.0,
    )


def _unfitted(indexed: IndexedRecording, stamp: str, rate: float, ppm: float, jitter: float) -> Clock:
    time = counted(indexed) / indexed.recording.device.rate_hz
    return Clock(stamp, rate, ppm, 0.0, np.nan, jitter, np.nan, time, np.empty(0))


def _error(found: Straightened, others: np.ndarray) -> float:
    """The worst unevenness of any life of the sensor [s], all at one rate; `others` are the arrivals of the shorter."""
    errors = [found.error]
    for segment in np.unique(others[:, 0]):
        x, y = others[others[:, 0] == segment, 1:].T
        errors.append(unevenness(*np.column_stack((x, y - found.period * x))[moments(y)].T))
    return float(np.fmax.reduce(errors))


def packet_arrivals(indexed: IndexedRecording, stamp: np.ndarray) -> np.ndarray:
    """Rows (segment, index of the packet's last sample, arrival stamp), one a packet.

    A packet leaves when its last sample is taken, so it is that sample the stamp belongs to, also when the row
    itself is missing. The last packet of a life may leave before it is full, when the sensor is stopped: where its last
    row is missing it says nothing. Without a counter, rows of one stamp are a packet.
    """
    packet = indexed.index // indexed.batch_size
    apart = np.diff(packet) != 0
    if indexed.batch_size == 1:
        apart &= np.diff(stamp) != 0
    last = np.append(apart | (np.diff(indexed.segment) != 0), True) if len(packet) else np.zeros(0, dtype=bool)
    segment, index = indexed.segment[last], indexed.index[last]
    full = packet[last] * indexed.batch_size + indexed.batch_size - 1
    apart = np.diff(segment) != 0
    first, final = np.append(True, apart)[: len(index)], np.append(apart, True)[: len(index)]
    return np.column_stack((segment, full, stamp[last])).compress((index == full) | first | ~final, axis=0)


def counted(indexed: IndexedRecording) -> np.ndarray:
    """Sampling periods of every sample (n,) with no pause between segments: how long one was, only stamps show."""
    step = np.where(np.diff(indexed.segment) == 0, np.diff(indexed.index), 1)
    return np.asarray(np.cumsum(np.append(indexed.index[:1], step)))


def segment_times(indexed: IndexedRecording, arrival: np.ndarray, period: float) -> np.ndarray:
    """Time of every sample (n,) [s]: one line a segment, below its rows of `arrival`, and none into the next."""
    time = np.empty(len(indexed.index))
    end = np.inf
    for segment in np.unique(indexed.segment)[::-1]:
        rows, points = indexed.segment == segment, arrival[arrival[:, 0] == segment]
        index = indexed.index[rows]
        offset = min(np.min(points[:, 2] - period * points[:, 1]), end - period * (index[-1] + 1))
        time[rows] = offset + period * index
        end = time[rows][0]
    return time


#: Of the longest step: what lies so near to a sample is at it, else the rounding of stamps since 1970 would decide
#: whether the edge of a hole is known. PCHIP goes so little beyond its first and last sample.
AT_SAMPLE = 1e-3


def resample(time: np.ndarray, value: np.ndarray, grid: np.ndarray, longest_step: float) -> np.ndarray:
    """Values (n, k) at increasing times (n,) brought to `grid` (m,) by PCHIP; NaN where there is no neighbour.

    A row with a NaN counts as missing. A grid point between two samples further apart than `longest_step` stays NaN,
    and so does one outside the recording: a hole stays a hole (Fritsch and Carlson 1980 for the interpolant).
    """
    known = np.isfinite(value).all(axis=1) & np.isfinite(time)
    result = np.full((len(grid), value.shape[1]), np.nan)
    t, v = time[known], value[known]
    if len(t) < 2:
        return result
    right = np.searchsorted(t, grid)
    before, after = t[np.clip(np.stack((right - 1, right)), 0, len(t) - 1)]
    exact = np.minimum(np.abs(before - grid), np.abs(after - grid)) <= AT_SAMPLE * longest_step
    wanted = exact | ((right > 0) & (right < len(t)) & (after - before <= longest_step))
    if wanted.any():
        result[wanted] = PchipInterpolator(t, v, axis=0)(grid[wanted])
    return result
