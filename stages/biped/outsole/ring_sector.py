"""A sector of a thick ring: the rim of a round foot, and the layer under it."""

from __future__ import annotations

import math
from typing import NamedTuple


class RingSector(NamedTuple):
    """Area [m^2], depth of the centroid under the ring's centre [m], mean squares from the centroid [m^2].

    `along` is the direction of symmetry, downwards; `across` lies square to it in the ring's plane.
    """

    area: float
    depth: float
    across: float
    along: float


def ring_sector(outer: float, thickness: float, half_angle: float) -> RingSector:
    """The sector within `half_angle` [rad] of straight down, between `outer` radius [m] less `thickness` [m] and it."""
    inner = outer - thickness
    area = half_angle * (outer**2 - inner**2)
    if area == 0.0:
        return RingSector(0.0, outer * math.sin(half_angle) / half_angle, 0.0, 0.0)
    depth = 2.0 * math.sin(half_angle) * (outer**3 - inner**3) / (3.0 * area)
    polar = 0.5 * (outer**2 + inner**2)
    share = math.sin(2.0 * half_angle) / (4.0 * half_angle)
    return RingSector(area, depth, polar * (0.5 - share), polar * (0.5 + share) - depth**2)
