"""One sensor of one run, from raw rows to SI values on a repaired clock; where it stands still, and where it walks.

A lab's recording goes on: the robot is caught at the ramp's end, carried back, put down, and walks once more. A hand
turns it about all axes, and the stand of another pose is none to measure a walk from. So each walk is read by itself,
from the stand before it to the next one, or to where it leaves its plane.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from stages.imu.clock.clock import Clock, repair_clock
from stages.imu.clock.packet_index import IndexedRecording, index_samples, numbered
from stages.imu.parameters import Limits, Settings, filter_delay
from stages.imu.sources.schema import Experiment, Recording
from stages.imu.sources.units import Scale, scale_of
from stages.imu.strikes.heel_strikes import SMOOTHED_STEPS, filled, step_period, turns

CLIPPED = 1 - 1e-4  # of full scale: the topmost count is a little below it
BEYOND = 2.0  # times full scale, which may be declared too small: further out nothing was read
LEAP = 0.5  # of the largest rate that lasts: by more a leg's does not change for one sample alone
DRIFT = 4.5  # times as far from their median as half of a stand's windows are, or white noise, a mean may be


@dataclass(frozen=True)
class SensorTrace:
    """Samples in order: time (n,) [s]; specific_force (n, 3) [m/s^2], angular_rate (n, 3) [rad/s] on sensor axes.

    `time` is corrected for the delay of the sensor's own low pass. Clipped readings are NaN and counted. `rest` (n,)
    marks the longest still stand. `wrong` counts the numbers that are no readings of a sensor on a leg, NaN as well.
    """

    indexed: IndexedRecording
    clock: Clock
    scale: Scale
    time: np.ndarray
    specific_force: np.ndarray
    angular_rate: np.ndarray
    clipped_acceleration: int
    clipped_angular_rate: int
    wrong: int
    rest: np.ndarray

    @property
    def rate_hz(self) -> float:
        """Sampling rate as fitted [Hz]."""
        return self.clock.rate_hz

    @property
    def readings(self) -> np.ndarray:
        """Specific force (n, 3) [m/s^2] on sensor axes with clipped readings at full scale, where blows are."""
        raw = self.indexed.recording.acceleration
        return np.where(_is_read(raw, self.scale), raw, np.nan) * self.scale.acceleration

    @property
    def rate_error(self) -> float:
        """Relative error of the clock's rate: its error over the recording; 0 where, as remarked, nothing shows it."""
        span = float(np.ptp(self.time)) if len(self.time) else 0.0
        return self.clock.clock_error_s / span if span > 0 and math.isfinite(self.clock.clock_error_s) else 0.0

    def bias(self) -> np.ndarray:
        """Angular rate at rest (3,) [rad/s]; zero where there is no rest."""
        known = self.rest & np.isfinite(self.angular_rate).all(axis=1)
        return self.angular_rate[known].mean(axis=0) if known.any() else np.zeros(3)

    def static_force(self) -> np.ndarray:
        """Mean specific force at rest (3,) [m/s^2]; NaN where there is no rest."""
        known = self.rest & np.isfinite(self.specific_force).all(axis=1)
        return self.specific_force[known].mean(axis=0) if known.any() else np.full(3, np.nan)

    def static_reading(self) -> float:
        """Magnitude of the specific force in stored units: mean at rest, else median magnitude; NaN if unknown."""
        if self.rest.any():
            return float(np.linalg.norm(self.static_force()) / self.scale.acceleration)
        size = np.linalg.norm(self.indexed.recording.acceleration, axis=1)
        return float(np.median(size[np.isfinite(size)])) if np.isfinite(size).any() else math.nan


def trace_sensor(recording: Recording, settings: Settings) -> SensorTrace:
    """Index, clock, unit, clipping and still stand of a recording. Raises SourceRefused for counts without scale."""
    scale, indexed = scale_of(recording), index_samples(recording)
    return _traced(indexed, repair_clock(indexed, settings.clock_tolerance_s), scale, settings)


def part_of(trace: SensorTrace, rows: slice, experiment: Experiment, settings: Settings) -> SensorTrace:
    """These rows of a trace as a run of their own, with the still stand among them, on the clock of the whole."""
    whole, segment = trace.indexed, trace.indexed.segment[rows]
    recording = replace(whole.recording.take(rows), experiment=experiment)
    if len(segment) == len(trace.time) and experiment == whole.recording.experiment:
        return trace
    indexed = numbered(recording, segment - segment[0], whole.index[rows], whole.batch_size, whole.numbered_by, 0, 0, 0)
    return _traced(indexed, replace(trace.clock, time=trace.clock.time[rows]), trace.scale, settings)


def _traced(indexed: IndexedRecording, clock: Clock, scale: Scale, settings: Settings) -> SensorTrace:
    force, clipped_force = mask_clipped(indexed.recording.acceleration, scale.acceleration_full_scale)
    rate, clipped_rate = mask_clipped(indexed.recording.angular_rate, scale.angular_rate_full_scale)
    force, rate, leap = force * scale.acceleration, rate * scale.angular_rate, leaps(rate)
    rate[leap] = np.nan
    return SensorTrace(
        indexed=indexed,
        clock=clock,
        scale=scale,
        time=clock.time - filter_delay(indexed.recording.device.bandwidth_hz),
        specific_force=force,
        angular_rate=rate,
        clipped_acceleration=clipped_force,
        clipped_angular_rate=clipped_rate,
        wrong=int(leap.sum() + (~_is_read(indexed.recording.acceleration, scale)).sum()),
        rest=find_rest(force, rate, clock.rate_hz, settings),
    )


def leaps(rate: np.ndarray) -> np.ndarray:
    """Where an angular rate (n, 3) leaps away for one sample alone, as no leg's does."""
    lasts = np.median([rate[:-2], rate[1:-1], rate[2:]], axis=0)
    largest = np.abs(lasts[np.isfinite(lasts)]).max(initial=0.0)
    found = np.zeros(rate.shape, dtype=bool)
    found[1:-1] = np.abs(rate[1:-1] - lasts) > LEAP * largest
    return found


def _is_read(raw: np.ndarray, scale: Scale) -> np.ndarray:
    """Whether accelerations (n, 3) may be read at all; what is missing is not looked at."""
    return np.asarray(~(np.abs(raw) > BEYOND * scale.acceleration_full_scale))


def mask_clipped(value: np.ndarray, full_scale: float) -> tuple[np.ndarray, int]:
    """Readings (n, 3) with those at full scale replaced by NaN, and how many samples had one."""
    clipped = np.abs(value) >= CLIPPED * full_scale
    return np.where(clipped, np.nan, value), int(clipped.any(axis=1).sum())


def find_rest(force: np.ndarray, rate: np.ndarray, rate_hz: float, settings: Settings) -> np.ndarray:
    """Mask (n,) of the longest still stand; all False where there is none."""
    still = np.zeros(len(force), dtype=bool)
    starts, ends = stands(force, rate, rate_hz, settings)
    if len(starts):
        longest, length = int(np.argmax(ends - starts)), math.ceil(settings.rest_window_s * rate_hz)
        # A window at the edge still passes when a movement begins in it: half a window is given up at each end.
        margin = min(length // 2, (ends[longest] - starts[longest]) // 4)
        first, last = starts[longest] + margin, ends[longest] - margin
        drawn = np.column_stack([filled(axis) for axis in rate[first:last].T])
        first, last = first + _unmoved(drawn, length)
        still[first:last] = True
    return still


def _unmoved(rate: np.ndarray, length: int) -> np.ndarray:
    """First row, and the row after the last (2,), of the longest part of a still stand whose mean rate stays: a slow
    robot begins to fall so gently that each window is still, but its mean is no zero of the gyroscope's."""
    length = min(length, len(rate))
    means = _window_means(rate - rate[0], length)
    off = np.linalg.norm(means - np.median(means, axis=0), axis=1)
    noise = np.sqrt(0.5 * (np.diff(rate, axis=0) ** 2).sum(axis=1).mean() / length)  # of a mean, where it is white
    starts, ends = _stretches(off <= DRIFT * max(noise, np.median(off)))
    longest = np.argmax(ends - starts)
    return np.array([starts[longest], ends[longest] - 1 + length])


def stands(
    force: np.ndarray, rate: np.ndarray, rate_hz: float, settings: Settings
) -> tuple[np.ndarray, np.ndarray]:
    """First rows (s,) of all stretches where each window of `rest_window_s` is still, and the rows after them (s,).

    Still: angular rate and specific force vary by less than the settings' rms about the window's mean.
    """
    none = np.zeros(0, dtype=np.int64)
    length = math.ceil(settings.rest_window_s * rate_hz) if math.isfinite(rate_hz) else 0
    if length < 5 or len(force) < length:
        return none, none
    quiet = (_window_rms(rate, length) < math.radians(settings.rest_rate_deg_s)) & (
        _window_rms(force, length) < settings.rest_acceleration
    )
    starts, ends = _stretches(quiet)
    return starts, ends - 1 + length


def _stretches(holds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First places (s,) of all stretches where a condition (n,) holds, and the places after them (s,)."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], holds.astype(int), [0]))))
    return edges[::2], edges[1::2]


def _window_means(value: np.ndarray, length: int) -> np.ndarray:
    """Mean of (n, 3) in every window of `length` rows."""
    total = np.cumsum(np.vstack((np.zeros((1, 3)), value)), axis=0)
    return np.asarray((total[length:] - total[:-length]) / length)


def _window_rms(value: np.ndarray, length: int) -> np.ndarray:
    """Rms of the rows of (n, 3) without a NaN about their mean in every window of `length` rows; infinite where most
    have one."""
    known = np.isfinite(value).all(axis=1)
    if not known.any():
        return np.full(len(value) - length + 1, np.inf)
    about = np.where(known[:, None], value - np.median(value[known], axis=0), 0.0)
    there = _window_means(np.repeat(known[:, None], 3, axis=1), length)
    first, second = (_window_means(about**k, length) / np.maximum(there, 0.5) for k in (1, 2))
    variance = np.maximum(second - first**2, 0.0).sum(axis=1)
    return np.where(there[:, 0] > 0.5, np.sqrt(variance), np.inf)


def walks_in(trace: SensorTrace, settings: Settings, limits: Limits) -> list[slice]:
    """The rows of each walk, with the stand before it; none where no walk follows a stand."""
    starts, ends = stands(trace.specific_force, trace.angular_rate, trace.rate_hz, settings)
    least = settings.rest_window_s * trace.rate_hz
    apart = starts[1:] - ends[:-1] > least  # a slow push begins so gently that its first part looks still by itself
    starts, ends = starts[np.append(True, apart)[: len(starts)]], ends[np.append(apart, True)[: len(ends)]]
    rate = np.column_stack([filled(axis) for axis in trace.angular_rate.T])
    walks = list[slice]()
    for first, stood, after in zip(starts, ends, np.append(starts[1:], len(rate))):
        walked = _walked(rate[stood:after] - rate[first:stood].mean(axis=0), trace.rate_hz, settings, limits)
        if walked:
            walks.append(slice(0 if first < least else int(first), int(stood) + walked))
    return walks


def _walked(rate: np.ndarray, rate_hz: float, settings: Settings, limits: Limits) -> int:
    """For how many rows of a motion's angular rate (n, 3) the robot walks; 0 where it does not.

    It swings in one plane, that of its first strides, and turns round as often as a run needs steps.
    """
    begun = rate[: int(rate_hz / settings.slowest_stride_hz)]
    power, axes = np.linalg.eigh(begun.T @ begun)
    if not power[-1] >= limits.swing_share * power.sum() > 0.0:
        return 0
    swing, dt = rate @ axes[:, -1], 1.0 / rate_hz
    period = step_period(swing[: len(begun)], dt, (settings.slowest_step_hz, settings.fastest_step_hz))
    if not np.isfinite(period):
        return 0
    step = int(period * rate_hz)
    of_a_step = [np.convolve(signal, np.ones(step), "valid") for signal in ((rate**2).sum(axis=1), swing**2)]
    usual = step * power.sum() / len(begun)
    outside = np.flatnonzero(of_a_step[0] - of_a_step[1] > (1.0 - limits.swing_share) * np.maximum(of_a_step[0], usual))
    walked = int(outside[0]) if len(outside) else len(rate)
    smooth = gaussian_filter1d(swing[:walked], SMOOTHED_STEPS * period / dt)
    return walked if walked and len(turns(smooth, period, dt)) >= settings.fewest_steps else 0
