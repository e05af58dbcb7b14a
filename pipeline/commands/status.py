"""`bipedstudy status`: which stages are stale, and why."""

from __future__ import annotations

from collections.abc import Iterable

import click

from pipeline import layout
from pipeline.commands import options
from pipeline.execution.executor import Assessment, State
from pipeline.report.standing import in_short
from pipeline.study import Study

_WORDS = {
    State.CURRENT: "current",
    State.RESTORABLE: "in cache",
    State.STALE: "stale",
    State.WAITING: "waiting",
}


@click.command("status", epilog=options.examples("status"))
@options.own_study
@options.as_json
@options.as_csv
def command(study: Study, as_json: bool, as_csv: bool) -> None:
    """Say which stages are current, and why the others are not. Runs nothing."""
    from pipeline.execution.executor import Planner

    options.one_form(json=as_json, csv=as_csv)
    names = tuple(study.graph.stages)
    print_survey(study, Planner(study, study.parameters(names)).survey(names), as_json, as_csv=as_csv)


def print_survey(
    study: Study, survey: Iterable[Assessment], as_json: bool, forced: frozenset[str] = frozenset(),
    as_csv: bool = False,
) -> None:
    """Print the state and the reasons of each stage; `forced` stages would run in any case."""
    study.sources.memo.save()
    rows = []
    for item in survey:
        state = _WORDS[State.STALE] if item.name in forced else _WORDS[item.state]
        reasons = ("asked for by --force",) if item.name in forced else item.reasons
        if item.state is State.CURRENT and item.entry is not None and item.entry.refused and item.name not in forced:
            state, reasons = "refused", (item.entry.summary,)
        rows.append({"stage": item.name, "state": state, "reasons": list(reasons)})
    if as_json:
        options.print_json(rows)
        return
    if as_csv:
        options.print_csv([{**row, "reasons": "; ".join(row["reasons"])} for row in rows])
        return
    for row in rows:
        click.echo(layout.beside(f"{row['stage']:<13} {row['state']:<8} ", in_short(row["reasons"])))
