"""How high blocks a design bears, as a goal of a search.

Falls on the blocks requested may be too rare to count for each design that is tried. So the blocks grow from step to
step and are lower after each fall, such that it falls every `EVERY` steps: a staircase as in C. Kaernbach, Perception
and Psychophysics 49 (1991). The mean height of these is what the design bears. Falls on lower blocks come about alike.

Every design walks over the same numbers, and derivatives are differences of such walks, beside the gait along its exact
tangent.
"""

from dataclasses import dataclass

import numpy as np

from stages.analytic.derivatives.gait import GaitTangents
from stages.analytic.derivatives.numbers import moved
from stages.analytic.design.goals import Goal
from stages.analytic.errors import StepFailed
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.result import REACHES
from stages.ground.blocks import Blocks
from stages.stability.blocks.walks import Rough, heights_of

#: Steps to a fall, the share by which blocks are lower after one, and steps whose heights are counted.
EVERY, LOWER, STEPS = 50, 0.05, 4000
#: Before these so many steps with shares so many times as large, to be near.
SETTLING, FASTER = 500, 5
#: The first height, in leg lengths: low, since blocks fall faster than they grow.
FIRST = 1e-3
#: Share of a parameter between designs that are distinguished by their walks, and the least of a search.
SHARE, COARSE = 0.04, 0.01


@dataclass(frozen=True)
class Borne:
    """The height that walkers bear on blocks of this length and seed."""

    blocks: Blocks

    def of(self, walker: Walker, z: Vector) -> float:
        """The rms height [m] for a gait at section coordinates `z`. Raises StepFailed if blocks do not fit."""
        rough = Rough(walker, z, 1.0, self.blocks.block_length / walker.length)
        if not min(rough.middles) > 0.5 * rough.length:
            raise StepFailed("a block reaches the other foot")
        log, total, walk = np.log(FIRST), 0.0, 0
        at, heights = rough.start, heights_of(self.blocks.block_seed, walk)
        for step in range(SETTLING + STEPS):
            at, ending = rough.step(at, float(np.exp(log)) * next(heights))
            lower = LOWER if step >= SETTLING else FASTER * LOWER
            log += lower / EVERY
            if ending != REACHES:
                log, walk = log - lower, walk + 1
                at, heights = rough.start, heights_of(self.blocks.block_seed, walk)
            total += log * (step >= SETTLING)
        return float(np.exp(total / STEPS)) * walker.length

    def parts(self, walker: Walker, point: FixedPoint, tolerance: float) -> Vector:
        """The height, (1,)."""
        return np.array([self.of(walker, point.z)])

    def slopes(self, gait: GaitTangents, tolerance: float) -> np.ndarray:
        """Derivatives of `parts`."""
        beside = [[self.of(moved(gait.walker, share * along), gait.point.z + share * z) for share in (SHARE, -SHARE)]
                  for along, z in zip(gait.changes.along, gait.z.T, strict=True)]  # fmt: skip
        return (np.array(beside) @ [[1.0], [-1.0]]).T / (2 * SHARE)

    @property
    def goal(self) -> Goal:
        """As a search knows it."""
        title = f"height of blocks that it bears for {EVERY} steps"
        return Goal(title, "m", self.parts, self.slopes, COARSE)
