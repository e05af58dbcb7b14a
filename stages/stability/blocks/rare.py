"""Rare falls: importance sampling of the heights that lead to one, by the cross-entropy method.

A walk forgets: whether it falls in a step follows from the last blocks. So the share of walks that fall in a step, the
inverse of the mean number of steps to a fall, is the probability that a walk begun in its gait falls in exactly the
step number `BLOCKS`. It is an integral over as many independent normal heights, of which those that matter are far
out. They are drawn about the mean heights before a fall instead, one mean for each way to fall, and weighed by the
ratio of the densities.

The means come from falls on higher blocks, where these are frequent, and then from weighed falls on the blocks asked
for (R. Y. Rubinstein, Methodology and Computing in Applied Probability 1, 1999). Some heights are drawn as they are,
which bounds the weights. Whatever the means, the estimate is unbiased: poor ones widen its interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stages.analytic.result import REACHES
from stages.stability.blocks.walks import KEPT, Rough, Walk, some_walks, walk_on

#: Blocks of a walk that may fall on the last; the share that is drawn as it is; the least share of a way to fall.
BLOCKS, PLAIN, LEAST = 14, 0.1, 0.05
#: Falls that the means are learnt from, steps that are walked at once for them, the factor to higher blocks, at most so
#: often; a way to fall that is seen less often is left to others; rounds that improve the means, and walks in each.
FALLS, WATCHED, HIGHER, TIMES, SEEN, ROUNDS, WALKS = 100, 1000, 1.3, 40, 4, 3, 300


class NoFalls(ValueError):
    """No fall is found even on much higher blocks."""


@dataclass(frozen=True)
class Ways:
    """Ways to fall: endings (k,), their shares (k,), and mean heights (k, BLOCKS) of the blocks before, in rms."""

    endings: Sequence[int]
    shares: Sequence[float]
    means: np.ndarray

    @classmethod
    def of(cls, plain: Sequence[Any]) -> Ways:
        """What `plain` tells of."""
        return cls(plain[0], plain[1], np.array(plain[2]))

    @property
    def plain(self) -> list[Any]:
        """As JSON knows it."""
        return [list(self.endings), list(self.shares), self.means.tolist()]

    def drawn(self, generator: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Heights (count, BLOCKS) and their weights (count,): the density asked for over that drawn from."""
        means = np.vstack([np.zeros(BLOCKS), self.means])
        shares = np.append(PLAIN, (1 - PLAIN) * np.asarray(self.shares))
        chosen = generator.choice(len(shares), count, p=shares / shares.sum())
        heights = means[chosen] + generator.standard_normal((count, BLOCKS))
        ratios = np.exp(heights @ means.T - 0.5 * (means**2).sum(axis=1)) @ (shares / shares.sum())
        return heights, 1.0 / ratios


@dataclass(frozen=True)
class Weighed:
    """Falls in the last step of weighed walks: number of walks, and of steps; of each walk that fell its ending, weight
    and heights (BLOCKS,).
    """

    walks: int
    steps: int
    falls: Sequence[tuple[int, float, np.ndarray]]

    def ways(self, before: Ways) -> Ways:
        """The ways to fall that these weigh, those of `before` where there are none."""
        rows = [[(weight, heights) for ending, weight, heights in self.falls if ending == way]
                for way in before.endings]  # fmt: skip
        sums = np.array([sum(weight for weight, _ in falls) for falls in rows])
        if not sums.sum() > 0:
            return before
        means = [sum(weight * heights for weight, heights in falls) / total if len(falls) >= SEEN else old
                 for falls, total, old in zip(rows, sums, before.means, strict=True)]  # fmt: skip
        shares = np.maximum(sums / sums.sum(), LEAST)
        return Ways(before.endings, (shares / shares.sum()).tolist(), np.array(means))


def weighed(rough: Rough, ways: Ways, generator: np.random.Generator, count: int) -> Weighed:
    """Walk over so many drawn sequences of blocks."""
    steps, falls = 0, []
    for heights, weight in zip(*ways.drawn(generator, count), strict=True):
        walk = walk_on(rough, heights.tolist())
        steps += walk.steps + (walk.ending != REACHES)
        if walk.ending != REACHES and walk.steps == BLOCKS - 1:
            falls.append((walk.ending, float(weight), heights))
    return Weighed(count, steps, falls)


def first_ways(rough: Rough, seed: int) -> Ways:
    """The ways to fall on blocks so high that falls are frequent. Raises NoFalls."""
    higher, falls = rough, list[Walk]()
    for time in range(TIMES):
        falls = [walk for walk in some_walks(higher, seed, WATCHED * time, WATCHED) if walk.ending != REACHES]
        if len(falls) >= FALLS:
            break
        higher = replace(higher, rms=HIGHER * higher.rms)
    endings = [ending for ending in sorted({walk.ending for walk in falls})
               if sum(walk.ending == ending for walk in falls) >= SEEN]  # fmt: skip
    if not endings:
        raise NoFalls(f"no falls even on blocks {higher.rms / rough.rms:.0f} times as high")
    of_each = [np.array([walk.last for walk in falls if walk.ending == ending]) for ending in endings]
    means = np.zeros((len(endings), BLOCKS))
    means[:, -KEPT:] = [last.mean(axis=0) * higher.rms / rough.rms for last in of_each]
    shares = np.maximum([len(last) / len(falls) for last in of_each], LEAST)
    return Ways(endings, (shares / shares.sum()).tolist(), means)


def learnt_ways(rough: Rough, seed: int) -> Ways:
    """The ways to fall on these blocks. Raises NoFalls."""
    generator, ways = generator_of(seed), first_ways(rough, seed)
    for _ in range(ROUNDS):
        ways = weighed(rough, ways, generator, WALKS).ways(ways)
    return ways


def generator_of(seed: int) -> np.random.Generator:
    """The generator of what is drawn beside the walks."""
    return np.random.Generator(np.random.Philox(key=np.array([seed, 1 << 62], dtype=np.uint64)))
