"""`bipedstudy gait`: the most stable gait of a design."""

from __future__ import annotations

import dataclasses
import importlib
import sys
from typing import Any

import click

from pipeline import options
from pipeline.errors import ANSWER, is_answer
from pipeline.study import Study

_STAGE = "analytic"


@click.command("gait")
@options.study
@options.as_json
def command(study: Study, as_json: bool) -> None:
    """Find the most stable gait of the design in params/ (change it with --set) and print its measures."""
    values = study.parameters([_STAGE])[_STAGE]
    search = importlib.import_module(f"{study.package}.{_STAGE}.gait_search")
    try:
        gait = search.describe(*search.find_gait(values.biped, values.slope, values.settings.tolerance))
    except Exception as reason:
        if not is_answer(reason, study.package):
            raise
        if as_json:
            options.print_json({"gait": None, "reason": str(reason)})
        else:
            click.echo(str(reason), err=True)
        sys.exit(ANSWER)
    if as_json:
        options.print_json(as_plain(gait))
    else:
        for line in lines(gait):
            click.echo(line)


def as_plain(gait: Any) -> dict[str, Any]:
    """A gait as JSON prints it: every measure by its field's name, the fixed point as named values with units."""
    plain: dict[str, Any] = {}
    for field in dataclasses.fields(gait):
        value = getattr(gait, field.name)
        if dataclasses.is_dataclass(value):
            plain[field.name] = {
                part.name: {"value": float(getattr(value, part.name)), "unit": part.metadata["unit"]}
                for part in dataclasses.fields(value)
            }
        else:
            plain[field.name] = value.tolist() if hasattr(value, "tolist") else value
    return plain


def lines(gait: Any) -> list[str]:
    """A gait as a table: description, value, unit."""
    rows = []
    for field in dataclasses.fields(gait):
        value = getattr(gait, field.name)
        if dataclasses.is_dataclass(value):
            rows.append(f"{field.metadata['description']}:")
            rows += [
                f"  {part.metadata['description']:<50} {getattr(value, part.name):>14.9g} {part.metadata['unit']}"
                for part in dataclasses.fields(value)
            ]
        elif field.name == "floquet_multipliers":
            shown = [f"{real:.6g}" if imaginary == 0 else f"{real:.6g}{imaginary:+.6g}j" for real, imaginary in value]
            rows.append(f"{'Floquet multipliers, largest first':<52} {', '.join(shown)}")
        elif isinstance(value, bool):
            rows.append(f"{field.metadata['description']:<52} {'yes' if value else 'no':>14}")
        else:
            rows.append(f"{field.metadata['description']:<52} {value:>14.9g} {field.metadata['unit']}")
    return rows
