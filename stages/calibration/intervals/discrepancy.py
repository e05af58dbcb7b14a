"""What a model puts wrong, told by fits of runs of a better one whose truth is known.

An error that is alike in every step, like a contact that is softer than the model's, scatters nowhere: no residual of a
run tells it. Fits of other runs of the study's twin do. What they miss on average is taken off, their scatter over
builds, starts and ramps is the interval.

A fit can show itself how far its model pulled it: the ingest knows sensors' clocks to a few parts in ten thousand, and
a fit that moves them by a thousandth has misses that go along with that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from stages.analytic.model.walker import Vector
from stages.calibration.result import HALF_WIDTH, Misses

#: How many more runs than coefficients tell a scatter at all.
SPARE = 2
#: How sure it is that an interval holds what it says: a scatter of few runs may be too small by luck, and then all
#: intervals of the study are.
SURE = 0.9


@dataclass(frozen=True)
class Discrepancy:
    """What fits of a model miss, estimate less truth, in shares of the drawing's values: on average `mean` (n,), and by
    `slope` (n,) more for each unit that a fit is pulled more than `pull`; covariance (n, n) about that.

    From `count` runs with pulls of the mean square `width`, zero where the pull was not looked at.
    """

    names: tuple[str, ...]
    mean: Vector
    slope: Vector
    covariance: np.ndarray
    count: int
    pull: float = 0.0
    width: float = 0.0

    @classmethod
    def of(cls, names: tuple[str, ...], misses: np.ndarray, pulls: Vector | None = None) -> Discrepancy:
        """From misses (count, n), by the pulls (count,) of their fits if these are given. Raises ValueError where there
        are too few."""
        count, n = misses.shape
        coefficients = 1 if pulls is None else 2
        if count < coefficients + SPARE:
            raise ValueError(f"a scatter needs {coefficients + SPARE} runs at least")
        mean, slope, middle, width = misses.mean(axis=0), np.zeros(n), 0.0, 0.0
        left = misses - mean
        if pulls is not None:
            middle = float(pulls.mean())
            off = pulls - middle
            width = float((off**2).mean())
            slope = off @ left / (count * width) if width else slope
            left = left - np.outer(off, slope)
        return cls(names, mean, slope, left.T @ left / (count - coefficients), count, middle, width)

    @classmethod
    def told(cls, names: tuple[str, ...], misses: Misses) -> Discrepancy | None:
        """From what a study's runs miss; none where too few tell it."""
        try:
            return cls.of(names, misses.shares, misses.pulls)
        except ValueError:
            return None

    def factor(self, pull: float) -> float:
        """Half widths in standard deviations for a fit with that pull: of a Gaussian tolerance interval, which holds
        95 % of further runs' errors in 90 % of the studies that are made (W. G. Howe, J. Am. Stat. Assoc. 64, 1969,
        610; along a line, W. A. Wallis, 2nd Berkeley Symposium, 1951, 43)."""
        free = self.count - (2 if self.width else 1)
        apart = (pull - self.pull) ** 2 / self.width if self.width else 0.0
        return HALF_WIDTH * float(np.sqrt(free * (1.0 + (1.0 + apart) / self.count) / chdtri(free, SURE)))

    def expected(self, scales: Vector, pull: float = 0.0) -> Vector:
        """What a fit with that pull misses on average, (n,)."""
        return np.asarray((self.mean + self.slope * (pull - self.pull)) * scales)

    def spread(self, scales: Vector, pull: float = 0.0) -> np.ndarray:
        """Covariance (n, n) of a Gaussian whose 95 % intervals are as wide as those about one more run's estimate."""
        return np.asarray((self.factor(pull) / HALF_WIDTH) ** 2 * self.covariance * np.outer(scales, scales))

    def half_widths(self, scales: Vector, pull: float = 0.0) -> Vector:
        """Half of 95 % intervals (n,) about one more run's estimate less what it misses on average."""
        return HALF_WIDTH * np.asarray(np.sqrt(np.diag(self.spread(scales, pull))))
