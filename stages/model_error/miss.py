"""What each rung misses of the twin: a bias that follows the design's numbers, and the spread that is left.

A miss is the logarithm of the better model's measure over the rung's, or for multipliers their difference. The penalty
walker's gaits are many; the twin's few, and near it. So a rung's miss is that of the penalty walker, by a ridge
regression over all drawn designs, and on top of it what the twin's draws leave of the penalty walker.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from stages.model_error.result import COVERED, FEWEST, FITTED, PENALTY, SHARED, TWIN, Result

#: Prior sizes of the slopes over the spread of the misses; leaving one out decides among them.
PRIORS = (0.0, 0.1, 0.3, 1.0, 3.0)
#: Half width that a number of all draws alike is given, as a share of its size.
ALIKE = 0.25


@dataclass(frozen=True)
class Miss:
    """A rung's bias in one measure at one design, and its error: what it may miss beside that.

    The error covers what so many draws leave open, its `freedom`.
    """

    bias: float
    error: float
    freedom: float = np.inf

    @property
    def spread(self) -> float:
        """The standard deviation of what it misses."""
        return self.error / covering(self.freedom)


def covering(freedom: float) -> float:
    """Half width, in standard deviations that so many draws tell, of what is covered by an error."""
    factor: float = student.ppf(0.5 + 0.5 * COVERED, freedom)
    return factor


@dataclass(frozen=True)
class Ridge:
    """A linear fit with slopes that a prior keeps small, and the error at the mean of the draws."""

    coefficients: np.ndarray
    inverse: np.ndarray
    error: float
    freedom: float

    def at(self, terms: np.ndarray) -> Miss:
        """Bias and error at terms (p,)."""
        wider = float(np.sqrt(1.0 + terms @ self.inverse @ terms))
        return Miss(float(terms @ self.coefficients), wider * self.error, self.freedom)


def ridge(terms: np.ndarray, misses: np.ndarray) -> Ridge:
    """The fit of misses (n,) by terms (n, p), the first of them constant, with the prior that leaves least open."""
    found = []
    for prior in PRIORS:
        penalty = np.full(terms.shape[1], 1.0 / prior**2 if prior else np.inf)
        penalty[0] = 0.0
        used = np.isfinite(penalty)
        some = terms[:, used]
        inverse = np.zeros((terms.shape[1],) * 2)
        inverse[np.ix_(used, used)] = np.linalg.inv(some.T @ some + np.diag(penalty[used]))
        coefficients = inverse @ terms.T @ misses
        leverage = np.einsum("ij,jk,ik->i", terms, inverse, terms)
        left = (misses - terms @ coefficients) / (1.0 - leverage)
        freedom = max(len(misses) - float(leverage.sum()), 1.0)
        found.append(Ridge(coefficients, inverse, covering(freedom) * float(np.sqrt(np.mean(left**2))), freedom))
    return min(found, key=lambda one: np.mean([one.at(each).error for each in terms]))


class Learnt:
    """The misses of all rungs, from the draws of a result."""

    def __init__(self, result: Result) -> None:
        self.kind, self.numbers = result.kind, result.numbers
        low, high = self.numbers.min(axis=0), self.numbers.max(axis=0)
        self.middle, self.half = 0.5 * (low + high), 0.5 * (high - low)
        alike = self.half <= 1e-9 * np.abs(self.middle)
        self.half = np.where(alike, np.maximum(ALIKE * np.abs(self.middle), 1e-9), self.half)
        self.alike = alike
        with np.errstate(invalid="ignore", divide="ignore"):
            seen = np.where(SHARED, np.log(result.values), result.values)
        stable = result.values[:, :, -1] < 1.0
        self.fits: dict[tuple[int, int], Ridge] = {}
        self.rest, self.twins = np.full(len(SHARED), np.inf), 1.0
        self.count = 0
        for rung in range(PENALTY):
            both = stable[rung] & stable[PENALTY]
            self.count = int(both.sum())
            for measure in range(len(SHARED) if both.sum() >= FEWEST else 0):
                misses = (seen[PENALTY] - seen[rung])[both, measure]
                if np.isfinite(misses).all():  # else the rung has no such measure
                    self.fits[rung, measure] = ridge(self.terms(self.numbers[both]), misses)
        both = stable[PENALTY] & stable[TWIN]
        if both.any():
            self.twins = float(both.sum())
            self.rest = covering(self.twins) * np.sqrt(np.mean((seen[TWIN] - seen[PENALTY])[both] ** 2, axis=0))

    def terms(self, numbers: np.ndarray) -> np.ndarray:
        """Terms (n, p) of the fits at numbers (n, k): a constant, and the first of them in half widths of the draws."""
        scaled = np.where(self.alike, 0.0, (numbers - self.middle) / self.half)[:, :len(FITTED)]
        columns: np.ndarray = np.column_stack([np.ones(len(scaled)), scaled])
        return columns

    def outside(self, numbers: np.ndarray) -> np.ndarray:
        """By how many half widths each number (p,) lies outside of what was drawn."""
        beyond = np.abs(numbers - self.middle) / self.half - np.where(self.alike, 0.0, 1.0)
        return np.asarray(np.maximum(beyond, 0.0))

    def at(self, rung: int, measure: int, numbers: np.ndarray) -> Miss:
        """What a rung misses at a design of these numbers (p,); infinite where nothing is known."""
        rest = float(self.rest[measure])
        if rung == TWIN:
            return Miss(0.0, 0.0)
        if rung == PENALTY:
            return Miss(0.0, rest * (1.0 + float(self.outside(numbers).sum())), self.twins)
        fit = self.fits.get((rung, measure))
        if fit is None:
            return Miss(0.0, np.inf)
        inside = np.clip(numbers, self.middle - self.half, self.middle + self.half)
        miss = fit.at(self.terms(inside[None])[0])
        beyond = float(self.outside(numbers).sum())
        error = float(np.hypot(miss.error, rest)) * (1.0 + beyond) + abs(miss.bias) * beyond
        return Miss(miss.bias, error, miss.freedom)
