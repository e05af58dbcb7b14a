"""What is counted of a study to which something is done again and again."""

from collections import Counter
from dataclasses import dataclass, field


@dataclass
class Count:
    """How often it was done and survived; what was lost, wrong, or ended without a sentence, in words; what was hit."""

    tried: int = 0
    survived: int = 0
    lost: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)
    told: list[str] = field(default_factory=list)
    hit: Counter[str] = field(default_factory=Counter)

    @property
    def problems(self) -> list[str]:
        """All that should not be."""
        return [*self.lost, *self.wrong, *self.told]
