"""What one sensor's recording says about itself: losses, units, dead axes, resolution."""

import math

import numpy as np
from scipy.signal import periodogram

from stages.imu.clock.packet_index import IndexedRecording
from stages.imu.sources.units import swept_angle
from stages.imu.trial.sensor import CLIPPED, SensorTrace

FEWEST_ROWS = 50
FLAT = 5  # samples at one extreme reading
BESIDE = 3  # steps next to that reading, which hold fewer samples than it
COARSE = 0.01  # of an axis' range
BELOW_FULL_SCALE = 0.99
LOUD = 0.5  # of the largest reading of any axis: a quiet axis repeats its few counts
OPPOSED = 0.45  # of the largest reading: two samples, one after the other, that both lie beyond it, on opposite sides
TOP, BELOW = (0.7, 1.0), (0.3, 0.6)  # bands of a still stand's noise, of the sensor's bandwidth
LOW_PASSED = 2 / 3  # of the noise of the band below is left in the top one by a second-order low pass of that bandwidth
DOUBT = 3.0  # standard deviations of two bands' ratio
STRIKES_SHOW = 10.0  # times the stand's noise in the top band, at least, are a walk's forces there
AXIS_NAMES = ("ax", "ay", "az", "gx", "gy", "gz")


def batch_sizes(indexed: IndexedRecording) -> np.ndarray:
    """Samples that arrived of each packet (p,) of which any did."""
    packet = np.column_stack((indexed.segment, indexed.index // indexed.batch_size))
    return np.unique(packet, axis=0, return_counts=True)[1]


def missing_share(trace: SensorTrace) -> float:
    """Share of the samples between first and last that are missing, also while a sensor restarted.

    Where no loss can be observed it is 0.
    """
    index, segment = trace.indexed.index, trace.indexed.segment
    if not len(index):
        return 0.0
    restart = np.diff(segment) != 0
    pauses = np.diff(trace.time)[restart] * trace.rate_hz - 1
    absent = float((np.diff(index) - 1)[~restart].sum() + pauses.sum())
    return absent / (len(index) + absent)


def slower_rows(indexed: IndexedRecording) -> int:
    """The most rows, one after the other, that come every second sampling period, or every third or so on, where most
    rows come at each: lost ones leave no such order."""
    step = np.where(np.diff(indexed.segment) == 0, np.diff(indexed.index), 1)
    if not len(step) or np.median(step) > 1:
        return 0
    lengths = np.diff(np.flatnonzero(np.diff(step, prepend=0, append=0)))
    return int((lengths * (step[np.cumsum(lengths) - lengths] > 1)).max())


def leg_sweep(trace: SensorTrace, slowest_hz: float) -> float:
    """The angle that the leg sweeps by the angular rate as declared [rad]; NaN where nothing determines it."""
    known = np.isfinite(trace.angular_rate).all(axis=1)
    if known.sum() < FEWEST_ROWS or not math.isfinite(trace.rate_hz) or trace.rate_hz <= 0:
        return math.nan
    return swept_angle(trace.angular_rate[known], trace.rate_hz, slowest_hz)


def declared_rate_unit(unit: str) -> str:
    return "deg/s" if unit == "counts" else unit


def dead_axes(trace: SensorTrace) -> tuple[str, ...]:
    """Names of the axes that hold one value, or none."""
    raw = np.hstack((trace.indexed.recording.acceleration, trace.indexed.recording.angular_rate))
    different = [len(np.unique(axis[np.isfinite(axis)])) for axis in raw.T]
    return tuple(name for name, values in zip(AXIS_NAMES, different) if values < 2)


def quantisation_step(raw: np.ndarray) -> float:
    """Smallest difference of two values of the same axis (n, 3); NaN where all are equal."""
    steps = np.concatenate([np.diff(np.unique(axis[np.isfinite(axis)])) for axis in raw.T])
    return float(steps.min()) if len(steps) else math.nan


def flat_tops(raw: np.ndarray, full_scale: float) -> tuple[int, float]:
    """Samples at a reading (n, 3) that an axis reaches again and again but never passes, and that reading.

    Such an axis is at full scale below the one that is declared: two samples show it at a half or a quarter of that.
    Where steps are coarse, readings repeat anyway: then, and at the declared `full_scale`, (0, NaN).
    """
    worst, at = 0, math.nan
    largest = float(np.abs(raw[np.isfinite(raw)]).max(initial=0.0))
    for axis in raw.T:
        known = axis[np.isfinite(axis)]
        step = quantisation_step(known[:, None])
        if not len(known) or step > COARSE * np.ptp(known):
            continue
        for end in (known.min(), known.max()):
            count = int((known == end).sum())
            if count <= (np.abs(known - end) < (BESIDE + 0.5) * step).sum() - count:
                continue  # a fast sensor reads a turn's own highest values again and again
            if not LOUD * largest < abs(end) < BELOW_FULL_SCALE * full_scale:
                continue
            halved = math.log2(full_scale / abs(end)) if math.isfinite(full_scale) else 0.5
            if count > worst and count >= (2 if abs(halved - round(halved)) < 1e-3 else FLAT):
                worst, at = count, float(abs(end))
    return worst, at


def wraps(raw: np.ndarray, full_scale: float) -> int:
    """Times that an axis of readings (n, 3) leaps from one end of its range to the other within a sample: counts that
    begin again beyond full scale, once out and once back. A blow swings through what lies between, or, of rigid
    legs, ends at the declared `full_scale`, where no count begins again. 0 for fewer."""
    largest = float(np.abs(raw[np.isfinite(raw)]).max(initial=0.0))
    before, after = raw[:-1], raw[1:]
    apart = np.maximum(np.minimum(before, -after), np.minimum(-before, after))
    count = int((apart > OPPOSED * largest).sum()) if 0 < largest < CLIPPED * full_scale else 0
    return count if count > 1 else 0


def noise_ends(trace: SensorTrace) -> bool:
    """Whether the noise at rest, which is as strong at all frequencies up to the sensor's bandwidth, ends below it.

    Readings that were smoothed, averaged or resampled have none above a corner; a hand's tremor adds to the lowest
    frequencies alone. Rounding hides the noise where a count is as large. A corner so low that rounding is all that is
    left above it leaves nothing of the heel strikes there either.
    """
    raw, rate = trace.indexed.recording, trace.rate_hz
    if not (math.isfinite(rate) and trace.rest.sum() >= FEWEST_ROWS):
        return False
    bandwidth = min(raw.device.bandwidth_hz or 0.4 * rate, 0.45 * rate)

    def bands(values: np.ndarray) -> list[np.ndarray]:
        frequency, spectrum = periodogram(values, rate, "hann", detrend="linear", axis=0)
        scaled = frequency / bandwidth
        return [spectrum[(scaled >= low) & (scaled <= high)] for low, high in (TOP, BELOW)]

    found = []  # of a kind of readings: ratio of the two bands, and how many powers each is the mean of
    for values in (raw.acceleration, raw.angular_rate):
        known = np.isfinite(values).all(axis=1)
        top, below = bands(values[known & trace.rest])
        if not top.size or not below.size:
            return False
        if below.mean() > quantisation_step(values) ** 2 / (3 * rate):  # twice what rounding leaves
            found.append((top.mean() / below.mean(), top.size, below.size))
        if values is raw.acceleration:
            walked = bands(values[known & ~trace.rest])[0]
            if walked.size and walked.mean() < STRIKES_SHOW * top.mean():
                return True
    both = [tuple(np.mean(found, axis=0) * [1, len(found), len(found)])] if found else []
    return any(ratio < LOW_PASSED * math.exp(-DOUBT * math.sqrt(2 / most + 2 / fewer))
               for ratio, most, fewer in (*found, *both))  # fmt: skip
