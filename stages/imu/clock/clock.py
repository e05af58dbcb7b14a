"""Clock repair: the time of each sample from its index and from when its packet arrived.

A packet can be late, never early. So the arrival stamps lie above the line t = a + b * index that a loss-free radio
of constant delay would draw, and that line is the highest one below all stamps: the linear program

    maximise  sum_i (a + b n_i)   subject to   a + b n_i <= t_i,

whose solution is the edge of the lower convex hull that spans the mean index (two unknowns: the optimum lies on
two stamps). It holds however the lateness is distributed, where least squares is pulled up by every stall.
The smallest delay of the radio stays in `a`: it cannot be observed from the stamps.

A restart of the sensor begins a segment with an index and an offset of its own, but not with another oscillator: all
segments share the rate of the longest, and none ends after the next has begun. Both only bound `a` from above, as the
stamps do, so the smallest bound holds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.imu.clock.packet_index import IndexedRecording, arrival_stamp

FEWEST_PACKETS = 10  # below this half of the packets does not make an envelope
FASTEST = 100.0  # times the nominal rate: faster, or backwards, the stamps mean nothing
HUBER_WIDTH = 1.345  # 95 % efficiency for normal errors (Huber 1981)


@dataclass(frozen=True)
class Line:
    """t = offset + period * index [s]."""

    offset: float
    period: float

    def at(self, index: np.ndarray) -> np.ndarray:
        """Times of the indices [s]."""
        return self.offset + self.period * index


@dataclass(frozen=True)
class Clock:
    """Repaired time of every sample (n,) [s] and what the fit says about itself.

    `jitter_before` is the rms of the stamps about their least-squares line [s]; `disagreement` the rms distance of
    two envelopes fitted to alternate packets, their mean removed [s]; `robust_ppm` the rate of the robust fit
    relative to that of the envelope [ppm]. All three are NaN where the source has no stamps.
    """

    time: np.ndarray
    stamp: str
    rate_hz: float
    rate_ppm: float
    jitter_before: float
    disagreement: float
    robust_ppm: float


def lower_envelope(index: np.ndarray, stamp: np.ndarray) -> Line:
    """The highest line below all points, in the mean; exact, O(n log n). Needs two different indices."""
    order = np.lexsort((stamp, index))
    x, y = index[order].astype(float), stamp[order]
    first = np.append(True, np.diff(x) > 0)
    x, y = x[first], y[first]
    hull: list[int] = []
    for i in range(len(x)):
        while len(hull) > 1 and _above(x, y, hull[-2], hull[-1], i):
            hull.pop()
        hull.append(i)
    corner = np.array(hull)
    right = int(np.clip(np.searchsorted(x[corner], index.mean()), 1, len(corner) - 1))
    p, q = corner[right - 1], corner[right]
    period = (y[q] - y[p]) / (x[q] - x[p])
    return Line(float(y[p] - period * x[p]), float(period))


def _above(x: np.ndarray, y: np.ndarray, p: int, q: int, r: int) -> bool:
    """Whether point q lies on or above the chord from p to r."""
    return bool((y[q] - y[p]) * (x[r] - x[p]) >= (y[r] - y[p]) * (x[q] - x[p]))


def least_squares_line(index: np.ndarray, stamp: np.ndarray, weight: np.ndarray | None = None) -> Line:
    """Weighted least-squares line through the points."""
    w = np.ones(len(index)) if weight is None else weight
    x0, y0 = np.average(index, weights=w), np.average(stamp, weights=w)
    dx = index - x0
    period = float(np.sum(w * dx * (stamp - y0)) / np.sum(w * dx * dx))
    return Line(float(y0 - period * x0), period)


def robust_line(index: np.ndarray, stamp: np.ndarray, rounds: int = 30) -> Line:
    """Huber's M-estimate of the line by iteratively reweighted least squares, scale from the median deviation."""
    line = least_squares_line(index, stamp)
    for _ in range(rounds):
        residual = stamp - line.at(index)
        residual = residual - np.median(residual)
        scale = max(1.4826 * float(np.median(np.abs(residual))), 1e-9)
        weight = 1.0 / np.maximum(1.0, np.abs(residual) / (HUBER_WIDTH * scale))
        line = least_squares_line(index, stamp, weight)
    return line


def repair_clock(indexed: IndexedRecording) -> Clock:
    """Time of every sample on the clock of the arrival stamps; without stamps, index over the nominal rate.

    Device stamps are not arrivals but readings of the sensor's own clock: with no packet counter to prefer, they are
    taken as they are.
    """
    recording, nominal = indexed.recording, indexed.recording.device.rate_hz
    name, stamp = arrival_stamp(recording)
    if name == "none" or len(np.unique(indexed.index)) < 2:
        return Clock(counted(indexed) / nominal, "none", nominal, 0.0, np.nan, np.nan, np.nan)
    arrival = packet_arrivals(indexed, stamp)
    longest = np.bincount(arrival[:, 0].astype(int)).argmax()
    x, y = arrival[arrival[:, 0] == longest, 1], arrival[arrival[:, 0] == longest, 2]
    if len(x) < 2:
        return Clock(counted(indexed) / nominal, "none", nominal, 0.0, np.nan, np.nan, np.nan)
    best = lower_envelope(x, y)
    rate = 1.0 / best.period if best.period > 0 else np.inf
    if not rate < FASTEST * nominal:
        return Clock(counted(indexed) / nominal, name, rate, np.inf, float(np.std(y)), np.nan, np.nan)
    time = segment_times(indexed, arrival, best.period)
    if name == "device" and indexed.lost_packets is None:
        time = stamp.copy()
    return Clock(
        time=time,
        stamp=name,
        rate_hz=float(rate),
        rate_ppm=float((rate / nominal - 1) * 1e6),
        jitter_before=float(np.std(y - least_squares_line(x, y).at(x))),
        disagreement=_disagreement(x, y),
        robust_ppm=float((best.period / robust_line(x, y).period - 1) * 1e6),
    )


def packet_arrivals(indexed: IndexedRecording, stamp: np.ndarray) -> np.ndarray:
    """Rows (segment, index of the packet's last sample, arrival stamp), one a packet.

    A packet leaves when its last sample is taken, so it is that sample the stamp belongs to, also when the row
    itself is missing.
    """
    packet = indexed.index // indexed.batch_size
    last = np.append((np.diff(packet) != 0) | (np.diff(indexed.segment) != 0), True)
    end_of_batch = packet[last] * indexed.batch_size + indexed.batch_size - 1
    return np.column_stack((indexed.segment[last], end_of_batch, stamp[last]))


def counted(indexed: IndexedRecording) -> np.ndarray:
    """Sampling periods of every sample (n,) with no pause between segments: how long one was, only stamps tell."""
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
        time[rows] = Line(float(offset), period).at(index)
        end = time[rows][0]
    return time


def _disagreement(x: np.ndarray, y: np.ndarray) -> float:
    if len(x) < 2 * FEWEST_PACKETS:
        return float("nan")
    difference = lower_envelope(x[::2], y[::2]).at(x) - lower_envelope(x[1::2], y[1::2]).at(x)
    return float(np.std(difference))
