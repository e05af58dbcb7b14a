"""Which leg lands when, and the strides between the inner leg's landings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

INNER, OUTER = 0, 1


@dataclass(frozen=True)
class HeelStrikes:
    """Times (s,) [s] of heel strikes and the leg (s,) that lands: 0 the inner one, 1 the outer one."""

    time: np.ndarray
    leg: np.ndarray


def stride_bounds(strikes: HeelStrikes, skipped: int = 0) -> np.ndarray:
    """Start and end (k, 2) [s] of every whole stride after the first `skipped` strikes.

    A stride with a strike missing inside (longer than 1.5 times the median) is left out.
    """
    inner = strikes.time[skipped:][strikes.leg[skipped:] == INNER]
    bounds = np.column_stack((inner[:-1], inner[1:]))
    if not len(bounds):
        return bounds
    length = bounds[:, 1] - bounds[:, 0]
    return np.asarray(bounds[np.abs(length / np.median(length) - 1) < 0.5])
