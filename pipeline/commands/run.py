"""`bipedstudy run STAGE`."""

from __future__ import annotations

import click

from pipeline import completion
from pipeline.commands import options
from pipeline.study import Study


@click.command("run", epilog=options.examples("run"))
@click.argument("stages", nargs=-1, required=True, metavar="STAGE...", shell_complete=completion.stages)
@options.own_study
@options.requests
@options.running
@options.as_json
def command(
    study: Study,
    stages: tuple[str, ...],
    jobs: int | None,
    force: bool,
    dry_run: bool,
    wait: bool,
    as_json: bool,
    verbose: bool,
) -> None:
    """Bring stages, and first everything they read, up to date; --force applies to the named stages only."""
    from pipeline.commands.running import run_stages

    for stage in stages:
        study.graph.stage(stage)
    names = study.graph.needed_for(stages)
    forced = stages if force else ()
    run_stages(study, names, forced=forced, jobs=jobs, dry_run=dry_run, wait=wait, as_json=as_json, verbose=verbose)
