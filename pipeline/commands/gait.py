"""`bipedstudy gait`: the gaits of a design."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import click

from pipeline.commands import answer, options
from pipeline.study import Study


@click.command("gait")
@click.option(
    "--all", "every", is_flag=True, help="Every gait found, unstable ones too, and stable cycles of 2, 4, 8 steps."
)
@options.study
@options.as_json
@answer.figure
def command(study: Study, every: bool, as_json: bool, figure: Path | None) -> None:
    """Find the most stable gait of the design in params/ (change it with --set) and print its measures.

    With them: the energy audit of a step, and what the gait asks of the ground.
    """
    checked = study.parameters([answer.STAGE])
    for sentence in study.warnings(checked):
        click.echo(f"warning: {sentence}", err=True)
    values = checked[answer.STAGE]
    tolerance = values.settings.tolerance
    search, report = answer.module(study, "gait.gait_search"), answer.module(study, "gait.gait_report")
    with answer.or_reason(study, "gait", as_json):
        walker, point = search.find_gait(values.biped, values.slope, tolerance, values.limited_friction)
        points = search.find_gaits(walker, tolerance, unstable=True) if every else [point]
        found = [report.report_gait(walker, each, tolerance) for each in points]
        cycle = None
        if every and not found[0].gait.stable:
            cycle = answer.module(study, "gait.cycles").find_cycle(walker, points[0].z, tolerance)
    if as_json:
        plain = [as_plain(each) for each in found]
        options.print_json({"gaits": plain, "cycle": cycle_as_plain(walker, cycle)} if every else plain[0])
    else:
        for number, each in enumerate(found, 1):
            if every:
                click.echo(f"gait {number} of {len(found)}, {'stable' if each.gait.stable else 'unstable'}")
            for line in lines(each):
                click.echo(line)
        if cycle is not None:
            click.echo(
                f"stable cycle of {cycle[0]} steps, period {sum(s.period for s in cycle[1].steps) * walker.time:.9g} s"
            )
    if figure is not None:
        from stages.analytic.pictures import gait_portrait
        from stages.drawing import style

        with style.drawing():
            answer.save(figure, gait_portrait.draw(walker, points, tolerance))


def as_plain(report: Any) -> dict[str, Any]:
    """A gait as JSON: every measure by its name, the fixed point with units, its energy and validity."""
    return {
        **fields_as_plain(report.gait),
        "energy": fields_as_plain(report.energy),
        "validity": fields_as_plain(report.validity),
    }


def cycle_as_plain(walker: Any, cycle: Any) -> dict[str, Any] | None:
    """A cycle of several steps as JSON."""
    if cycle is None:
        return None
    steps, point = cycle
    multipliers = point.floquet_multipliers
    return {
        "steps": steps,
        "period_s": sum(step.period for step in point.steps) * walker.time,
        "floquet_multipliers": [[float(value.real), float(value.imag)] for value in multipliers],
    }


def fields_as_plain(record: Any) -> dict[str, Any]:
    """The fields of a result as JSON; a nested one as named values with units."""
    plain: dict[str, Any] = {}
    for field in dataclasses.fields(record):
        value = getattr(record, field.name)
        if dataclasses.is_dataclass(value):
            plain[field.name] = {
                part.name: {"value": float(getattr(value, part.name)), "unit": part.metadata["unit"]}
                for part in dataclasses.fields(value)
            }
        else:
            plain[field.name] = value.tolist() if hasattr(value, "tolist") else value
    return plain


def lines(report: Any) -> list[str]:
    """A gait, its energy and its validity as a table: description, value, unit."""
    return [*field_lines(report.gait), *field_lines(report.energy), *field_lines(report.validity)]


def field_lines(record: Any) -> list[str]:
    """The fields of a result, a line each."""
    rows = []
    for field in dataclasses.fields(record):
        value = getattr(record, field.name)
        about = field.metadata["description"]
        if dataclasses.is_dataclass(value):
            rows.append(f"{about}:")
            rows += [f"  {line}" for line in field_lines(value)]
        elif field.name == "floquet_multipliers":
            shown = [f"{real:.6g}" if imaginary == 0 else f"{real:.6g}{imaginary:+.6g}j" for real, imaginary in value]
            rows.append(f"{'Floquet multipliers, largest first':<72} {', '.join(shown)}")
        elif isinstance(value, bool):
            rows.append(f"{about:<72} {'yes' if value else 'no':>14}")
        else:
            rows.append(f"{about:<72} {value:>14.9g} {field.metadata['unit']}")
    return rows
