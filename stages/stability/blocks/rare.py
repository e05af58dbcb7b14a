"""Rare falls: importance sampling of the heights that lead to one, by the cross-entropy method.

The inverse of the mean number of steps to a fall is the share of walks that fall in a step. It is an integral over the
independent normal heights of the blocks before, of which those that matter are far out. They are drawn about some of
these instead, and weighed by the ratio of the densities.

What leads to a fall is a few blocks, and some steps later the walk falls or not. So walks branch off from one on blocks
as they are. They go over a `pattern` of a few blocks, about which heights are drawn, and some more. A fall there is
weighed as if its pattern had been placed anywhere among the last blocks: each place is drawn as often (the balance
heuristic: E. Veach and L. J. Guibas, SIGGRAPH 1995). Patterns are learnt from falls: on blocks so high that
these are frequent, then on ever lower ones, where what was drawn about the patterns falls and is weighed, until the
blocks are those requested (cross-entropy: R. Y. Rubinstein, Methodology and Computing in Applied Probability 1, 1999).
Some heights are drawn as they are, which bounds the weights.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from stages.analytic.result import REACHES
from stages.stability.blocks.walks import KEPT, Fall, Rough, Standing, some_walks, walk_on

#: Blocks in a pattern, and places of it among the last blocks.
PATTERN = 5
PLACES = KEPT - PATTERN + 1
#: Steps before the first branch, and from one to the next: an odd number, so that either leg begins as often.
SETTLED, APART = 50, 5
#: Share of the heights that is drawn as it is, patterns, and the least share of each.
PLAIN, PATTERNS, LEAST = 0.1, 4, 0.05
#: Falls that patterns are first learnt from, in so many steps, of which a part is looked at first, on blocks higher by
#: this factor, at most so often.
FALLS, WATCHED, LOOKS, HIGHER, TIMES = 60, 4000, 8, 1.2, 13
#: Passes that share falls out among patterns; walks on blocks of one height; rounds on those requested.
PASSES, WALKS, ROUNDS = 15, 200, 3


class NoFalls(ValueError):
    """No fall is found even on much higher blocks."""


@dataclass(frozen=True)
class Patterns:
    """Heights (k, PATTERN) of blocks that lead to a fall, in rms, and the shares (k,) of these patterns."""

    shares: np.ndarray
    heights: np.ndarray

    def likelihoods(self, heights: np.ndarray) -> np.ndarray:
        """Densities (n, PLACES, k) of heights (n, KEPT) about each pattern at each place, over that requested, times
        its share; their sum over places and patterns is that of the mixture.
        """
        there = sliding_window_view(heights, PATTERN, axis=1)
        ratios = np.exp(there @ self.heights.T - 0.5 * (self.heights**2).sum(axis=1)) * self.shares
        return np.asarray(ratios / PLACES)

    def drawn(self, generator: np.random.Generator, count: int) -> np.ndarray:
        """Heights (count, KEPT) of the blocks of branches, which begin with a pattern."""
        heights = generator.standard_normal((count, KEPT))
        which = generator.choice(len(self.shares), count, p=self.shares)
        heights[:, :PATTERN] += self.heights[which] * (generator.random(count) >= PLAIN)[:, None]
        return heights

    def weights(self, heights: np.ndarray) -> np.ndarray:
        """Weights (n,) of falls after heights (n, KEPT): the density requested over that drawn from."""
        return np.asarray(1.0 / (PLAIN + (1 - PLAIN) * self.likelihoods(heights).sum(axis=(1, 2))))

    def moved(self, heights: np.ndarray, weights: np.ndarray) -> Patterns:
        """Patterns of weighed heights (n, KEPT) before falls, shared out among patterns and places by likelihood."""
        found = self.likelihoods(heights)
        parts = found / found.sum(axis=(1, 2), keepdims=True) * (weights / weights.sum())[:, None, None]
        sums = parts.sum(axis=(0, 1))
        means = np.einsum("npk,npb->kb", parts, sliding_window_view(heights, PATTERN, axis=1))
        shares = np.maximum(sums, LEAST)
        kept = np.where(sums[:, None] > 1e-3, means / np.maximum(sums, 1e-3)[:, None], self.heights)
        return Patterns(shares / shares.sum(), kept)


@dataclass(frozen=True)
class Weighed:
    """Falls of weighed walks, and numbers of walks and of steps.

    The weights over the number of walks add up to the share of walks that fall in a step.
    """

    walks: int
    steps: int
    falls: Sequence[Fall]


def weighed(rough: Rough, patterns: Patterns, generator: np.random.Generator, count: int) -> Weighed:
    """Walk over so many drawn patterns, each from another state of a walk on blocks as they are."""
    last, steps, endings, heights = deque([0.0] * KEPT, maxlen=KEPT), SETTLED, [], []
    at = under_way(rough, rough.start, last, generator.standard_normal(SETTLED))
    for row in patterns.drawn(generator, count).tolist():
        at = under_way(rough, at, last, generator.standard_normal(APART))
        walk = walk_on(rough, row, at, last)
        fell = walk.ending != REACHES
        steps += APART + walk.steps + fell
        if fell and walk.steps >= PATTERN - 1:
            endings.append(walk.ending)
            heights.append(walk.last)
    found = np.array(heights).reshape(-1, KEPT)
    return Weighed(count, steps, list(zip(endings, (patterns.weights(found) / PLACES).tolist(), found, strict=True)))


def under_way(rough: Rough, at: Standing, last: deque[float], heights: np.ndarray) -> Standing:
    """After a step onto each of these heights, which become the `last`; a walk that falls begins anew."""
    for height in heights.tolist():
        last.append(height)
        at, ending = rough.step(at, height)
        if ending != REACHES:
            at = rough.start
    return at


def first_patterns(rough: Rough, seed: int) -> tuple[Rough, Patterns, int]:
    """Blocks so high that falls are frequent, the patterns before falls there, and steps. Raises NoFalls."""
    steps = WATCHED
    for _ in range(TIMES):
        steps += WATCHED // LOOKS
        looked = some_walks(rough, seed, 0, WATCHED // LOOKS)
        if sum(walk.ending != REACHES for walk in looked) * LOOKS >= FALLS:
            break
        rough = replace(rough, rms=HIGHER * rough.rms)
    else:
        raise NoFalls(f"no walk falls even on blocks {HIGHER**TIMES:.0f} times as high")
    last = np.array([walk.last for walk in some_walks(rough, seed, 0, WATCHED) if walk.ending != REACHES])
    begun = last[np.linspace(0, len(last) - 1, PATTERNS).astype(int), -PATTERN:]
    patterns = Patterns(np.full(PATTERNS, 1 / PATTERNS), begun)
    for _ in range(PASSES):
        patterns = patterns.moved(last, np.ones(len(last)))
    return rough, patterns, steps


def learnt_patterns(rough: Rough, seed: int) -> tuple[Patterns, int]:
    """The patterns on these blocks, and the steps that this took. Raises NoFalls."""
    generator, (there, patterns, steps) = generator_of(seed), first_patterns(rough, seed)
    rounds = 0
    while rounds < ROUNDS:
        lower = max(there.rms / HIGHER, rough.rms)
        patterns, there = replace(patterns, heights=patterns.heights * there.rms / lower), replace(rough, rms=lower)
        rounds += there.rms == rough.rms
        found = weighed(there, patterns, generator, WALKS)
        steps += found.steps
        if found.falls:
            patterns = patterns.moved(np.array([last for *_, last in found.falls]),
                                      np.array([weight for _, weight, _ in found.falls]))  # fmt: skip
    return patterns, steps


def generator_of(seed: int) -> np.random.Generator:
    """The generator of what is drawn beside the walks."""
    return np.random.Generator(np.random.Philox(key=np.array([seed, 1 << 62], dtype=np.uint64)))
