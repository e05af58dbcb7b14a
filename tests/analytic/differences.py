"""Derivatives of the step map by differences, which the exact ones are held against."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from stages.analytic.derivatives.numbers import moved
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import step_length
from stages.analytic.gait.poincare import fixed_point, poincare_map
from stages.analytic.model.walker import Vector, Walker


def map_slope(walker: Walker, z: Vector, sizes: tuple[float, ...]) -> np.ndarray:
    """The map's derivative (n, n) by extrapolated central differences of these sizes (n,)."""
    columns = []
    for index, size in enumerate(sizes):
        step = np.zeros(len(sizes))
        step[index] = 1.0
        columns.append(extrapolated(lambda h: poincare_map(walker, z + h * step, 1e-13).z, size))  # noqa: B023
    return np.array(columns).T


def together(sizes: Vector, count: int) -> Iterator[tuple[np.ndarray, Vector]]:
    """Numbers, by their rows, whose derivatives may be held against one difference along all of them: about `count` at
    once, of derivatives that are about as large, with weights that let none of them drown the others.
    """
    generator = np.random.default_rng(5)
    for rows in np.array_split(np.argsort(sizes), -(-len(sizes) // count)):
        signs = generator.choice([-1.0, 1.0], len(rows))
        yield rows, signs * np.minimum(np.median(sizes[rows]) / sizes[rows], 1.0)


def extrapolated(there: Callable[[float], Vector], size: float, levels: int = 2) -> Vector:
    """Derivative at zero by central differences of `size`, of half of it and so on, extrapolated (Romberg)."""
    row = [(there(h) - there(-h)) / (2 * h) for h in (size / 2**level for level in range(levels))]
    for order in range(1, levels):
        row = [(4**order * fine - coarse) / (4**order - 1) for coarse, fine in pairwise(row)]
    return np.asarray(row[0])


def shares(walker: Walker, names: Sequence[str]) -> np.ndarray:
    """A whole share of each of these numbers of a walker, or a thousandth where that is less, as rows."""
    along = np.zeros((len(names), len(walker.p)))
    for row, name in enumerate(names):
        along[row, walker.p._fields.index(name)] = max(abs(getattr(walker.p, name)), 1e-3)
    return along


def step_slope(walker: Walker, z: Vector, change: Vector, size: float) -> Vector:
    """Derivative of a step's section coordinates and, at last, its period along a change of the walker's numbers."""

    def there(share: float) -> Vector:
        step = poincare_map(moved(walker, share * change), z, 1e-13)
        return np.append(step.z, step.period)

    return extrapolated(there, size)


def gait_slope(design: DesignPoint, z: Vector, weights: Mapping[str, float], size: float = 2e-4) -> Vector:
    """Derivatives (2,) of period [s] and step length [m] of the gait near `z` for parameters that change together, each
    by so many whole shares.
    """

    def there(share: float) -> Vector:
        walker = design.with_values(
            {name: design.value(name) * (1 + share * weight) for name, weight in weights.items()}).walker()
        found = fixed_point(walker, z, 1e-13)
        assert found is not None
        return np.array([found.period * walker.time, step_length(walker, found) * walker.length])

    return extrapolated(there, size)
