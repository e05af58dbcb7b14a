"""Surfaces of the parts as triangles, for formats that draw meshes.

A shape is a list of flat or rounded patches; corners are not shared between patches, so edges stay sharp.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.twin.machine.parts import Part

#: Height of a stepping block [m]. Only its top matters.
BLOCK_HEIGHT = 0.03
#: Facets of a full circle.
ROUND = 32
#: Order of coordinates that brings z to an axis, right-handed.
_AXES = {"x": (2, 0, 1), "y": (1, 2, 0), "z": (0, 1, 2)}


@dataclass(frozen=True)
class Surface:
    """Corners (n, 3) [m], outward normals (n, 3) and triangles (m, 3) of corners, counterclockwise from outside."""

    corners: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray

    def moved(self, place: tuple[float, ...]) -> Surface:
        """The same elsewhere."""
        return Surface(self.corners + np.asarray(place), self.normals, self.triangles)


def joined(surfaces: list[Surface]) -> Surface:
    """Several as one."""
    first = np.cumsum([0, *(len(one.corners) for one in surfaces)])
    return Surface(
        np.concatenate([one.corners for one in surfaces]),
        np.concatenate([one.normals for one in surfaces]),
        np.concatenate([one.triangles + start for one, start in zip(surfaces, first)]),
    )


def patch(corners: np.ndarray, normals: np.ndarray) -> Surface:
    """Three or four corners, counterclockwise from outside."""
    return Surface(corners, normals, np.array([[0, 1, 2], [0, 2, 3]])[: len(corners) - 2])


def box(size: tuple[float, ...]) -> Surface:
    """A box about the origin."""
    half = 0.5 * np.asarray(size, dtype=float)
    sides = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            u, v = ((axis + 1) % 3, (axis + 2) % 3)[:: int(sign)]
            corners, normals = np.zeros((4, 3)), np.zeros((4, 3))
            corners[:, axis], normals[:, axis] = sign * half[axis], sign
            corners[:, u], corners[:, v] = half[u] * np.array([-1, 1, 1, -1]), half[v] * np.array([-1, -1, 1, 1])
            sides.append(patch(corners, normals))
    return joined(sides)


def ring(outer: float, inner: float, width: float, half_angle: float = math.pi, facets: int = ROUND) -> Surface:
    """A ring about z, symmetric to -y, over twice `half_angle`, with so many `facets` a full circle."""
    whole = half_angle >= math.pi
    count = max(4, math.ceil(facets * half_angle / math.pi))
    angles = np.linspace(-half_angle, half_angle, count + 1)
    out = np.column_stack([np.sin(angles), -np.cos(angles), np.zeros(count + 1)])
    lift = np.array([0.0, 0.0, 0.5 * width])
    sides = []
    for k in range(count):
        a, b = out[k], out[k + 1]
        sides.append(patch(np.stack([outer * a - lift, outer * b - lift, outer * b + lift, outer * a + lift]),
                           np.stack([a, b, b, a])))  # fmt: skip
        if inner > 0.0:
            sides.append(patch(np.stack([inner * b - lift, inner * a - lift, inner * a + lift, inner * b + lift]),
                               np.stack([-b, -a, -a, -b])))  # fmt: skip
        top = np.stack([inner * a, outer * a, outer * b, inner * b][: 4 if inner > 0.0 else 3])
        level = np.tile([0.0, 0.0, 1.0], (len(top), 1))
        sides += [patch(top + lift, level), patch(top[::-1] - lift, -level)]
    if not whole:
        for a, sign in ((out[0], -1.0), (out[-1], 1.0)):
            end = np.stack([inner * a - lift, outer * a - lift, outer * a + lift, inner * a + lift])
            normal = sign * np.array([-a[1], a[0], 0.0])
            sides.append(patch(end if sign < 0.0 else end[::-1], np.tile(normal, (4, 1))))
    return joined(sides)


def surface(part: Part, facets: int = ROUND) -> Surface | None:
    """The surface of a part about its reference point; a point has none. `facets`: of a full circle."""
    size = part.size
    if part.shape == "point":
        return None
    if part.shape == "box":
        return box(size)
    if part.shape == "arc":
        outer, thickness, width, chord = size
        finer = math.ceil(2.0 * outer / max(outer, outer - part.position[1]))  # a hundredth of a leg off at most
        return ring(outer, outer - thickness, width, math.asin(min(1.0, 0.5 * chord / outer)), 2 * finer * facets)
    made = ring(size[0], size[1] if part.shape == "tube" else 0.0, size[-1], facets=facets)
    order = list(_AXES[part.axis])
    return Surface(made.corners[:, order], made.normals[:, order], made.triangles)


def piece_place(part: Part, side: float) -> tuple[float, float, float]:
    """Reference point of a piece [m]; `side` -1 is the mirror image."""
    x, y, z = part.position
    return float(x), float(y), side * float(z)
