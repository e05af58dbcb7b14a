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
    """Bring every stage up to date, then the report. Ends with 3 where a stage or a figure is missing for a reason."""
    from pipeline.cache import untouched

    plain = not (force or dry_run or as_json)
    if plain and (summaries := untouched.recall(study)):
        from pipeline.execution import display

        shows = display.for_terminal(verbose, as_json)
        for name, summary in summaries.items():
            shows.finished(name, "current", 0.0, summary)
        shows.close()
        return
    from pipeline.commands.running import run_stages
    from pipeline.errors import Declined
    from pipeline.report.content import undrawn
    from pipeline.report.page import refresh

    lay = untouched.look(study) if plain else None
    names = tuple(study.graph.stages)
    forced = names if force else ()
    outcomes = run_stages(
        study, names, forced=forced, jobs=jobs, dry_run=dry_run, wait=wait, as_json=as_json, verbose=verbose,
        afterwards=refresh,
    )  # fmt: skip
    if not dry_run and (absent := undrawn(study)):
        raise Declined(absent)
    if all(outcome.how == "current" for outcome in outcomes) and not study.warnings(study.parameters(names)):
        untouched.note(study, lay, {outcome.stage: outcome.summary for outcome in outcomes})
