"""Gaits that repeat after two, four or eight steps, or so many strides if the legs differ."""

from __future__ import annotations

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.poincare import FixedPoint, fixed_point, poincare_map
from stages.analytic.model.walker import Vector, Walker

CYCLES = (2, 4, 8)
#: Steps walked before a cycle is looked for: transients of stable cycles have died out by then.
TRANSIENT_STEPS = 400
#: A cycle must differ from a shorter one by more than this.
DISTINCT = 1e-6


def closes_early(point: FixedPoint) -> bool:
    """Whether the gait repeats after half its cycle."""
    return bool(np.abs(point.steps[len(point.steps) // 2 - 1].z - point.z).max() < DISTINCT)


def find_cycle(walker: Walker, start: Vector, tolerance: float) -> tuple[int, FixedPoint] | None:
    """The stable cycle of two, four or eight steps that a walk displaced from an unstable gait `start` settles on.

    None if the walk falls, or settles on no such cycle.
    """
    z = np.asarray(start, dtype=float) * (1.0 + 1e-4)
    try:
        standing = walker
        for _ in range(TRANSIENT_STEPS):
            z, standing = poincare_map(standing, z, tolerance).z, standing.exchanged
    except StepFailed:
        return None
    for cycle in CYCLES:
        point = fixed_point(walker, z, tolerance, cycle)
        if point is not None and np.abs(point.z - z).max() < 1e-2 and not closes_early(point):
            return cycle, point
    return None
