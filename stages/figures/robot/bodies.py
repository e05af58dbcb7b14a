"""The twin's parts as coloured triangles, a body at a time, in the axes of the bill of parts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np

from stages.biped.accuracy.scales import size
from stages.biped.design import Biped
from stages.drawing import style
from stages.twin.exports.seen import shown_parts
from stages.twin.exports.solids import Surface, piece_place, surface
from stages.twin.machine.parts import Part
from stages.twin.parameters import Settings

#: Inner and outer pair, as in the paper.
COLOURS = {"inner": style.SECOND, "outer": style.MULTIBODY}
#: Light and dark parts of a pair's colour, by material: metal is pale, rubber nearly black.
TINTS = {"aluminium": 0.45, "steel": 0.45, "acetal": 0.6, "electronics": -0.55, "rubber": -0.7}
#: Facets of a full circle: from near, and where the whole robot is a thumb's length on the page.
FACETS, SMALL = 12, 8
#: Edges longer than this [m], for Table 1's leg, are cut, so that near and far triangles can be told by depth.
LONGEST = 0.11


@dataclass(frozen=True)
class Faces:
    """Corners (n, 3, 3) [m], outward normals (n, 3) and colours (n, 3) of triangles."""

    corners: np.ndarray
    normals: np.ndarray
    colours: np.ndarray


def joined(many: Iterable[Faces]) -> Faces:
    """Several as one."""
    every = [Faces(*(np.zeros((0, *shape)) for shape in ((3, 3), (3,), (3,)))), *many]
    return Faces(*(np.concatenate([getattr(one, name) for one in every])
                   for name in ("corners", "normals", "colours")))  # fmt: skip


def tinted(colour: str, tint: float) -> np.ndarray:
    """A colour made pale (tint > 0) or deep (< 0), (3,)."""
    rgb = np.array([int(colour[place : place + 2], 16) for place in (1, 3, 5)]) / 255.0
    return rgb + tint * (0.88 - rgb) if tint > 0.0 else rgb * (1.0 + tint)


def of_twin(settings: Settings, biped: Biped, facets: int = FACETS) -> dict[str, Faces]:
    """The triangles of the twin of a design, as `by_group` has them."""
    return by_group(shown_parts(settings, biped), facets, LONGEST * size(biped))


@cache
def by_group(parts: tuple[Part, ...], facets: int = FACETS, longest: float = LONGEST) -> dict[str, Faces]:
    """The triangles of each rigid group, both sides of the machine; `facets` of a full circle. Several figures show the
    same: nobody may change them.
    """
    gathered: dict[str, list[Faces]] = {}
    for part in parts:
        made = surface(part, facets)
        if made is None:
            continue
        colour = tinted(COLOURS[part.group.split("_")[0]], TINTS.get(part.material, 0.0))
        for side in (1.0, -1.0)[: part.pieces]:
            gathered.setdefault(part.group, []).append(faces(made.moved(piece_place(part, side)), colour, longest))
    return {group: joined(many) for group, many in gathered.items()}


def faces(made: Surface, colour: np.ndarray, longest: float = LONGEST) -> Faces:
    """A surface as flat triangles of one colour, none with an edge longer than `longest` [m]."""
    corners = cut(made.corners[made.triangles], longest)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = across / np.linalg.norm(across, axis=1)[:, None]
    return Faces(corners, normals, np.broadcast_to(colour, (len(corners), 3)))


def cut(corners: np.ndarray, longest: float) -> np.ndarray:
    """Triangles (n, 3, 3) halved at their longest edge until none is longer."""
    done = []
    while len(corners):
        edge = np.linalg.norm(corners[:, (1, 2, 0)] - corners, axis=2)
        worst = edge.argmax(axis=1)
        long = edge.max(axis=1) > longest
        done.append(corners[~long])
        rows, first = np.arange(len(corners))[long], worst[long]
        a, b, c = (corners[rows, (first + shift) % 3] for shift in range(3))
        middle = 0.5 * (a + b)
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    return np.concatenate(done)
