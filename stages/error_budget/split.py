"""A difference of hip motion split into signed contributions that add up exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stages.biped.quantity import quantity
from stages.error_budget.effects import CREEP, EFFECTS, IMPACT, UNEXPLAINED

#: Columns of a curve.
POSITION, VELOCITY = slice(0, 2), slice(2, 4)
#: Each for itself: hip x, y and their rates.
EACH = tuple(slice(column, column + 1) for column in range(4))


def orders(parts: np.ndarray, interaction: np.ndarray) -> np.ndarray:
    """Contributions (6, ...) with creep switched on first, and with the impact first: (2, 6, ...)."""
    both = np.stack([parts, parts])
    both[:, EFFECTS.index(CREEP)] += np.stack([interaction, -interaction])
    both[:, EFFECTS.index(IMPACT)] -= np.stack([interaction, -interaction])
    return both


@dataclass(frozen=True)
class Split:
    """Contributions of `EFFECTS`, in their order, to the difference penalty model minus constraint model.

    What an effect of contact does depends on whether the other is on. `parts` has the mean over both orders (for two
    effects Shapley's value); creep switched on first has `interaction` more, switched on last as much less, and the
    impact the opposite.
    """

    parts: np.ndarray = quantity("m, m/s", "contributions to hip x, y and their rates, shape (6, n, 4)")
    interaction: np.ndarray = quantity("m, m/s", "what creep has more where it is switched on first, shape (n, 4)")
    compared: np.ndarray = quantity("1", "where velocities are compared: outside of impacts, shape (n,)")

    @property
    def total(self) -> np.ndarray:
        """The whole difference, (n, 4)."""
        return np.asarray(self.parts.sum(axis=0))

    @property
    def orders(self) -> np.ndarray:
        """Contributions with creep switched on first, and with the impact first: (2, 6, n, 4)."""
        return orders(self.parts, self.interaction)

    def part(self, effect: str) -> np.ndarray:
        """The contribution of one effect, (n, 4)."""
        return np.asarray(self.parts[EFFECTS.index(effect)])

    def interval(self, effect: str) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest contribution of an effect over both orders, (n, 4) each."""
        first, last = self.orders[:, EFFECTS.index(effect)]
        return np.minimum(first, last), np.maximum(first, last)

    def _rows(self, curve: np.ndarray, columns: slice) -> np.ndarray:
        return curve[self.compared if columns.start >= VELOCITY.start else slice(None), columns]

    def rms(self, curve: np.ndarray, columns: slice) -> float:
        """Rms of a curve (n, 4) over the columns together."""
        return float(np.sqrt((self._rows(curve, columns) ** 2).sum(axis=1).mean()))

    def along(self, curve: np.ndarray, columns: slice) -> float:
        """What a curve (n, 4) has of the rms of the whole: its mean product with it over that. Adds up as curves do."""
        product = (self._rows(curve, columns) * self._rows(self.total, columns)).sum(axis=1).mean()
        return float(product) / self.rms(self.total, columns)

    def peak(self, curve: np.ndarray, columns: slice) -> float:
        """Largest magnitude of a curve (n, 4) in the columns."""
        return float(np.abs(self._rows(curve, columns)).max())

    def explained(self, columns: slice) -> float:
        """Share of the rms difference that is explained: 1 - rms(unexplained) / rms(total)."""
        return _share(self.rms(self.part(UNEXPLAINED), columns), self.rms(self.total, columns))


def _share(rest: float, whole: float) -> float:
    return 1.0 - rest / whole if whole > 0.0 else float("nan")


def rms_of_columns(curve: np.ndarray, compared: np.ndarray) -> np.ndarray:
    """Rms of each column of a curve (n, 4), of rates where `compared` (n,): (4,)."""
    return np.sqrt([(curve[compared if column >= 2 else slice(None), column] ** 2).mean() for column in range(4)])


def telescoped(values: Sequence[np.ndarray]) -> np.ndarray:
    """Differences of successive values along a path: they add up to the last less the first."""
    return np.array([after - before for before, after in pairwise(values)])
