"""When a walk is sampled: evenly, and more densely around heel strikes, where forces last less than a sample."""

from __future__ import annotations

import numpy as np

#: Window around a heel strike [s] and rate in it [Hz] that show an impact's forces.
IMPACT_WINDOW = (-1e-3, 9e-3)
IMPACT_RATE_HZ = 2e4
#: The hip feels a spike of some 20 us in this time after touch-down [s]; at this rate [Hz] its peak is seen to 1 %.
SPIKE_WINDOW = (0.0, 2e-4)
SPIKE_RATE_HZ = 2e5


def uniform_times(end: float, rate_hz: float) -> np.ndarray:
    """Even times from 0 to `end` [s] at `rate_hz`, shape (n,); rounding does not lose the last one."""
    count = int(np.floor(end * rate_hz * (1.0 + 1e-12))) + 1
    return np.minimum(np.arange(count) / rate_hz, end)


def refined_times(end: float, rate_hz: float, heel_strikes: np.ndarray) -> np.ndarray:
    """Even times from 0 to `end` [s], with denser ones around the heel strikes (s,) [s]; shape (n,), rising."""
    windows = (*IMPACT_WINDOW, 1.0 / IMPACT_RATE_HZ), (*SPIKE_WINDOW, 1.0 / SPIKE_RATE_HZ)
    offsets = np.concatenate([np.arange(*window) for window in windows])
    around = (np.asarray(heel_strikes)[:, None] + offsets).ravel()
    inside = around[(around > 0.0) & (around < end)]
    times = np.sort(np.concatenate([uniform_times(end, rate_hz), inside]))
    # points closer than a tenth of the densest spacing say nothing new
    kept: np.ndarray = times[np.concatenate([[True], np.diff(times) > 0.1 / SPIKE_RATE_HZ])]
    return kept
