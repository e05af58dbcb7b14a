"""Walks of the constraint model over blocks of drawn heights, step by step until a fall.

The rule (docs/model.md): footfall n lands on block n, whose middle is where a foot of the gait would land, and stands
on its height until it leaves. The first two blocks are level, and the walk starts on them in its gait. A step
that does not end with a foot on its block and the hip between both feet is a fall.
"""

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import islice

import numpy as np

from stages.analytic.gait.basin import unlanded
from stages.analytic.gait.poincare import (
    SEARCH_TOLERANCE,
    STEP_LIMIT_OF_A_PHASE,
    TIME_LIMIT_OF_A_PHASE,
    poincare_map,
    start_state,
)
from stages.analytic.integration.phase import walk_step
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.guards import foot_clearance
from stages.analytic.result import OTHERWISE, REACHES
from stages.ground.blocks import drawn_heights

#: Heights that are drawn at once, and the last of them before a fall that are kept.
DRAWN, KEPT = 256, 10
#: Tolerance of the steps: at 1e-8 none of 3,100 walks of Table 1's biped ends at another step; at 1e-4 none either.
TOLERANCE = 1e-5


@dataclass(frozen=True)
class Standing:
    """A walk just after a heel strike: state, which leg stands, and the height of the block it stands on, in rms."""

    y: Vector
    leg: int = 0
    height: float = 0.0


@dataclass(frozen=True)
class Rough:
    """A walker, the section coordinates of its gait, and blocks: rms of their heights and `length`, in leg lengths."""

    walker: Walker
    z: Vector
    rms: float
    length: float
    tolerance: float = TOLERANCE

    @cached_property
    def start(self) -> Standing:
        """In its gait, on level blocks."""
        return Standing(start_state(self.walker, self.z))

    @cached_property
    def middles(self) -> tuple[float, float]:
        """How far ahead of the foot that stands the middle of a block is, by the leg that stands: the distance of the
        feet as the gait's other leg lands."""
        on_other = self.apart(self.start.y, 0)
        if not self.walker.alternates:
            return on_other, on_other
        return self.apart(poincare_map(self.walker, self.z, SEARCH_TOLERANCE).state, 1), on_other

    def apart(self, y: Vector, leg: int) -> float:
        """How far ahead of the other foot a leg has just landed."""
        return -float(foot_clearance(y, self.walker.on(leg).p, y, 0)[2])

    def step(self, at: Standing, height: float) -> tuple[Standing, int]:
        """The step onto a block of this height, in rms; and how it ends, a place in `ENDINGS`, REACHES if no fall."""
        y = at.y.copy()
        middle, half = self.middles[at.leg], 0.5 * self.length
        p = self.walker.on(at.leg).p._replace(h_ahead=self.rms * (height - at.height), x_ahead=middle - half)
        status, *_ = walk_step(y, p, self.tolerance, TIME_LIMIT_OF_A_PHASE, STEP_LIMIT_OF_A_PHASE, None)
        ending = int(unlanded(status, y, p))
        if ending == REACHES and self.apart(y, 1 - at.leg) > middle + half:
            ending = OTHERWISE
        return Standing(y, 1 - at.leg, height), ending


@dataclass(frozen=True)
class Walk:
    """A walk: steps made, how it ended (REACHES: it walks on), and heights (KEPT,) of its last blocks, in rms."""

    steps: int
    ending: int
    last: tuple[float, ...] = (0.0,) * KEPT


#: How a walk fell, a place in `ENDINGS`; its weight among falls; heights (KEPT,) of its last blocks, in rms.
Fall = tuple[int, float, np.ndarray]


def heights_of(seed: int, walk: int) -> Iterator[float]:
    """Heights of the blocks under a walk, without end, in rms."""
    first = 0
    while True:
        yield from drawn_heights(seed, walk, first, DRAWN).tolist()
        first += DRAWN


def walk_on(
    rough: Rough, heights: Iterable[float], at: Standing | None = None, last: Iterable[float] = (0.0,) * KEPT
) -> Walk:
    """Walk over blocks of these heights until a fall or their end: from the gait, or as it stands after the `last`."""
    at, last, made = at or rough.start, deque(last, maxlen=KEPT), 0
    for height in heights:
        last.append(height)
        at, ending = rough.step(at, height)
        if ending != REACHES:
            return Walk(made, ending, tuple(last))
        made += 1
    return Walk(made, REACHES, tuple(last))


def some_walks(rough: Rough, seed: int, first: int, steps: int) -> list[Walk]:
    """Walks from number `first` on that make so many steps together; the last is cut short where they are made."""
    walks: list[Walk] = []
    while steps > 0:
        walks.append(walk_on(rough, islice(heights_of(seed, first + len(walks)), steps)))
        steps -= walks[-1].steps + 1
    return walks
