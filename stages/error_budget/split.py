"""A difference of hip motion split into signed contributions that add up exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stages.biped.quantity import quantity
from stages.error_budget.effects import EFFECTS, UNEXPLAINED

#: Columns of a curve.
POSITION, VELOCITY = slice(0, 2), slice(2, 4)


@dataclass(frozen=True)
class Split:
    """Contributions of `EFFECTS`, in their order, to the difference penalty model minus constraint model."""

    parts: np.ndarray = quantity("m, m/s", "contributions to hip x, y and their rates, shape (7, n, 4)")
    compared: np.ndarray = quantity("1", "where velocities are compared: outside of impacts, shape (n,)")

    @property
    def total(self) -> np.ndarray:
        """The whole difference, (n, 4)."""
        return np.asarray(self.parts.sum(axis=0))

    def part(self, effect: str) -> np.ndarray:
        """The contribution of one effect, (n, 4)."""
        return np.asarray(self.parts[EFFECTS.index(effect)])

    def _rows(self, curve: np.ndarray, columns: slice) -> np.ndarray:
        return curve[self.compared if columns is VELOCITY else slice(None), columns]

    def rms(self, curve: np.ndarray, columns: slice) -> float:
        """Rms of a curve (n, 4) over x and y together."""
        return float(np.sqrt((self._rows(curve, columns) ** 2).sum(axis=1).mean()))

    def peak(self, curve: np.ndarray, columns: slice) -> float:
        """Largest magnitude of a curve (n, 4) in x or y."""
        return float(np.abs(self._rows(curve, columns)).max())

    def explained(self, columns: slice) -> float:
        """Share of the rms difference that is explained: 1 - rms(unexplained) / rms(total)."""
        return _share(self.rms(self.part(UNEXPLAINED), columns), self.rms(self.total, columns))

    def explained_peak(self, columns: slice) -> float:
        """The same of the largest difference."""
        return _share(self.peak(self.part(UNEXPLAINED), columns), self.peak(self.total, columns))


def _share(rest: float, whole: float) -> float:
    return 1.0 - rest / whole if whole > 0.0 else float("nan")


def telescoped(values: Sequence[np.ndarray]) -> np.ndarray:
    """Differences of successive values along a path: they add up to the last less the first."""
    return np.array([after - before for before, after in pairwise(values)])
