"""Strides of a simulated walk, stretched to a common phase so that walks of different period can be compared."""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from stages.biped.between_steps import running_integral
from stages.biped.walk import Walk

T = TypeVar("T")


class NoEvidence(ValueError):
    """What is compared or drawn is not there; the message says why."""


def there(compared: T | None) -> T:
    """What was compared. Raises NoEvidence where it could not be."""
    if compared is None:
        raise NoEvidence("what it shows could not be compared; the claims say why")
    return compared


@dataclass(frozen=True)
class Stride:
    """One stride, heel strike to heel strike of the inner leg, at `phase` (p,) from 0 to 1.

    `hip_position` (p, 2) starts at x = 0; `signals` (p, 6) are the sensors', in the order of `SENSOR_SIGNALS`, each a
    mean from halfway before its phase to halfway after: the spike of a heel strike is shorter than that, and where it
    falls between two phases would decide its height;
    `peaks` (6,) their largest values, with sign, at the walk's own samples, denser than the phases around an impact.
    """

    phase: np.ndarray
    period: float
    hip_position: np.ndarray
    hip_velocity: np.ndarray
    signals: np.ndarray
    peaks: np.ndarray


def last_bounds(walk: Walk) -> tuple[float, float]:
    """Start and end [s] of the last whole stride of the inner leg. Raises NoEvidence if the walk has none."""
    strikes = walk.heel_strike_time[walk.heel_strike_leg == 0]
    inside = strikes[(strikes >= walk.time[0]) & (strikes <= walk.time[-1])]
    if len(inside) < 2:
        raise NoEvidence("the walk is too short for a whole stride: nothing to compare")
    return float(inside[-2]), float(inside[-1])


def last_stride(walk: Walk, points: int) -> Stride:
    """The last whole stride of a walk. Raises NoEvidence if it has none."""
    start, end = last_bounds(walk)
    phase = np.linspace(0, 1, points)
    times = start + (end - start) * phase

    def at(signal: np.ndarray) -> np.ndarray:
        columns = signal.reshape(len(walk.time), -1)
        return np.column_stack([np.interp(times, walk.time, column) for column in columns.T])

    half = 0.5 * (end - start) / (points - 1)
    sensed = np.column_stack(  # in the order of `SENSOR_SIGNALS`
        [walk.hip_specific_force, walk.hip_angular_velocity, walk.foot_specific_force, walk.foot_angular_velocity])
    position = at(walk.hip_position)
    position[:, 0] -= position[0, 0]
    inside = sensed[(walk.time >= start) & (walk.time <= end)]
    peaks = inside[np.abs(inside).argmax(axis=0), np.arange(inside.shape[1])]
    signals = means(walk.time, sensed, times - half, times + half)
    return Stride(phase, end - start, position, at(walk.hip_velocity), signals, peaks)


def means(time: np.ndarray, signals: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Means over the spans from `start` to `end` (p,) of signals (n, k), straight between their times (n,): (p, k).

    A span that leaves the record counts as far as it lies inside.
    """
    start, end = (np.clip(edge, time[0], time[-1]) for edge in (start, end))
    known = np.unique(np.concatenate((time, start, end)))
    found = []
    for signal in signals.T:
        integral = running_integral(np.interp(known, time, signal), known)
        found.append((integral[np.searchsorted(known, end)] - integral[np.searchsorted(known, start)]) / (end - start))
    return np.column_stack(found)


def through_low_pass(stride: Stride, bandwidth_hz: float) -> np.ndarray:
    """A stride's signals (p, 6) as a sensor's second-order Butterworth low pass shows them, its mean delay taken out.

    The stride counts as periodic, so the filter acts on its Fourier series: 1 / (1 + i sqrt(2) w - w^2), w relative to
    the cut-off. The signals as they are where `bandwidth_hz` is NaN.
    """
    if not bandwidth_hz > 0:
        return stride.signals
    series = np.fft.rfft(stride.signals[:-1], axis=0)
    w = np.arange(len(series)) / stride.period / bandwidth_hz
    passed = np.exp(1j * np.sqrt(2) * w) / (1 + 1j * np.sqrt(2) * w - w**2)
    smooth = np.fft.irfft(series * passed[:, None], n=len(stride.signals) - 1, axis=0)
    return np.concatenate((smooth, smooth[:1]))


def normalised_rms(curve: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Rms difference of two sets of curves (p, k) over the range of the reference, (k,); NaN for a constant one."""
    extent = np.ptp(reference, axis=0)
    rms = np.sqrt(np.mean((curve - reference) ** 2, axis=0))
    return np.asarray(np.divide(rms, extent, out=np.full_like(rms, np.nan), where=extent > 0))
