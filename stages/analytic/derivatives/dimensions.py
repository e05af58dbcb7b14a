"""The rules that dimensions set for elasticities: units may be chosen, so all that has a unit moves together.

In units of mass, length or time that are larger by a share, every parameter is smaller by that share to the power of
its dimension, and so is every measure (Euler's theorem on homogeneous functions).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stages.analytic.model.walker import Vector
from stages.biped.accuracy.scales import powers


def left_by_dimensions(elasticities: Vector, units: Sequence[str], unit: str) -> Vector:
    """What the elasticities (n,) of a measure in `unit` leave of the rules of mass, length and time, (3,): no more than
    errors.

    `units` (n,) are those of the parameters, which must be all that have a unit. Raises KeyError for another unit.
    """
    of_each = np.array([powers(each) for each in units], dtype=float).reshape(-1, 3)
    left: Vector = of_each.T @ np.asarray(elasticities) - np.array(powers(unit), dtype=float)
    return left
