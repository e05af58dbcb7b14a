"""Stepping blocks: each leg has its own lane of blocks; its foot swings through the gaps in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from stages.ground.operations import ARRAYS, Operations


@dataclass(frozen=True)
class Lane:
    """Equal blocks in a row under one leg: ground exists from centre - length/2 to centre + length/2 of each [m]."""

    first: float
    spacing: float
    length: float

    def presence(self, x: Any, ops: Operations = ARRAYS) -> Any:
        """1 over a block and 0 between blocks, at a position x [m] along the slope."""
        offset = x - self.first
        nearest = self.spacing * ops.round(offset * (1.0 / self.spacing))
        return 0.5 + 0.5 * ops.sign(0.5 * self.length - ops.absolute(offset - nearest))


def lanes(step_length: float, block_length: float) -> tuple[Lane, Lane]:
    """Lanes of leg 0, which stands at x = 0, and of leg 1, one step ahead; blocks two steps apart."""
    return Lane(0.0, 2.0 * step_length, block_length), Lane(step_length, 2.0 * step_length, block_length)
