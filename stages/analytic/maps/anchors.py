"""Designs whose gait is known, and what their exact derivatives say of a gait nearby.

All in the walker's own numbers (`Walker.p`), which are dimensionless: similar designs have the same.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.analytic.derivatives.step_map import walk_derivatives
from stages.analytic.errors import StepFailed
from stages.analytic.gait.newton import by_stability
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model.kinds import Plain, Rigid
from stages.analytic.model.stiffness import attainable_tolerance, compliant
from stages.analytic.model.walker import Vector, Walker


@dataclass(frozen=True)
class Anchor:
    """A gait: numbers of its walker (f,), section coordinates (j,), and `slopes` (j, f): their derivatives by these."""

    numbers: Vector
    z: Vector
    slopes: np.ndarray
    stable: bool

    @classmethod
    def of(cls, plain: Sequence[Any]) -> Anchor:
        """The anchor that `plain` tells of."""
        numbers, z, slopes, stable = plain
        return cls(np.array(numbers), np.array(z), np.array(slopes).reshape(len(z), -1), stable)

    @property
    def plain(self) -> list[Any]:
        """Numbers, coordinates, slopes by rows, and whether the gait is stable."""
        return [self.numbers.tolist(), self.z.tolist(), self.slopes.ravel().tolist(), self.stable]

    def towards(self, numbers: Vector) -> Vector:
        """Coordinates of the gait of a walker with other numbers, along the tangent."""
        predicted: Vector = self.z + self.slopes @ (numbers - self.numbers)
        return predicted


def anchor(walker: Walker, point: FixedPoint, tolerance: float) -> Anchor | None:
    """The gait as an anchor; None on a fold, or where its steps cannot be taken with their derivatives.

    Of a detailed walker it is always that of a stride: the legs of its neighbours may differ where its own do not.
    """
    along, steps = np.eye(len(walker.p)), 1 if isinstance(walker.p, Plain) else 2
    try:
        end = walk_derivatives(walker, point.z, along, steps, attainable_tolerance(walker.p, tolerance))[-1]
        slopes = np.linalg.solve(np.eye(point.z.size) - end.by_start, end.along)
    except (StepFailed, np.linalg.LinAlgError):
        return None
    return Anchor(np.array(walker.p), point.z, slopes, by_stability(point) < 1)


def with_numbers(walker: Walker, numbers: Vector) -> Walker:
    """The walker with other numbers, in the same units."""
    values = tuple(numbers.tolist())
    if isinstance(walker.p, Rigid):
        kind: Any = type(walker.p)
        return dataclasses.replace(walker, p=kind(*values))
    return dataclasses.replace(walker, p=compliant(values))


class Anchors:
    """Anchors, nearest first: a number counts by how much it moves the gaits."""

    def __init__(self, known: Sequence[Anchor]) -> None:
        fields = max((each.numbers.size for each in known), default=0)  # a hip without friction has a number less
        self.known = [each for each in known if each.numbers.size == fields]
        self._numbers = np.array([each.numbers for each in self.known])
        moves = [np.linalg.norm(each.slopes, axis=0) for each in self.known]
        self._weights = np.median(moves, axis=0) if known else np.ones(1)

    def distances(self, numbers: np.ndarray, other: Vector) -> Vector:
        """How far walkers with these numbers (n, f) are from another, `other` (f,)."""
        weights = self._weights if self._weights.size in (1, other.size) else np.ones(1)
        far: Vector = np.linalg.norm((numbers - other) * weights, axis=1)
        return far

    def nearest(self, numbers: Vector, count: int) -> list[Anchor]:
        """Up to `count` anchors, the nearest first."""
        if not self.known or self._numbers.shape[1] != numbers.size:
            return []
        order = np.argsort(self.distances(self._numbers, numbers), kind="stable")
        return [self.known[row] for row in order[:count].tolist()]
