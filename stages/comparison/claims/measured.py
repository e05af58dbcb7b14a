"""What a claim is made of: numbers that were measured, and their judgement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from stages.comparison.claims.verdict import Judgement
from stages.comparison.parameters import Settings


@dataclass(frozen=True)
class Measured:
    """What is measured for one claim. A subclass holds its numbers and judges them.

    `ID` is the claim's name in `stages.comparison.claims.paper`; `RESTS_ON` are the parameters, file.key, other than
    the biped's that the numbers follow from. A claim on the `METHOD` alone is judged for every biped with compliant
    legs, all others for the paper's biped only. `UNITS`: a unit and the names of the numbers that have it.
    """

    ID: ClassVar[str]
    RESTS_ON: ClassVar[tuple[str, ...]] = ()
    METHOD: ClassVar[bool] = False
    UNITS: ClassVar[tuple[tuple[str, str], ...]] = ()

    def unit(self, name: str) -> str:
        """Unit of one of its numbers, "1" for one without."""
        field = name.partition(".")[0]
        return next((unit for unit, names in self.UNITS if field in names.split()), "1")

    def judge(self, limits: Settings) -> Judgement:
        """The verdict within the limits of the comparison."""
        raise NotImplementedError


@dataclass(frozen=True)
class Unmeasured:
    """In place of the numbers of a claim: why there are none."""

    claim: type[Measured]
    why: str
