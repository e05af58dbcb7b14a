"""`bipedstudy continue`: follow the gait through a design parameter."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from pipeline.commands import answer, options
from pipeline.errors import StudyError
from pipeline.study import Study


@click.command("continue")
@click.argument("parameter")
@click.argument("limits")
@click.option("--doublings", type=click.IntRange(0, 4), default=0, help="Period doublings to follow as well.")
@options.study
@options.as_json
@answer.figure
def command(study: Study, parameter: str, limits: str, doublings: int, as_json: bool, figure: Path | None) -> None:
    """Follow the design's gait in PARAMETER (as ground.slope_deg) within LIMITS (LOW:HIGH).

    Prints the family's ends, turning points and period doublings; --json prints every point.
    """
    low_high = answer.interval(limits, "LIMITS")
    values = study.parameters([answer.STAGE])[answer.STAGE]
    search, family = answer.module(study, "gait.gait_search"), answer.module(study, "gait.family")
    design = answer.module(study, "gait.design_point").DesignPoint(
        values.biped, values.slope, values.limited_friction
    )
    here = answer.number_of_design(design, parameter)
    if not low_high[0] <= here <= low_high[1]:
        raise StudyError(f"LIMITS {limits} do not hold the design's {parameter} = {here:g}, where the family starts")
    bound = design.bound(parameter)
    for limit in low_high:
        if not bound.holds(limit):
            raise StudyError(f"LIMITS: {parameter} = {limit:g} is not allowed; allowed is {bound}")
    tolerance = values.settings.tolerance
    with answer.or_reason(study, "branches", as_json):
        _, point = search.find_gait(values.biped, values.slope, tolerance, values.limited_friction)
        branches = family.follow_family(design, parameter, low_high, point.z, tolerance, doublings)
    if as_json:
        options.print_json({"parameter": parameter, "branches": [as_plain(branch) for branch in branches]})
    else:
        for line in lines(branches):
            click.echo(line)
    if figure is not None:
        from stages.analytic.pictures import bifurcation
        from stages.drawing import style

        with style.drawing():
            answer.save(figure, bifurcation.draw(branches, parameter, design.unit(parameter)))


def as_plain(branch: Any) -> dict[str, Any]:
    """A branch as JSON: its points, special points and why it ends."""
    return {
        "cycle": branch.cycle,
        "ended": branch.ended,
        "points": [point_as_plain(point) for point in branch.points],
        "special": [{"kind": special.kind, **point_as_plain(special.point)} for special in branch.special],
    }


def point_as_plain(point: Any) -> dict[str, Any]:
    """A gait of a branch as JSON."""
    multipliers = point.floquet_multipliers
    return {
        "value": point.value,
        "period_s": point.period,
        "stable": point.stable,
        "floquet_multipliers": [[float(value.real), float(value.imag)] for value in multipliers],
        "section": point.z.tolist(),
    }


def lines(branches: list[Any]) -> list[str]:
    """The families in words."""
    said = []
    for branch in branches:
        found = [point.value for point in branch.points]
        said.append(
            f"cycle of {branch.cycle}: {branch.name} {min(found):.9g} to {max(found):.9g}, {len(found)} gaits, "
            f"{sum(point.stable for point in branch.points)} stable; ends: {branch.ended}"
        )
        said += [f"  {special.kind} at {special.point.value:.12g}" for special in branch.special]
    return said
