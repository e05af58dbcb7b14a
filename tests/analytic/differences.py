"""Derivatives of the step map by differences, which the exact ones are held against."""

from __future__ import annotations

import numpy as np

from stages.analytic.gait.poincare import poincare_map
from stages.analytic.model.walker import Vector, Walker


def map_slope(walker: Walker, z: Vector, sizes: tuple[float, ...]) -> np.ndarray:
    """The map's derivative (n, n) by extrapolated central differences of these sizes (n,)."""
    columns = []
    for index, size in enumerate(sizes):
        step = np.zeros(len(sizes))
        step[index] = size
        coarse, fine = ((poincare_map(walker, z + h * step, 1e-13).z - poincare_map(walker, z - h * step, 1e-13).z)
                        / (2 * h * size) for h in (1.0, 0.5))  # fmt: skip
        columns.append((4 * fine - coarse) / 3)
    return np.array(columns).T
