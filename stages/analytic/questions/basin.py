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
    rate: tuple[float, float] | None = option(
        "rad/s", "Range of the stance rate at the start (default: 0.5:6 at the pace of Table 1's pendulum)",
        default=None, read=interval, metavar="LOW:HIGH")
    points: int = option("1", "Points a side", default=100, bound=Bound(minimum=2, maximum=2000))
    steps: int = option("1", "Most steps of a walk", default=30, bound=Bound(minimum=1, maximum=10_000))


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Walk from every start of the grid. Raises NoGait."""
    import numpy as np

    from stages.analytic.errors import NoGait
    from stages.analytic.gait.basin import basin_of_attraction
    from stages.analytic.gait.gait_search import find_gait
    from stages.analytic.gait.poincare import by_stability
    from stages.analytic.result import ENDINGS
    from stages.biped.accuracy.scales import quickness

    tolerance = parameters.settings.tolerance
    quick = quickness(parameters.biped, parameters.slope.gravity)
    slow, fast = options.rate or (0.5 * quick, 6.0 * quick)
    walker, point = find_gait(parameters.biped, parameters.slope, tolerance, parameters.limited_friction)
    if by_stability(point) >= 1.0:
        raise NoGait("the gait is unstable: no start stays with it")
    mapped = basin_of_attraction(
        walker,
        point.z,
        np.linspace(*options.angle, options.points),
        np.linspace(slow, fast, options.points),
        steps=options.steps,
        workers=asking.jobs,
        progress=lambda share: asking.progress(share, "starts"),
    )

    def draw(save: Any) -> None:
        from stages.analytic.pictures import families
        from stages.drawing import style

        with style.drawing():
            save(families.draw_basin(mapped))

    rows = [
        {"stance_angle_rad": angle, "stance_rate_rad_s": rate, "steps": int(mapped.steps[i, j]),
         "ending": ENDINGS[mapped.ending[i, j]]}
        for i, angle in enumerate(mapped.stance_angle.tolist()) for j, rate in enumerate(mapped.stance_rate.tolist())
    ]  # fmt: skip
    plain = {
        "stance_angle_rad": mapped.stance_angle.tolist(),
        "stance_rate_rad_s": mapped.stance_rate.tolist(),
        "share_reached": mapped.share,
        "steps": mapped.steps.tolist(),
        "endings": ENDINGS,
        "ending": mapped.ending.tolist(),
        "gait_reached": mapped.reached.tolist(),
    }
    starts = f"{options.points} x {options.points} starts"
    lines = [f"{starts}: {100 * mapped.share:.2f} % reach the gait within {options.steps} steps",
             "        of angles {:g} to {:g} rad and rates {:.3g} to {:.3g} rad/s".format(*options.angle, slow, fast)]
    lines += [f"{100 * float((mapped.ending == number).mean()):6.2f} %  {words}"
              for number, words in enumerate(ENDINGS) if number and (mapped.ending == number).any()]  # fmt: skip
    return Answer(lines, plain, draw=draw, rows=rows)


QUESTION = Question(
    "basin",
    """Walk from a grid of starts just after heel strike; the other section coordinates are the gait's.

    Prints the share that reaches the gait and how the others end; --csv and --json print it for every start.
    """,
    Options,
    ask,
    examples=("bipedstudy basin --points 60 --figure basin.png",),
    draws=True,
    pool=True,
    rows=True,
)
