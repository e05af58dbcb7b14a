"""When a walk is sampled: evenly, and more densely around heel strikes, where forces last less than a sample."""

from __future__ import annotations

import numpy as np

#: Window around a heel strike, in pendulum times of the design, and rate in it, that show an impact's forces.
IMPACT_WINDOW = (-5e-3, 0.05)
IMPACT_RATE = 4e3
#: The hip feels a spike of some 1e-4 in this time after touch-down; at this rate its peak is seen to 1 %.
SPIKE_WINDOW = (0.0, 1e-3)
SPIKE_RATE = 4e4


def uniform_times(end: float, rate_hz: float) -> np.ndarray:
    """Even times from 0 to `end` [s] at `rate_hz`, shape (n,); rounding does not lose the last one."""
    count = int(np.floor(end * rate_hz * (1.0 + 1e-12))) + 1
    return np.minimum(np.arange(count) / rate_hz, end)


def refined_times(end: float, rate_hz: float, heel_strikes: np.ndarray, pendulum_time: float) -> np.ndarray:
    """Even times from 0 to `end` [s], with denser ones around the heel strikes (s,) [s]; shape (n,), rising."""
    windows = (*IMPACT_WINDOW, 1.0 / IMPACT_RATE), (*SPIKE_WINDOW, 1.0 / SPIKE_RATE)
    offsets = np.concatenate([np.arange(*window) for window in windows]) * pendulum_time
    around = (np.asarray(heel_strikes)[:, None] + offsets).ravel()
    inside = around[(around > 0.0) & (around < end)]
    times = np.sort(np.concatenate([uniform_times(end, rate_hz), inside]))
    # points closer than a tenth of the densest spacing say nothing new
    kept: np.ndarray = times[np.concatenate([[True], np.diff(times) > 0.1 * pendulum_time / SPIKE_RATE])]
    return kept
