"""How the engine declares what it reads itself: fields with unit, bound and choices, as stages declare parameters."""

from __future__ import annotations

import dataclasses
import math
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
