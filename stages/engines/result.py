"""What a study keeps of the check of its compiled penalty walker against Exudyn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity

Table = tuple[str, tuple[str, ...], list[tuple[object, ...]]]
#: In an outcome of two walks that did not end alike.
BUT = " but "


class EnginesDisagree(Exception):
    """The compiled penalty walker is farther from Exudyn than it may be; the message says where and by how much."""


@dataclass(frozen=True)
class Distance:
    """The distance of one walk, or of one cycle, and what it may be."""

    what: str = quantity("-", "what was walked by both")
    outcome: str = quantity("-", "how both walks ended, or how each did if not alike")
    distance: float = quantity("m", "largest distance of the hip over the walk, or of a cycle's lengths")
    own_error: float = quantity(
        "m", "the larger of the models' own errors, each by a tolerance ten times looser; NaN if not measured"
    )
    allowed: float = quantity("m", "what the distance may be")

    @property
    def fine(self) -> bool:
        """Whether both ended alike, and the distance is allowed."""
        return BUT not in self.outcome and self.distance <= self.allowed


@dataclass(frozen=True)
class EngineAgreement:
    """How far the study's compiled penalty walker is from Exudyn, at points of the study drawn by a seed."""

    seed: int = quantity("1", "seed of the draw")
    distances: tuple[Distance, ...] = quantity("-", "walks and cycles, all of them as near as they may be")

    def __post_init__(self) -> None:
        """Raises EnginesDisagree."""
        for one in self.distances:
            if not one.fine:
                raise EnginesDisagree(
                    f"the compiled penalty walker and Exudyn disagree on {one.what}: {one.outcome}, "
                    f"{one.distance:.2g} m apart where {one.allowed:.2g} m is allowed"
                )

    @property
    def largest(self) -> float:
        """The largest distance [m]."""
        return max((one.distance for one in self.distances), default=float("nan"))

    def sentence(self) -> str:
        """What was checked, in one clause."""
        return f"within {self.largest:.0e} m of Exudyn at {len(self.distances)} drawn points"

    def table(self) -> Table:
        """Row by row."""
        rows: list[tuple[object, ...]] = [
            (one.what, one.outcome, *(float(f"{value:.2g}") for value in (one.distance, one.own_error, one.allowed)))
            for one in self.distances
        ]
        heads = ("", "outcome", "distance m", "own error m", "allowed m")
        return "The compiled penalty walker against Exudyn", heads, rows


def drawn(count: int, among: int, seed: int, hard: Sequence[int] = ()) -> list[int]:
    """So many of the numbers below `among`: the `hard` ones first, then drawn by the seed."""
    others = np.random.default_rng(seed).permutation([number for number in range(among) if number not in hard])
    return [*hard, *others.tolist()][:count]
