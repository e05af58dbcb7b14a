"""What a claim is made of: a sentence of the paper, what is measured of it, and how that is judged."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from stages.comparison.evidence import Evidence
from stages.comparison.parameters import Settings
from stages.comparison.result import OPEN, Judgement
from stages.comparison.stride import NoEvidence

#: In place of a unit: each row of the numbers says its own, its second word.
OF_ITS_ROW = "of its row"


@dataclass(frozen=True)
class Statement:
    """A sentence of the paper: where it stands, its words, the quantity and limit that they imply, and its judgement.
    `plain` says it in one sentence that needs none of its terms.

    `measure` gives the numbers in the order in which `judge` takes them, after the limits of the comparison: each has
    the name that it has there. `rests_on` are the parameters, file.key, other than the biped's that they follow from;
    `units` a unit and the names of the numbers that have it. A statement on the `method` alone is judged for every
    biped with compliant legs, all others for the paper's biped only.
    """

    id: str
    section: str
    words: str
    implies: str
    measure: Callable[[Evidence], tuple[Any, ...]]
    judge: Callable[..., Judgement]
    rests_on: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    method: bool = False
    plain: str = field(kw_only=True)

    def measured(self, e: Evidence) -> Measured:
        """The numbers, or why there are none."""
        try:
            return self.of(*self.measure(e))
        except NoEvidence as error:
            return Measured(self, {}, str(error))

    def of(self, *numbers: Any) -> Measured:
        """These numbers by their names."""
        _, *names = inspect.signature(self.judge).parameters
        return Measured(self, dict(zip(names, numbers, strict=True)))


@dataclass(frozen=True)
class Measured:
    """The numbers of a statement by their names; without any, why there are none."""

    about: Statement
    numbers: Mapping[str, Any]
    why: str = ""

    def unit(self, name: str) -> str:
        """Unit of one of its numbers, "1" for one without."""
        key, *places = name.split(".")
        unit = next((unit for unit, names in self.about.units.items() if key in names.split()), "1")
        if unit != OF_ITS_ROW:
            return unit
        _, own, *_ = (word for word in self.numbers[key][int(places[0])] if isinstance(word, str))
        return own

    def judge(self, limits: Settings) -> Judgement:
        """The verdict within the limits of the comparison; what was not measured stays open."""
        if self.why:
            return Judgement(f"nothing: {self.why}", OPEN, ((True, self.why),))
        return self.about.judge(limits, **self.numbers)
