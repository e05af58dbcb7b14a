"""The limit of a share, from three of them that halve, and what shows whether it can be trusted.

Every length and every speed of contact that is switched off is the part s of its size, so f(s) = f(0) + a s + b s^2
and f(0) = (8 f(s) - 6 f(2 s) + f(4 s)) / 3 (Richardson and Gaunt, 1927). Two numbers check that: the order that three
shares show, and how far the last share is from what the other two foretell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from stages.biped.quantity import quantity
from stages.error_budget.split import rms_of_columns

#: The order in the share in which an effect vanishes.
ORDER = 1


class Shares(NamedTuple):
    """An outcome with four times, twice and once the share, of one shape each."""

    far: np.ndarray
    middle: np.ndarray
    near: np.ndarray

    @property
    def limit(self) -> np.ndarray:
        """The outcome for a share of zero; what is left in the first two orders cancels."""
        return np.asarray((8.0 * self.near - 6.0 * self.middle + self.far) / 3.0)

    @property
    def foretold(self) -> np.ndarray:
        """The last share from the other two, by the first order."""
        return np.asarray(self.middle + (self.middle - self.far) / 2.0**ORDER)


@dataclass(frozen=True)
class Convergence:
    """How limits are approached: rows with both effects off, impact off, creep off, columns as in a curve."""

    share: float = quantity("1", "the last share", symbol="s")
    order: np.ndarray = quantity("1", "order in the share that three shares show in the rms, shape (3, 4)")
    missed: np.ndarray = quantity("m, m/s", "rms of the last share less what the other two foretell, shape (3, 4)")

    @classmethod
    def of(cls, share: float, curves: Sequence[Shares], compared: np.ndarray) -> Convergence:
        """From curves (n, 4) of the hip, of which rates are compared where `compared` (n,) says so."""
        falls = [
            [rms_of_columns(curve, compared) for curve in (far - middle, middle - near)] for far, middle, near in curves
        ]
        order = np.log2([before / after for before, after in falls])
        missed = [rms_of_columns(shares.near - shares.foretold, compared) for shares in curves]
        return cls(share, order, np.array(missed))
