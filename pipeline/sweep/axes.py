"""One varied parameter of a sweep: from a share between 0 and 1 to a value; and how a sweep declares what it reads.

Fields have unit, bound and choices, as stages declare parameters.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, NamedTuple


class Between(NamedTuple):
    """Limits of a number, both allowed."""

    least: float = -math.inf
    most: float = math.inf

    def holds(self, value: float) -> bool:
        """Whether `value` is finite and keeps to the limits."""
        return math.isfinite(value) and self.least <= value <= self.most

    def __str__(self) -> str:
        limits = ((">=", self.least), ("<=", self.most))
        return " and ".join(f"{sign} {limit:g}" for sign, limit in limits if math.isfinite(limit)) or "any number"


class Broken(NamedTuple):
    """A rule between several values that does not hold: the key to blame, and what is allowed."""

    key: str
    allowed: str


_ANY = Between()


def entry(
    description: str, *, unit: str = "1", bound: Between | str = _ANY, choices: tuple[str, ...] = (),
    default: Any = dataclasses.MISSING,
) -> Any:  # fmt: skip
    """A field of a dataclass that is read from a file. `bound` limits a number, or says in words what is allowed."""
    metadata = {"unit": unit, "description": description, "bound": bound, "choices": choices}
    return dataclasses.field(metadata=metadata, default=default)


@dataclass(frozen=True)
class Range:
    """Values from `low` to `high`, evenly spread, or evenly in the logarithm; `steps` of them in a grid."""

    low: float = entry("least value")
    high: float = entry("largest value")
    steps: int | None = entry("values in a grid, both ends among them", bound=Between(2), default=None)
    scale: str = entry("how they are spread", choices=("linear", "log"), default="linear")

    def broken_rules(self) -> Iterator[Broken]:
        """Rules between the values that do not hold."""
        if self.high <= self.low:
            yield Broken("high", f"> low = {self.low:g}")
        if self.scale == "log" and self.low <= 0:
            yield Broken("low", "> 0 where the scale is log")

    def at(self, share: float) -> float:
        """The value at `share` of the way, in [low, high]."""
        if self.scale == "log":
            value = math.exp(math.log(self.low) + share * (math.log(self.high) - math.log(self.low)))
        else:
            value = self.low + share * (self.high - self.low)
        return min(max(value, self.low), self.high)

    def values(self) -> list[Any]:
        """The values of a grid, both ends included."""
        count = self.steps or 1
        return [self.at(index / (count - 1)) if count > 1 else self.low for index in range(count)]

    def extremes(self) -> list[Any]:
        """Values to check before anything runs."""
        return [self.low, self.high]


@dataclass(frozen=True)
class Normal:
    """Normally distributed values."""

    mean: float = entry("mean")
    deviation: float = entry("standard deviation")

    def broken_rules(self) -> Iterator[Broken]:
        """Rules that do not hold."""
        if self.deviation <= 0:
            yield Broken("deviation", "> 0")

    def at(self, share: float) -> float:
        """The quantile of `share`; the ends of the interval stay finite."""
        return NormalDist(self.mean, self.deviation).inv_cdf(min(max(share, 1e-16), 1 - 1e-16))

    def values(self) -> list[Any]:
        """A distribution has no grid; the spec refuses it before."""
        return [self.mean]

    def extremes(self) -> list[Any]:
        """The mean must be a legal value; what lies too far out becomes a row that says so."""
        return [self.mean]


@dataclass(frozen=True)
class Choice:
    """Given values, each as likely as the others."""

    options: tuple[Any, ...]

    def at(self, share: float) -> Any:
        """The option whose equal part of the interval holds `share`."""
        return self.options[min(int(share * len(self.options)), len(self.options) - 1)]

    def values(self) -> list[Any]:
        """All options in order."""
        return list(self.options)

    def extremes(self) -> list[Any]:
        """Every option must be legal."""
        return list(self.options)


Axis = Range | Normal | Choice
