"""The bill of parts put together: six rigid bodies."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stages.twin.machine.parts import FRAMES, Part
from stages.twin.machine.shapes import solid


@dataclass(frozen=True)
class Body:
    """Mass [kg], mass centre [m] (3,) and tensor of inertia about it [kg m^2] (3, 3), in the axes of the parts."""

    mass: float
    centre: np.ndarray
    inertia: np.ndarray

    def inertia_about(self, point: np.ndarray) -> np.ndarray:
        """Tensor of inertia about a point, by the parallel-axis theorem."""
        d = self.centre - np.asarray(point)
        return np.asarray(self.inertia + self.mass * (np.dot(d, d) * np.eye(3) - np.outer(d, d)))


def join(bodies: Iterable[Body]) -> Body:
    """One rigid body made of several."""
    pieces = list(bodies)
    mass = sum(piece.mass for piece in pieces)
    centre = sum((piece.mass * piece.centre for piece in pieces), np.zeros(3)) / mass if mass else np.zeros(3)
    return Body(mass, centre, sum((piece.inertia_about(centre) for piece in pieces), np.zeros((3, 3))))


def pieces(part: Part) -> Iterator[Body]:
    """The piece a row describes, and its mirror image if it has one."""
    shape = solid(part.shape, part.size, part.axis)
    place = np.array(part.position, dtype=float) + np.array(shape.centroid)
    inertia = np.diag(shape.inertia(part.mass))
    yield Body(part.mass, place, inertia)
    if part.pieces == 2:
        yield Body(part.mass, place * np.array([1.0, 1.0, -1.0]), inertia)


def bodies(parts: Iterable[Part]) -> tuple[Body, ...]:
    """Six rigid bodies: inner frame, left and right inner foot, outer frame, left and right outer foot."""
    gathered: list[list[Body]] = [[] for _ in range(6)]
    for part in parts:
        first = 3 * part.group.startswith("outer")
        for piece in pieces(part):
            side = 0 if part.group in FRAMES else (1 if piece.centre[2] > 0.0 else 2)
            gathered[first + side].append(piece)
    return tuple(join(group) for group in gathered)


def turning_as(bodies: Sequence[Body], leg_inertia: float) -> tuple[Body, ...]:
    """Bodies whose pairs of feet have this moment [kg m^2]; 0: as they are.

    A foot's whole tensor scales. Exact where the left and the right foot of a pair are alike.
    """
    found = list(bodies)
    for first in (1, 4) if leg_inertia > 0.0 else ():
        have = float(join(found[first : first + 2]).inertia[2, 2])
        for number in (first, first + 1):
            inertia = found[number].inertia * (leg_inertia / have) if have else np.diag([0.0, 0.0, 0.5 * leg_inertia])
            found[number] = replace(found[number], inertia=inertia)
    return tuple(found)
