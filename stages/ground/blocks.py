"""Stepping blocks of drawn heights: footfall n of a walk comes down on block n, of the same height in every model.

Heights are independent and normal. Each is drawn from its own count (seed, walk, footfall) by a counter-based generator
(Philox), so that it depends neither on the order in which they are asked for nor on how many there are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from stages.biped.quantity import Bound, parameter

if TYPE_CHECKING:
    import numpy as np

#: Numbers that the generator gives for a count, and bits of each that a double holds.
OF_A_COUNT, BITS = 4, 53


@dataclass(frozen=True)
class Blocks:
    """How rough the ground is."""

    FILE: ClassVar[str] = "ground"

    block_height_rms: float = parameter(
        "m", "root mean square of the heights of stepping blocks; 0: even ground", bound=Bound(minimum=0), default=0.0)
    block_seed: int = parameter(
        "1", "which heights are drawn", bound=Bound(minimum=0, maximum=2**31), default=0)


def drawn_heights(seed: int, walk: int, first: int, count: int) -> np.ndarray:
    """Heights (count,) of the blocks from number `first` on under a walk, by their root mean square."""
    import numpy as np
    from scipy.special import ndtri

    start = first // OF_A_COUNT
    whole = np.random.Philox(key=np.array([seed, walk], dtype=np.uint64), counter=start).random_raw(
        OF_A_COUNT * (-(-(first + count) // OF_A_COUNT) - start))
    raw = whole[first - OF_A_COUNT * start :][:count]
    heights: np.ndarray = ndtri(((raw >> np.uint64(64 - BITS)) + 0.5) * 2.0**-BITS)
    return heights
