"""`basin`: which starts lead to the gait."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stages.biped.quantity import Bound
from stages.biped.question import Answer, Asking, Question, interval, option

if TYPE_CHECKING:
    from stages.analytic.parameters import Parameters


@dataclass(frozen=True)
class Options:
    """Options of `basin`."""

    angle: tuple[float, float] = option(
        "rad", "Range of the stance angle at the start", default=(0.02, 0.6), read=interval, metavar="LOW:HIGH")
    rate: tuple[float, float] = option(
        "rad/s", "Range of the stance rate at the start", default=(0.5, 6.0), read=interval, metavar="LOW:HIGH")
    points: int = option("1", "Points a side", default=100, bound=Bound(minimum=2, maximum=2000))
    steps: int = option("1", "Most steps of a walk", default=30, bound=Bound(minimum=1, maximum=10_000))


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Walk from every start of the grid. Raises NoGait."""
    import numpy as np

    from stages.analytic.gait.basin import basin_of_attraction
    from stages.analytic.gait.gait_search import find_gait

    tolerance = parameters.settings.tolerance
    walker, point = find_gait(parameters.biped, parameters.slope, tolerance, parameters.limited_friction)
    mapped = basin_of_attraction(
        walker,
        [point.z],
        (0, 1 if walker.rigid else 3),
        -np.linspace(*options.angle, options.points),
        np.linspace(*options.rate, options.points) * walker.time,
        steps=options.steps,
        workers=asking.jobs,
        progress=lambda share: asking.progress(share, "starts"),
    )
    share = float((mapped.reached >= 0).mean())

    def draw(save: Any) -> None:
        from stages.analytic.pictures import basin_map
        from stages.drawing import style

        with style.drawing():
            save(basin_map.draw(mapped, walker.time, point.z, options.steps))

    plain = {
        "stance_angle_rad": mapped.first.tolist(),
        "stance_rate_rad_s": (mapped.second / walker.time).tolist(),
        "share_reached": share,
        "steps_survived": mapped.survived.tolist(),
        "gait_reached": mapped.reached.tolist(),
    }
    starts = f"{options.points} x {options.points} starts"
    return Answer([f"{starts}: {100 * share:.2f} % reach the gait within {options.steps} steps"], plain, draw=draw)


QUESTION = Question(
    "basin",
    """Walk from a grid of starts just after heel strike; the other section coordinates are the gait's.

    Prints the share that reaches the gait; --json prints steps survived and gait reached (-1: none) for every start.
    """,
    Options,
    ask,
    examples=("bipedstudy basin --points 60 --figure basin.png",),
    draws=True,
    pool=True,
)
