"""Stepping blocks of drawn heights: footfall n of a walk comes down on block n, of the same height in every model.

A block's middle lies where a foot of the gait would land (docs/model.md has the whole rule). Heights are independent
and normal. Each is drawn from its own count (seed, walk, footfall) by a counter-based generator (Philox), so
that it depends neither on the order in which they are requested nor on how many there are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from stages.biped.quantity import Bound, Broken, parameter

if TYPE_CHECKING:
    from collections.abc import Iterable

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
    block_length: float = parameter("m", "length of a stepping block", bound=Bound(above=0), default=0.08)
    block_width: float = parameter(
        "m", "width of a stepping block on the twin's ramp", bound=Bound(above=0), default=0.045)
    block_sets: int = parameter(
        "1", "sets of stepping blocks on the ramp", bound=Bound(minimum=2, maximum=1000), default=11)

    def under(self, walk: int, apart: Iterable[float]) -> Laid | None:
        """Blocks under a walk of this number, for a gait whose feet are `apart` (2,) [m] as one lands, first the step
        on leg 0; None if even.

        Raises BlocksDoNotFit.
        """
        if self.block_height_rms == 0.0:
            return None
        half = 0.5 * self.block_length
        if half >= (least := min(apart)):
            raise BlocksDoNotFit(f"ground.block_length = {self.block_length:g} m is not allowed for feet that land "
                                 f"{least:.4g} m ahead; allowed: < {2 * least:.4g} m, or it reaches the other foot")
        on_first, on_other = apart  # in the step on leg 0 leg 1 lands
        return Laid(self.block_height_rms, self.block_seed, walk, (on_other - half, on_first - half),
                    (on_other + half, on_first + half))  # fmt: skip


@dataclass(frozen=True)
class Laid:
    """Blocks under a walk, heights of this rms; those under each leg lie from `begins` to `ends` ahead of the foot that
    stands [m]."""

    rms: float
    seed: int
    walk: int
    begins: tuple[float, float]
    ends: tuple[float, float]

    def height(self, footfall: int) -> float:
        """Height [m] of the block on which a foot lands, footfalls counted from 0; a walk begins on level ones."""
        return self.rms * float(drawn_heights(self.seed, self.walk, footfall, 1)[0])


class BlocksDoNotFit(ValueError):
    """Blocks that overlap or do not find room on the ramp; the message says which."""


def overlap(length: float, step: float) -> Broken | None:
    """What is wrong with blocks of this length [m] under steps of that length [m]: they overlap in their lane."""
    if length < 2.0 * step:
        return None
    return Broken("block_length", f"< two steps = {2.0 * step:.4g} m, or the blocks of a lane overlap")


def drawn_heights(seed: int, walk: int, first: int, count: int) -> np.ndarray:
    """Heights (count,) of the blocks from number `first` on under a walk, by their root mean square."""
    import numpy as np
    from scipy.special import ndtri

    start = first // OF_A_COUNT
    whole = np.random.Philox(key=np.array([seed, walk], dtype=np.uint64), counter=start).random_raw(
        OF_A_COUNT * (-(-(first + count) // OF_A_COUNT) - start))
    raw = whole[first - OF_A_COUNT * start :][:count]
    return np.asarray(ndtri(((raw >> np.uint64(64 - BITS)) + 0.5) * 2.0**-BITS))
