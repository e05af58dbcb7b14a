"""How accurate the whole study is to be. Parameter files say what a value is at each level."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from stages.biped.quantity import parameter

DRAFT, PAPER, REFERENCE = LEVELS = ("draft", "paper", "reference")


@dataclass(frozen=True)
class Level:
    """The level of the study, the least accurate first: every artefact says at which it was made."""

    FILE: ClassVar[str] = "accuracy"

    level: str = parameter("-", "accuracy of the whole study", choices=LEVELS, default=PAPER)
