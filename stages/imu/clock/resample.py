"""Resampling onto a common grid by a shape-preserving interpolant, which never overshoots and never bridges a gap."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

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
    beside = np.clip(np.stack((right - 1, right)), 0, len(t) - 1)
    exact = (np.abs(t[beside] - grid) <= AT_SAMPLE * longest_step).any(axis=0)
    inside = (right > 0) & (right < len(t))
    bounded = np.zeros(len(grid), dtype=bool)
    bounded[inside] = t[right[inside]] - t[right[inside] - 1] <= longest_step
    wanted = bounded | exact
    if wanted.any():
        result[wanted] = PchipInterpolator(t, v, axis=0)(grid[wanted])
    return result
