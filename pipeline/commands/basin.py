"""`bipedstudy basin`: which starts lead to the gait."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import click

from pipeline.commands import answer, options
from pipeline.study import Study


@click.command("basin")
@click.option("--angle", default="0.02:0.6", show_default=True, help="Range of the stance angle at the start [rad].")
@click.option("--rate", default="0.5:6", show_default=True, help="Range of the stance rate at the start [rad/s].")
@click.option("--points", type=click.IntRange(2, 2000), default=100, show_default=True, help="Points a side.")
@click.option("--steps", type=click.IntRange(1, 10_000), default=30, show_default=True, help="Most steps of a walk.")
@click.option("--jobs", "-j", metavar="N", type=click.IntRange(min=1), help="Threads (default: cores).")
@options.study
@options.as_json
@answer.figure
def command(
    study: Study, angle: str, rate: str, points: int, steps: int, jobs: int | None, as_json: bool, figure: Path | None
) -> None:
    """Walk from a grid of starts just after heel strike; the other section coordinates are the gait's.

    Prints the share that reaches the gait; --json prints steps survived and gait reached (-1: none) for every start.
    """
    import numpy as np

    angles, rates = answer.interval(angle, "--angle"), answer.interval(rate, "--rate")
    values = study.parameters([answer.STAGE])[answer.STAGE]
    search, basin = answer.module(study, "gait.gait_search"), answer.module(study, "gait.basin")
    with answer.or_reason(study, "basin", as_json):
        walker, point = search.find_gait(values.biped, values.slope, values.settings.tolerance, values.limited_friction)
    first = -np.linspace(*angles, points)
    second = np.linspace(*rates, points) * walker.time
    with click.progressbar(length=1000, label="starts", file=sys.stderr) as bar:
        mapped = basin.basin_of_attraction(
            walker,
            [point.z],
            (0, 1 if walker.rigid else 3),
            first,
            second,
            steps=steps,
            workers=jobs or os.cpu_count() or 1,
            progress=lambda share: bar.update(int(1000 * share) - bar.pos),
        )
    share = float((mapped.reached >= 0).mean())
    if as_json:
        options.print_json(as_plain(mapped, walker.time, share))
    else:
        click.echo(f"{points} x {points} starts: {100 * share:.2f} % reach the gait within {steps} steps")
    if figure is not None:
        from stages.analytic.pictures import basin_map
        from stages.drawing import style

        with style.drawing():
            answer.save(figure, basin_map.draw(mapped, walker.time, point.z, steps))


def as_plain(mapped: Any, time: float, share: float) -> dict[str, Any]:
    """The map as JSON in SI units; rows are stance angles, columns stance rates."""
    return {
        "stance_angle_rad": mapped.first.tolist(),
        "stance_rate_rad_s": (mapped.second / time).tolist(),
        "share_reached": share,
        "steps_survived": mapped.survived.tolist(),
        "gait_reached": mapped.reached.tolist(),
    }
