"""`bipedstudy show ARTEFACT`: what is inside a result."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline import requests
from pipeline.cache import regular
from pipeline.commands import options
from pipeline.errors import StudyError, nearest
from pipeline.stage_modules import result_class
from pipeline.study import Study, shown

if TYPE_CHECKING:
    from pipeline.cache.artefact import Field


@click.command("show")
@click.argument("artefact")
@options.own_study
@options.as_json
def command(study: Study, artefact: str, as_json: bool) -> None:
    """Print the fields of ARTEFACT, a stage's name or a file, with units, shapes and values, and its tables."""
    from pipeline.cache import artefact as artefacts
    from pipeline.cache import links

    path = _path(study, artefact)
    content = regular.content(path, shown(path))
    links.check(content, shown(path))
    fields = artefacts.tree(content, shown(path))
    about = artefacts.provenance(content, shown(path))
    if as_json:
        options.print_json({"file": shown(path), "fields": [_plain(field) for field in fields], "provenance": about})
        return
    click.echo(f"{shown(path)}: stage {about.get('stage', '?')}, key {about.get('key', '?')}")
    for line in requests.kept(study, about):
        click.echo(line)
    for field in fields:
        click.echo(_line(field))
    for title, columns, rows in _tables(study, content, about.get("stage", ""), shown(path)):
        print_table(title, columns, rows)


def _path(study: Study, name: str) -> Path:
    if name in study.graph.stages:
        path = study.store.place(study.graph.stages[name].artefact)
        if not path.exists():
            raise StudyError(f"{shown(path)} is not there yet; make it with: bipedstudy run {name}")
        return path
    path = Path(name)
    if not path.exists():
        stages = ", ".join(study.graph.stages)
        raise StudyError(f'"{name}" is neither a stage ({stages}) nor a file{nearest(name, study.graph.stages)}')
    return path


def _line(field: Field) -> str:
    depth = field.path.count("/")
    name = "  " * (depth + 1) + field.path.rsplit("/", 1)[-1]
    if field.shape is None:
        return f"{name:<34} {field.description}".rstrip()
    unit = "" if field.unit in ("", "1", "-") else f" {field.unit}"
    if field.value is not None:
        content = f"{_short(field.value)}{unit}"
    elif field.shape == ():
        content = "none"
    else:
        content = f"array {' x '.join(str(size) for size in field.shape)}{unit}"
    return f"{name:<34} {content:<26} {field.description}".rstrip()


def _short(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(_short(item) for item in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _plain(field: Field) -> dict[str, Any]:
    shape = None if field.shape is None else list(field.shape)
    return {"path": field.path, "unit": field.unit, "symbol": field.symbol, "shape": shape, "value": field.value,
            "description": field.description}  # fmt: skip


def _tables(study: Study, content: bytes, stage: str, name: str) -> Any:
    """The tables a result offers by its method `tables()`: (title, column names, rows)."""
    from pipeline.cache import artefact as artefacts

    if stage not in study.graph.stages or study.parameters_class(study.graph.stages[stage]) is None:
        return ()
    cls = result_class(study.package, stage)
    return artefacts.decode(content, cls, name).tables() if hasattr(cls, "tables") else ()


def print_table(title: str, columns: Any, rows: Any) -> None:
    """Print a table with its title, its columns aligned."""
    cells = [[str(column) for column in columns], *([_short(cell) for cell in row] for row in rows)]
    widths = [max(len(row[index]) for row in cells) for index in range(len(cells[0]))]
    click.echo(f"\n{title}")
    for row in cells:
        click.echo("  " + "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths)).rstrip())
