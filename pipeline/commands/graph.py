"""`bipedstudy graph`: the stages and what flows between them."""

from __future__ import annotations

import click

from pipeline import layout
from pipeline.commands import options
from pipeline.study import Study


@click.command("graph", epilog=options.examples("graph"))
@options.study
@options.as_json
def command(study: Study, as_json: bool) -> None:
    """Print the stages in order: what each reads, which parameters it uses, what it makes."""
    graph = study.graph
    if as_json:
        options.print_json(
            [
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
        )
        return
    for stage in graph.stages.values():
        click.echo(stage.name)
        params = [f"{file}.yaml" + (f" ({', '.join(keys)})" if keys else "") for file, keys in stage.parameters.items()]
        for word, items in (("reads", stage.inputs), ("params", params), ("makes", stage.outs)):
            if items:
                click.echo(layout.beside(f"  {word:<7} ", ", ".join(items)))
