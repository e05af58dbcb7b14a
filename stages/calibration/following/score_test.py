"""Whether readings are of the robot that was fitted, and which of its parts has changed: the test, whoever reads.

Under the hypothesis that nothing has changed, a part pulls on what a fit leaves by its score (C. R. Rao, Proc. Camb.
Phil. Soc. 44, 1948, 50), whose variance is the readings' information of the part with everything else eliminated. Score
over variance is the change, with its error. Parts and residuals together raise no more than `LEVEL` alarms by chance.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from scipy.special import stdtr

from stages.analytic.model.walker import Vector

#: Of runs of the same robot so many are said to be another's; of these, the share that all parts and the size of the
#: residuals have (Bonferroni).
LEVEL = 0.01
PARTS, RESIDUALS = 0.9, 0.1
#: Two parts cannot be distinguished where what they explain differs by no more than this in chi-square.
ALIKE = 2.0


@dataclass(frozen=True)
class Part:
    """What may change: its name, the unknowns that go with a change of it by one `unit`, and the robot's own value,
    where it has one. What is turned in a recording moves no unknown."""

    name: str
    unit: str = ""
    moves: tuple[str, ...] = ()
    value: float = math.nan


@dataclass(frozen=True)
class Change:
    """How much a part would have changed, with its standard error, which has a `freedom` (Student's), and what it
    `explains` of the run in chi-square."""

    part: Part
    change: float
    sd: float
    explains: float
    freedom: float = math.inf

    @property
    def sigmas(self) -> float:
        """Size of the change in its standard errors."""
        return abs(self.change) / self.sd


@dataclass(frozen=True)
class Verdict:
    """The probability that the same robot looks so different, by all tests together; changes of the parts, the most
    telling first; the residuals over those of the robot; whether they are as that robot's where the first part has
    changed."""

    probability: float
    changes: tuple[Change, ...]
    residuals: float
    explained: bool

    @property
    def same(self) -> bool:
        """Whether nothing says that it is another robot."""
        return self.probability >= LEVEL

    @property
    def named(self) -> tuple[Change, ...]:
        """The part that explains most, and those that cannot be distinguished from it."""
        return tuple(one for one in self.changes if one.explains > self.changes[0].explains - ALIKE)


def shifts(score: Vector, information: np.ndarray) -> np.ndarray:
    """By how much each of c parts would have changed, and the standard error, (c, 2), by their scores (c,) and the
    information (c, c) of them."""
    variance = np.diag(information)
    return np.column_stack([score / variance, variance**-0.5])


def by_chance(number: float, freedom: float = math.inf) -> float:
    """The probability that one so many standard errors above what is usual is chance."""
    return float(stdtr(freedom, -number))


def verdict(changes: Iterable[Change], residuals: float, of_residuals: float) -> Verdict:
    """Whether it is the same robot: by what parts would have changed, and by the `residuals` over the robot's, with the
    probability `of_residuals` that its own are so large."""
    found = sorted(changes, key=attrgetter("explains"), reverse=True)
    of_parts = 2.0 * len(found) * min(by_chance(one.sigmas, one.freedom) for one in found)
    return Verdict(min(1.0, of_parts / PARTS, of_residuals / RESIDUALS), tuple(found), residuals, of_residuals >= LEVEL)
