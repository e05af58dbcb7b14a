"""What a map comes to: counts and ranges, added up block by block."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from stages.analytic.maps.answers import COLUMNS, Outcome, Way, words

NAMES = [column.name for column in COLUMNS]
#: Columns of which the range is told.
TOLD = ("period_s", "step_length_m", "speed_m_s", "largest_multiplier", "friction_single_stance")


class Counts:
    """Counts and ranges of the rows given so far."""

    def __init__(self) -> None:
        self.designs, self.residual = 0, 0.0
        self._outcomes: Counter[int] = Counter()
        self._ways: Counter[int] = Counter()
        self._least, self._most = np.full(len(COLUMNS), np.inf), np.full(len(COLUMNS), -np.inf)

    def add(self, rows: Sequence[Sequence[float]]) -> np.ndarray:
        """Count the rows of a block; gives them back as an array."""
        table = np.array(rows, dtype=float)
        self.designs += len(table)
        self._outcomes.update(table[:, 0].astype(int).tolist())
        self._ways.update(table[:, 1].astype(int).tolist())
        self._least = np.fmin(self._least, np.fmin.reduce(table))
        self._most = np.fmax(self._most, np.fmax.reduce(table))
        self.residual = float(max(self._most[NAMES.index("residual")], 0.0))
        return table

    @property
    def answered(self) -> int:
        """Designs with a gait."""
        return self._outcomes[Outcome.STABLE] + self._outcomes[Outcome.UNSTABLE]

    def outcomes(self) -> dict[str, int]:
        """Designs by outcome."""
        return {word: self._outcomes[code] for code, word in enumerate(words(Outcome)) if self._outcomes[code]}

    def ways(self) -> dict[str, int]:
        """Designs by how they were answered."""
        return {word: self._ways[code] for code, word in enumerate(words(Way)) if self._ways[code]}

    def ranges(self) -> dict[str, tuple[float, float]]:
        """Least and largest value of some columns."""
        places = {name: NAMES.index(name) for name in TOLD}
        return {name: (float(self._least[at]), float(self._most[at])) for name, at in places.items()}

    def as_plain(self) -> dict[str, Any]:
        """As JSON."""
        ranges = {name: {"low": low, "high": high, "unit": COLUMNS[NAMES.index(name)].unit}
                  for name, (low, high) in self.ranges().items()}  # fmt: skip
        return {
            "designs": self.designs,
            "outcomes": self.outcomes(),
            "answered_by": self.ways(),
            "largest_residual": self.residual,
            "ranges": ranges if self.answered else {},
        }
