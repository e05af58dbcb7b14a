"""Mean first passage time to a fall on blocks of drawn heights, its interval, and the chance to pass a ramp."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stages.analytic.result import ENDINGS, REACHES
from stages.stability.blocks.rare import Weighed
from stages.stability.blocks.walks import KEPT, Fall, Walk
from stages.stability.result import Passage

#: Falls from which the mean is counted, and that are enough; outside of an interval on either side, and its half width
#: in standard errors.
FEW, ENOUGH, TAIL, TWO_SIDED = 100, 600, 0.025, 1.96


@dataclass
class Counted:
    """Walks counted so far: steps, falls, and walks that passed a ramp or fell on it."""

    ramp: int
    steps: int = 0
    passed: int = 0
    stopped: int = 0
    fallen: list[Fall] = field(default_factory=list)

    def add(self, walks: Sequence[Walk], most: int) -> None:
        """Count walks that may make `most` steps together; on the ramp only those that could have passed it."""
        for walk in walks:
            fell = walk.ending != REACHES
            self.steps += walk.steps + fell
            if most >= self.ramp:
                self.passed += walk.steps >= self.ramp
                self.stopped += fell and walk.steps < self.ramp
            most -= walk.steps + fell
            if fell:
                self.fallen.append((walk.ending, 1.0, np.array(walk.last)))

    @property
    def falls(self) -> int:
        """Falls seen."""
        return len(self.fallen)

    def passage(self) -> Passage:
        """The mean as that of independent falls, of which as many are seen as a Poisson distribution lets expect."""
        from scipy.special import betaincinv, gammaincinv

        falls, passed, stopped = self.falls, self.passed, self.stopped
        low = self.steps / float(gammaincinv(falls + 1, 1 - TAIL))
        high = self.steps / float(gammaincinv(falls, TAIL)) if falls else np.inf
        of_ramp = (float(betaincinv(passed, stopped + 1, TAIL)) if passed else 0.0,
                   float(betaincinv(passed + 1, stopped, 1 - TAIL)) if stopped else 1.0)  # fmt: skip
        return Passage(self.steps / falls if falls else np.inf, low, high, "counted", falls, self.steps, self.ramp,
                       passed / max(passed + stopped, 1), *of_ramp)  # fmt: skip


def from_weighed(parts: Sequence[Weighed], counted: Counted) -> Passage:
    """The mean from the weighed share of walks that fall in a step; `counted` has too few falls for a count.

    The chance to pass a ramp is that at this share. It begins in the gait on level blocks, where falls are fewer until
    as many blocks as matter are passed: the interval's upper end takes the first `KEPT` steps as safe.
    """
    walks = sum(part.walks for part in parts)
    weights = np.array([weight for part in parts for _, weight, _ in part.falls])
    share, squares = weights.sum() / walks, (weights**2).sum() / walks
    error = TWO_SIDED * np.sqrt((squares - share**2) / walks)
    steps, low, high = (1 / each if each > 0 else np.inf for each in (share, share + error, share - error))
    ramps = counted.ramp, counted.ramp, max(counted.ramp - KEPT, 0)
    chances = [float(np.exp(-ramp / each)) for ramp, each in zip(ramps, (steps, low, high), strict=True)]
    effective = int(weights.sum() ** 2 / (weights**2).sum()) if len(weights) else 0
    walked = counted.steps + sum(part.steps for part in parts)
    return Passage(steps, low, high, "importance sampling", effective, walked, counted.ramp, *chances)


def ways_of(falls: Sequence[Fall]) -> list[dict[str, Any]]:
    """How walks fell, the most frequent first: share, and the mean heights of the last blocks, in rms."""
    total, rows = sum(weight for _, weight, _ in falls), []
    for ending in sorted({ending for ending, *_ in falls}):
        own = [(weight, heights) for way, weight, heights in falls if way == ending]
        of_all = sum(weight for weight, _ in own)
        mean = np.sum([weight * heights for weight, heights in own], axis=0) / of_all
        rows.append({"ending": ENDINGS[ending], "share": of_all / total, "last_blocks_rms": mean.tolist()})
    return sorted(rows, key=lambda row: -row["share"])
