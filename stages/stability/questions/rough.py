"""`rough`: steps until the walker falls on blocks of drawn heights."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stages.biped.quantity import Bound
from stages.biped.question import Answer, Asking, Question, as_plain, option, refuse

if TYPE_CHECKING:
    from stages.stability.blocks.passage import Counted
    from stages.stability.blocks.walks import Rough
    from stages.stability.parameters import Parameters
    from stages.stability.result import Passage

#: Steps that are walked at once; of these parts so many are counted at first, and weighed walks come in so many. Of all
#: steps a share that weighed walks have at least, however many it took to learn what leads to a fall.
PART, FIRST, WEIGHED, LEAST = 2500, 4, 8, 0.25
#: Seeds, beside that of the blocks: of the patterns before falls, and of weighed walks.
OF_PATTERNS, OF_WEIGHED = 1_000_000, 2_000_000
EVEN = "ground.block_height_rms = 0 m: the ground is even, and nobody falls; allowed here: > 0 m"


@dataclass(frozen=True)
class Options:
    """Options of `rough`."""

    effort: int = option(
        "1", "Steps that are walked, about", default=100_000, bound=Bound(minimum=40_000, maximum=10**9))
    ramp: int = option(
        "1", "Steps of a ramp: the chance to walk so many; the paper's has eleven sets of blocks", default=10,
        bound=Bound(minimum=1, maximum=1000))


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Walk over blocks. Raises NoGait, WrongOption, BlocksDoNotFit."""
    from stages.analytic.derivatives.on_blocks import on_blocks, refusal
    from stages.analytic.errors import NoGait
    from stages.analytic.gait.gait_search import find_gait

    rms, tolerance = parameters.blocks.block_height_rms, parameters.analytic.tolerance
    refuse((rms == 0.0, EVEN))
    friction = parameters.analytic.limited(parameters.friction)
    walker, point = find_gait(parameters.biped, parameters.slope, tolerance, friction)
    linear = on_blocks(walker, point, tolerance)
    if linear is None:
        raise NoGait(refusal(walker) or "the gait is unstable: on even ground too a walk leaves it")
    found, ways = passage(parameters, options, asking, point.z.tolist())
    degrees = linear.sensitivity_norm_deg / linear.sensitivity_norm
    plain = {"block_height_rms_m": rms, "block_height_rms_deg": rms / degrees if degrees else None, **as_plain(found),
             "fell": ways, "on_blocks": as_plain(linear)}  # fmt: skip
    return Answer(list(lines(rms, found, ways, linear.sensitivity_norm * rms)), plain)


def passage(
    parameters: Parameters, options: Options, asking: Asking, z: Sequence[float]
) -> tuple[Passage, list[dict[str, Any]]]:
    """Steps to a fall of the gait at section coordinates `z`, and how it falls. Raises BlocksDoNotFit."""
    import numpy as np

    from stages.stability.blocks.passage import FEW, Counted, from_weighed, ways_of
    from stages.stability.blocks.rare import APART, Weighed
    from stages.stability.blocks.walks import KEPT

    rough, counted = rough_of(parameters, z), Counted(options.ramp)
    # refuses blocks that reach too far
    parameters.blocks.under(0, [middle * rough.walker.length for middle in rough.middles])
    parts = options.effort // PART
    walk_on(asking, z, range(FIRST), counted)
    if counted.falls * parts >= FEW * FIRST:
        walk_on(asking, z, range(FIRST, parts), counted)
        return counted.passage(), ways_of(counted.fallen)
    [(known, steps)] = asking.each(learnt, [0], z)
    counted.steps += steps
    walks = int(max(options.effort - counted.steps, LEAST * options.effort)) // ((APART + KEPT) * WEIGHED)
    parts_of = asking.each(weighed_part, list(range(WEIGHED)), z, known, walks)
    found_in = [Weighed(walks, steps, [(ending, weight, np.array(heights)) for ending, weight, heights in falls])
                for steps, falls in parts_of]  # fmt: skip
    return from_weighed(found_in, counted), ways_of([fall for part in found_in for fall in part.falls])


def walk_on(asking: Asking, z: Sequence[float], parts: range, counted: Counted) -> None:
    """Count walks part by part, until falls are enough or the parts are at their end."""
    from stages.stability.blocks.passage import ENOUGH
    from stages.stability.blocks.walks import Walk

    for first in range(parts.start, parts.stop, FIRST):
        if counted.falls >= ENOUGH:
            return
        some = list(range(first, min(first + FIRST, parts.stop)))
        for walks in asking.each(walked, some, z):
            counted.add([Walk(steps, ending, tuple(last)) for steps, ending, *last in walks], PART)
        asking.progress(some[-1] / parts.stop, "walks over blocks")


def rough_of(parameters: Parameters, z: Sequence[float]) -> Rough:
    """The walker of these parameters, with its gait, on the blocks."""
    import numpy as np

    from stages.analytic.gait.design_point import DesignPoint
    from stages.stability.blocks.walks import Rough

    walker = DesignPoint(parameters.biped, parameters.slope).walker()
    blocks = parameters.blocks
    return Rough(walker, np.array(z), blocks.block_height_rms / walker.length, blocks.block_length / walker.length)


def walked(parameters: Parameters, z: Sequence[float], part: int) -> list[list[float]]:
    """Walks of one part, for `Asking.each`: steps, ending, heights of the last blocks."""
    from stages.stability.blocks.walks import some_walks

    walks = some_walks(rough_of(parameters, z), parameters.blocks.block_seed, PART * part, PART)
    return [[walk.steps, walk.ending, *walk.last] for walk in walks]


def learnt(parameters: Parameters, z: Sequence[float], number: int) -> tuple[list[Any], int]:
    """Patterns of blocks that lead to a fall and the steps walked for them, for `Asking.each`."""
    from stages.stability.blocks.rare import learnt_patterns

    found, steps = learnt_patterns(rough_of(parameters, z), parameters.blocks.block_seed + OF_PATTERNS + number)
    return [found.shares.tolist(), found.heights.tolist()], steps


def weighed_part(
    parameters: Parameters, z: Sequence[float], known: Sequence[Any], walks: int, number: int
) -> tuple[int, list[tuple[int, float, list[float]]]]:
    """Steps and falls of one part of the weighed walks, for `Asking.each`."""
    import numpy as np

    from stages.stability.blocks.rare import Patterns, generator_of, weighed

    generator = generator_of(parameters.blocks.block_seed + OF_WEIGHED + number)
    found = weighed(rough_of(parameters, z), Patterns(*map(np.array, known)), generator, walks)
    return found.steps, [(ending, weight, heights.tolist()) for ending, weight, heights in found.falls]


def lines(rms: float, found: Passage, ways: Sequence[Mapping[str, Any]], spread: float) -> Iterator[str]:
    """The answer in words."""
    yield f"blocks of independent normal heights, rms {1e3 * rms:g} mm; {found.walked} steps walked, {found.method}"
    yield (f"mean steps to a fall: {found.steps_to_fall:.4g}, 95 % interval {found.steps_low:.4g} to "
           f"{found.steps_high:.4g}")
    fall, least, most = (1.0 - chance for chance in (found.ramp_chance, found.ramp_high, found.ramp_low))
    yield f"chance to fall within {found.ramp_steps} steps: {fall:.4g}, 95 % interval {least:.4g} to {most:.4g}"
    for way in ways:
        heights = " ".join(f"{height:+.2f}" for height in way["last_blocks_rms"])
        yield f"  {100 * way['share']:5.1f} % {way['ending']}; last blocks {heights} rms"
    yield f"a step's duration spreads by {1e3 * spread:.3g} ms while it walks (linear)"


QUESTION = Question(
    "rough",
    """Tell how many steps the walker makes on blocks of drawn heights (ground.block_height_rms) until it falls.

    Walks are counted; where falls are too rare, heights that lead to one are drawn more often, and weighed. Also how
    they fall, and the mean heights of the last blocks before.
    """,
    Options,
    ask,
    examples=("bipedstudy rough --set ground.block_height_rms=1e-3 --json",),
    pool=True,
)
