"""`bipedstudy graph`: the stages and what flows between them."""

from __future__ import annotations

from typing import Any

import click

from pipeline import layout
from pipeline.commands import options
from pipeline.study import Study


@click.command("graph", epilog=options.examples("graph"))
@options.study
@options.as_json
@options.as_csv
def command(study: Study, as_json: bool, as_csv: bool) -> None:
    """Print the stages in order: what each reads, which parameters it uses, what it makes."""
    options.one_form(json=as_json, csv=as_csv)
    graph = study.graph
    rows: list[dict[str, Any]] = [
        {
            "stage": stage.name,
            "reads": list(stage.inputs),
            "upstream": list(graph.upstream(stage.name)),
            "params": {file: list(keys) if keys else None for file, keys in stage.parameters.items()},
            "makes": list(stage.outs),
            "code": list(stage.code),
        }
        for stage in graph.stages.values()
    ]
    if as_json:
        options.print_json(rows)
        return
    if as_csv:
        options.print_csv([{key: " ".join(value) if key != "stage" else value for key, value in row.items()}
                           for row in rows])  # fmt: skip
        return
    for stage in graph.stages.values():
        click.echo(stage.name)
        params = [f"{file}.yaml" + (f" ({', '.join(keys)})" if keys else "") for file, keys in stage.parameters.items()]
        for word, items in (("reads", stage.inputs), ("params", params), ("makes", stage.outs)):
            if items:
                click.echo(layout.beside(f"  {word:<7} ", ", ".join(items)))
