"""`bipedstudy run-all`."""

from __future__ import annotations

import click

from pipeline.commands import options
from pipeline.study import Study


@click.command("run-all", epilog=options.examples("run-all"))
@options.own_study
@options.requests
@options.running
@options.as_json
def command(
    study: Study, jobs: int | None, force: bool, dry_run: bool, wait: bool, as_json: bool, verbose: bool
) -> None:
    """Bring every stage up to date, then the report."""
    from pipeline.commands.running import run_stages
    from pipeline.report.page import refresh

    names = tuple(study.graph.stages)
    forced = names if force else ()
    run_stages(
        study, names, forced=forced, jobs=jobs, dry_run=dry_run, wait=wait, as_json=as_json, verbose=verbose,
        afterwards=refresh,
    )  # fmt: skip
