"""The rules that dimensions set for elasticities: units may be chosen, so all that has a unit moves together.

In units of mass, length or time that are larger by a share, every parameter is smaller by that share to the power of
its dimension, and so is every measure (Euler's theorem on homogeneous functions).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stages.analytic.model.walker import Vector

#: Powers of mass, length and time in a unit.
POWERS = {
    "kg": (1, 0, 0), "m": (0, 1, 0), "s": (0, 0, 1), "Hz": (0, 0, -1), "m/s": (0, 1, -1), "m/s^2": (0, 1, -2),
    "N/m": (1, 0, -2), "N s/m": (1, 0, -1), "kg m^2": (1, 2, 0), "N m/rad": (1, 2, -2),
    "N m s/rad": (1, 2, -1), "N m": (1, 2, -2), "deg": (0, 0, 0), "rad": (0, 0, 0), "1": (0, 0, 0),
}  # fmt: skip


def left_by_dimensions(elasticities: Vector, units: Sequence[str], unit: str) -> Vector:
    """What the elasticities (n,) of a measure in `unit` leave of the rules of mass, length and time, (3,): no more than
    errors.

    `units` (n,) are those of the parameters, which must be all that have a unit. Raises KeyError for another unit.
    """
    powers = np.array([POWERS[each] for each in units], dtype=float).reshape(-1, 3)
    left: Vector = powers.T @ np.asarray(elasticities) - np.array(POWERS[unit], dtype=float)
    return left
