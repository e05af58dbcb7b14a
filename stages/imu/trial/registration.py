"""Strides laid over each other: phase 0 at a heel strike of the inner leg, phase 1 at its next one."""

from __future__ import annotations

import numpy as np

from stages.imu.clock.resample import resample


def register(time: np.ndarray, signals: np.ndarray, bounds: np.ndarray, points: int, longest_step: float) -> np.ndarray:
    """Signals (n, k) at times (n,) cut into strides (s, 2) and stretched to `points` phases: (s, points, k).

    Holes longer than `longest_step` [s] stay NaN. Each column has its own holes.
    """
    phase = np.linspace(0.0, 1.0, points)
    grid = bounds[:, :1] + (bounds[:, 1:] - bounds[:, :1]) * phase
    columns = [resample(time, signals[:, [i]], grid.ravel(), longest_step)[:, 0] for i in range(signals.shape[1])]
    return np.stack(columns, axis=-1).reshape(len(bounds), points, signals.shape[1])
