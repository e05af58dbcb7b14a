"""The ramp as a scene: sets of stepping blocks one step apart; off the blocks there is no ground.

A set is two blocks, one under each foot of a pair. The first set carries the inner pair at the start, x = 0; the next
lies one step ahead for the outer pair, and so on in turn, so that a foot swings down through the gap between two blocks
of its lane. All sets must find room on the ramp.
"""

import math
from dataclasses import dataclass, replace

from stages.ground.blocks import Blocks, BlocksDoNotFit
from stages.ground.friction import SCALARS, Lane, lanes
from stages.twin.parameters import Settings, block_fault


@dataclass(frozen=True)
class Ramp:
    """Blocks on a slope: `lanes` along x of the inner and the outer pair, number of `sets`.

    `length` [m] is the ramp's, `width` [m] a block's across the slope; its middle lies under the middle of a foot, at
    |z| = `tracks` (2,) [m].
    """

    lanes: tuple[Lane, Lane]
    sets: int
    width: float
    length: float
    tracks: tuple[float, float]

    @property
    def step(self) -> float:
        """Distance from set to set [m]."""
        return self.lanes[1].first

    @property
    def steps(self) -> int:
        """Steps from the first set to the last."""
        return self.sets - 1

    def carries(self, pair: int, x: float, z: float, half_width: float) -> bool:
        """Whether a block lies under a foot of a pair at x, z [m] over the whole width of the foot."""
        lane = self.lanes[pair]
        number = round((x - lane.first) / lane.spacing)
        there = 0 <= 2 * number + pair < self.sets and lane.presence(x, SCALARS) > 0.5
        return there and self.beside(pair, z, half_width) <= 0.0

    def beside(self, pair: int, z: float, half_width: float) -> float:
        """How far a foot stands over the side of its track [m]; not positive on the track."""
        return abs(abs(z) - self.tracks[pair]) + half_width - 0.5 * self.width

    def number(self, pair: int, x: float) -> int:
        """The pair's set nearest to x, counted from 1."""
        lane = self.lanes[pair]
        return 2 * round((x - lane.first) / lane.spacing) + pair + 1

    def miss(self, pair: int, x: float) -> float:
        """How far x is beyond the edge of the nearest set [m], positive down the slope, 0 over the set."""
        lane = self.lanes[pair]
        offset = x - lane.first - lane.spacing * round((x - lane.first) / lane.spacing)
        return math.copysign(max(0.0, abs(offset) - 0.5 * lane.length), offset)


def lay_blocks(settings: Settings, blocks: Blocks, step_length: float) -> Ramp:
    """The ramp of the settings with blocks for steps of `step_length` [m], unless the settings give another.

    Raises BlocksDoNotFit.
    """
    step = settings.expected_step or step_length
    fault = block_fault(blocks, settings.ramp_length, step)
    if fault is not None:
        value = settings.ramp_length if fault.key.startswith("twin.") else blocks.block_length
        raise BlocksDoNotFit(f"{fault.key} = {value:g} m is not allowed for steps of {step:.4g} m; "
                             f"allowed: {fault.allowed}")
    return Ramp(
        lanes=lanes(step, blocks.block_length),
        sets=blocks.block_sets,
        width=blocks.block_width,
        length=settings.ramp_length,
        tracks=(settings.inner_lane, settings.outer_lane),
    )


#: A ramp under a walk on the plane is no more times as long as its blocks need: a small robot's would be lost on it.
SPARE = 1.25


def laid(settings: Settings, blocks: Blocks, step_length: float) -> Ramp:
    """The ramp of the scene; of a walk on the plane one that fits steps of this length [m], whatever they are.

    Raises BlocksDoNotFit where the scene is the ramp.
    """
    if settings.scene != "plane":
        return lay_blocks(settings, blocks, step_length)
    step = settings.expected_step or step_length
    shorter = replace(blocks, block_length=min(blocks.block_length, 0.5 * step))
    least = (blocks.block_sets - 1) * step + shorter.block_length
    length = min(max(settings.ramp_length, least), SPARE * least)
    return lay_blocks(replace(settings, ramp_length=length), shorter, step_length)
