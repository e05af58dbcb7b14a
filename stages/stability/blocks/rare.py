"""Rare falls: importance sampling of the heights that lead to one, by the cross-entropy method.

The inverse of the mean number of steps to a fall is the share of walks that fall in a step. Of a walk begun in its gait
this is the expected number of falls in its steps from `SETTLED` on, over their number. It is an integral over as many
independent normal heights, of which those that matter are far out. They are drawn about some of these instead, and
weighed by the ratio of the densities.

What leads to a fall is a few blocks, and some steps later the walk falls or not. So heights are drawn about a short
`pattern` of blocks, which may stand anywhere under the walk. Patterns are learnt from falls: on blocks so high that
these are frequent, then on ever lower ones, where what was drawn about the patterns falls and is weighed, until the
blocks are those asked for (cross-entropy: R. Y. Rubinstein, Methodology and Computing in Applied Probability 1, 1999).
Some heights are drawn as they are, which bounds the weights.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from stages.analytic.result import REACHES
from stages.stability.blocks.walks import Rough, some_walks, walk_on

#: Blocks under a walk, and steps of it before falls are counted; blocks in a pattern.
BLOCKS, SETTLED, PATTERN = 24, 8, 5
#: Share of the heights that is drawn as it is, patterns, and the least share of each.
PLAIN, PATTERNS, LEAST = 0.1, 4, 0.05
#: Falls that patterns are first learnt from, in so many steps, on blocks higher by this factor, at most so often.
FALLS, WATCHED, HIGHER, TIMES = 60, 4000, 1.2, 13
#: Passes that share falls out among patterns; walks on blocks of one height; rounds on those asked for.
PASSES, WALKS, ROUNDS = 15, 200, 4


class NoFalls(ValueError):
    """No fall is found even on much higher blocks."""


@dataclass(frozen=True)
class Patterns:
    """Heights (k, PATTERN) of blocks that lead to a fall, in rms, and the shares (k,) of these patterns."""

    shares: np.ndarray
    heights: np.ndarray

    @classmethod
    def of(cls, plain: Sequence[Any]) -> Patterns:
        """What `plain` tells of."""
        return cls(np.array(plain[0]), np.array(plain[1]))

    @property
    def plain(self) -> list[Any]:
        """As JSON knows it."""
        return [self.shares.tolist(), self.heights.tolist()]

    def likelihoods(self, heights: np.ndarray) -> np.ndarray:
        """Densities (n, places, k) of heights (n, b) about each pattern at each place, over that asked for, times its
        share; their sum over places and patterns is that of the mixture.
        """
        there = sliding_window_view(heights, PATTERN, axis=1)
        ratios = np.exp(there @ self.heights.T - 0.5 * (self.heights**2).sum(axis=1)) * self.shares
        return np.asarray(ratios / there.shape[1])

    def drawn(self, generator: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Heights (count, BLOCKS) and their weights (count,): the density asked for over that drawn from."""
        heights = generator.standard_normal((count, BLOCKS))
        which = generator.choice(len(self.shares), count, p=self.shares)
        first = generator.integers(0, BLOCKS - PATTERN + 1, count)
        for row in np.flatnonzero(generator.random(count) >= PLAIN).tolist():
            heights[row, first[row] : first[row] + PATTERN] += self.heights[which[row]]
        return heights, 1.0 / (PLAIN + (1 - PLAIN) * self.likelihoods(heights).sum(axis=(1, 2)))

    def moved(self, heights: np.ndarray, weights: np.ndarray) -> Patterns:
        """Patterns of weighed heights (n, b) before falls, shared out among patterns and places by likelihood."""
        found = self.likelihoods(heights)
        parts = found / found.sum(axis=(1, 2), keepdims=True) * (weights / weights.sum())[:, None, None]
        sums = parts.sum(axis=(0, 1))
        means = np.einsum("npk,npb->kb", parts, sliding_window_view(heights, PATTERN, axis=1))
        shares = np.maximum(sums, LEAST)
        kept = np.where(sums[:, None] > 1e-3, means / np.maximum(sums, 1e-3)[:, None], self.heights)
        return Patterns(shares / shares.sum(), kept)


@dataclass(frozen=True)
class Weighed:
    """Falls of weighed walks: numbers of walks and of steps; of each fall its ending, weight and last heights (KEPT,).

    The weights over the number of walks add up to the share of walks that fall in a step.
    """

    walks: int
    steps: int
    falls: Sequence[tuple[int, float, np.ndarray]]


def weighed(rough: Rough, patterns: Patterns, generator: np.random.Generator, count: int) -> Weighed:
    """Walk over so many drawn sequences of blocks."""
    heights, weights = patterns.drawn(generator, count)
    walks = [walk_on(rough, row) for row in heights.tolist()]
    falls = [(walk.ending, float(weight) / (BLOCKS - SETTLED), np.array(walk.last))
             for walk, weight in zip(walks, weights, strict=True) if walk.ending != REACHES and walk.steps >= SETTLED]
    return Weighed(count, sum(walk.steps + (walk.ending != REACHES) for walk in walks), falls)


def first_patterns(rough: Rough, seed: int) -> tuple[Rough, Patterns]:
    """Blocks so high that falls are frequent, and the patterns before falls there. Raises NoFalls."""
    for time in range(TIMES):
        walks = some_walks(rough, seed, WATCHED * time, WATCHED)
        last = np.array([walk.last for walk in walks if walk.ending != REACHES])
        if len(last) >= FALLS:
            break
        rough = replace(rough, rms=HIGHER * rough.rms)
    else:
        raise NoFalls(f"no walk falls even on blocks {HIGHER**TIMES:.0f} times as high")
    begun = last[np.linspace(0, len(last) - 1, PATTERNS).astype(int), -PATTERN:]
    patterns = Patterns(np.full(PATTERNS, 1 / PATTERNS), begun)
    for _ in range(PASSES):
        patterns = patterns.moved(last, np.ones(len(last)))
    return rough, patterns


def learnt_patterns(rough: Rough, seed: int) -> Patterns:
    """The patterns on these blocks. Raises NoFalls."""
    generator, (there, patterns) = generator_of(seed), first_patterns(rough, seed)
    rounds = 0
    while rounds < ROUNDS:
        lower = max(there.rms / HIGHER, rough.rms)
        patterns, there = replace(patterns, heights=patterns.heights * there.rms / lower), replace(rough, rms=lower)
        rounds += there.rms == rough.rms
        falls = weighed(there, patterns, generator, WALKS).falls
        if falls:
            patterns = patterns.moved(np.array([last for *_, last in falls]), np.array([w for _, w, _ in falls]))
    return patterns


def generator_of(seed: int) -> np.random.Generator:
    """The generator of what is drawn beside the walks."""
    return np.random.Generator(np.random.Philox(key=np.array([seed, 1 << 62], dtype=np.uint64)))
