"""Cuts through the bill of parts by the frontal plane x = 0: what of each part lies in it, in the axes of the bill."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stages.twin.machine.parts import Part


@dataclass(frozen=True)
class Cut:
    """A rectangle of a part in the plane x = 0: lower left corner (z, y), width and height [m].

    What is not `solid` is seen behind the cut, or before it.
    """

    part: Part
    z: float
    y: float
    width: float
    height: float
    solid: bool = True

    @property
    def pair(self) -> str:
        """inner or outer."""
        return self.part.group.split("_")[0]


def cuts(part: Part) -> Iterator[Cut]:
    """The rectangles of a part and of its mirror image; what the plane misses is given as it is seen along x."""
    for side in (1.0, -1.0)[: part.pieces]:
        x, y, z = part.position[0], part.position[1], side * part.position[2]
        for low, wide, bottom, high, solid in _of_shape(part, x):
            yield Cut(part, z + low, y + bottom, wide, high, solid)


def _of_shape(part: Part, x: float) -> Iterator[tuple[float, float, float, float, bool]]:
    """Of one piece about its reference point: z, width, y, height and whether the plane cuts it."""
    size = part.size
    if part.shape == "box":
        yield -size[2] / 2, size[2], -size[1] / 2, size[1], abs(x) <= size[0] / 2
    elif part.shape == "arc":
        outer, thickness, width, _ = size
        yield -width / 2, width, -outer, thickness, True
    elif part.shape in ("cylinder", "tube"):
        radius, length = size[0], size[-1]
        inner = size[1] if part.shape == "tube" else 0.0
        yield from _round(part.axis, radius, inner, length, abs(x))


def _round(axis: str, radius: float, inner: float, length: float, aside: float
           ) -> Iterator[tuple[float, float, float, float, bool]]:  # fmt: skip
    if axis == "x" or aside > radius:  # a round end, or beside the plane: its outline
        across = radius if axis != "z" else length / 2
        up = radius if axis != "y" else length / 2
        yield -across, 2 * across, -up, 2 * up, False
        return
    half, hole = math.sqrt(radius**2 - aside**2), math.sqrt(max(0.0, inner**2 - aside**2))
    bands = [(-half, half)] if hole == 0.0 else [(-half, -hole), (hole, half)]
    for low, high in bands:
        if axis == "z":
            yield -length / 2, length, low, high - low, True
        else:
            yield low, high - low, -length / 2, length, True


def area(found: list[Cut]) -> float:
    """Area of what is cut [m^2]."""
    return float(np.sum([each.width * each.height for each in found if each.solid]))
