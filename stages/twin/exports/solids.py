"""What is seen of the twin: the parts of its bill, or its point masses, and what joins them; and their surfaces as
triangles, for formats that draw meshes.

A shape is a list of flat or rounded patches; corners are not shared between patches, so edges stay sharp.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.biped.accuracy.scales import size
from stages.biped.design import Biped
from stages.twin.machine.parts import FEET, FRAMES, Part
from stages.twin.parameters import Settings

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


#: Chord of an outsole as a share of the foot's diameter.
SOLE = 0.67


def points(settings: Settings, biped: Biped) -> tuple[Part, ...]:
    """The machine without parts: a mass at the hip, on its axis, and of each leg its mass and its round foot."""
    radius, large = biped.foot_radius, size(biped)
    low = min(0.014 * large, max(biped.foot_com, 0.008 * biped.leg_length))  # stays above the ground
    lanes = (settings.inner_lane, settings.outer_lane)
    shown = [Part("hip mass", FRAMES[0], "steel", "cylinder", "z", (0.022 * large, settings.inner_lane), 1.0,
                  (0.0, 0.0, 0.0), 1)]  # fmt: skip
    for frame, foot, lane in zip(FRAMES, FEET, lanes, strict=True):
        shown += [
            Part("hip axis", frame, "steel", "cylinder", "z", (0.004 * large, 2 * lane), 1.0, (0.0, 0.0, 0.0), 1),
            Part("foot mass", foot, "steel", "cylinder", "z", (low, settings.foot_width), 1.0,
                 (0.0, biped.foot_com - biped.leg_length, lane), 2),
        ]  # fmt: skip
        if radius > 0.0:
            rim = (radius, 0.14 * radius, settings.foot_width, SOLE * 2.0 * radius)
            shown.append(Part("foot", foot, "ABS", "arc", "z", rim, 1.0, (0.0, radius - biped.leg_length, lane), 2))
    return tuple(shown)


def guides(settings: Settings, biped: Biped) -> tuple[Part, ...]:
    """Thin rods down the legs and into the feet: the bill leaves open what a leg slides on, and parts would float."""
    ankle = biped.leg_length - biped.foot_radius
    end, below, large = min(ankle, 0.9 * biped.leg_length), ankle + 0.95 * biped.foot_radius, size(biped)
    return tuple(
        Part("guide", group, "steel", "cylinder", "y", (thick * large, length), 1.0, (0.0, -top - length / 2, lane), 2)
        for groups, thick, top, length in ((FRAMES, 0.0025, 0.0, end), (FEET, 0.004, end, below - end))
        for group, lane in zip(groups, (settings.inner_lane, settings.outer_lane))
    )


def outsoles(settings: Settings, biped: Biped) -> tuple[Part, ...]:
    """The rubber on top of the design's feet, if there is any."""
    radius = biped.foot_radius + settings.outsole
    sector = (radius, settings.outsole, settings.foot_width, SOLE * 2.0 * radius)
    height = biped.foot_radius - biped.leg_length
    return tuple(
        Part("outsole", group, "rubber", "arc", "z", sector, 1.0, (0.0, height, lane), 2)
        for group, lane in zip(FEET, (settings.inner_lane, settings.outer_lane))
        if settings.outsole > 0.0
    )


def what_is_drawn(settings: Settings, biped: Biped) -> str:
    """What `shown_parts` are, in words."""
    if settings.inertia == "planar":
        return "its point masses, legs and round feet, as it has no parts,"
    fitted = any(settings.bill_rule(biped.plain(leg)) for leg in (0, 1))
    return "every part of its bill, made to fit the design," if fitted else "every part of its bill"


def solid_parts(settings: Settings, biped: Biped) -> tuple[Part, ...]:
    """The parts of the bill; of a machine without a bill its point masses and feet."""
    return points(settings, biped) if settings.inertia == "planar" else settings.bill(biped)


def shown_parts(settings: Settings, biped: Biped) -> tuple[Part, ...]:
    """All that is seen of the robot, each pair of legs by its own numbers; masses of what is not in the bill mean
    nothing."""
    pairs = [(*solid_parts(settings, plain), *guides(settings, plain), *outsoles(settings, plain))
             for plain in (biped.plain(0), biped.plain(1))]  # fmt: skip
    if pairs[0] == pairs[1]:
        return pairs[0]
    return tuple(part for leg in (0, 1) for part in pairs[leg] if part.group in (FRAMES[leg], FEET[leg]))
