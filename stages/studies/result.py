"""What results of studies share: tables, rows as columns, the check of the compiled penalty walker against Exudyn."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy as np

from stages.biped.quantity import quantity

#: Title, heads of the columns, rows.
Table = tuple[str, Sequence[str], Sequence[Sequence[object]]]
COMPLETED = "completed"
T = TypeVar("T")
#: In an outcome of two walks that did not end alike.
BUT = " but "


def shown(*values: float) -> tuple[float, ...]:
    """Rounded for a table."""
    return tuple(float(f"{value:.3g}") for value in values)


def as_columns(kind: type[T], rows: Sequence[Mapping[str, Any]], **whole: Any) -> T:
    """Rows as a result whose fields are columns: words as tuples, numbers as arrays. `whole` has what is no column."""
    found = dict(whole)
    for field in fields(kind):  # type: ignore[arg-type]
        if field.name not in whole:
            values = [row[field.name] for row in rows]
            found[field.name] = tuple(values) if str(field.type).startswith("tuple") else np.array(values)
    return kind(**found)


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
        points = f"{count} sampled points" if (count := len(self.distances)) != 1 else "a sampled point"
        return f"within {self.largest:.0e} m of Exudyn at {points}"

    def table(self) -> Table:
        """Row by row."""
        heads = ("", "outcome", "distance m", "own error m", "allowed m")
        return "The compiled penalty walker against Exudyn", heads, [
            (one.what, one.outcome, *(float(f"{value:.2g}") for value in (one.distance, one.own_error, one.allowed)))
            for one in self.distances
        ]  # fmt: skip


def drawn(count: int, among: int, seed: int, hard: Sequence[int] = ()) -> list[int]:
    """So many of the numbers below `among`: the `hard` ones first, then drawn by the seed."""
    others = np.random.default_rng(seed).permutation([number for number in range(among) if number not in hard])
    return [*hard, *others.tolist()][:count]
