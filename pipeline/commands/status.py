"""`bipedstudy status`: which stages are stale, and why."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import click

from pipeline.commands import options
from pipeline.execution.planning import Assessment, State
from pipeline.study import Study

_WORDS = {
    State.CURRENT: "current",
    State.RESTORABLE: "in cache",
    State.STALE: "stale",
    State.WAITING: "waiting",
}


#: Reasons that are named; after an update of the program there may be hundreds.
_SHOWN = 5


@click.command("status")
@options.own_study
@options.as_json
def command(study: Study, as_json: bool) -> None:
    """Say which stages are current, and why the others are not. Runs nothing."""
    from pipeline.execution.planning import Planner

    names = tuple(study.graph.stages)
    print_survey(study, Planner(study, study.parameters(names)).survey(names), as_json)


def print_survey(
    study: Study, survey: Iterable[Assessment], as_json: bool, forced: frozenset[str] = frozenset()
) -> None:
    """Print the state and the reasons of each stage; `forced` stages would run in any case."""
    study.sources.memo.save()
    rows = []
    for item in survey:
        state = _WORDS[State.STALE] if item.name in forced else _WORDS[item.state]
        reasons = ("asked for by --force",) if item.name in forced else item.reasons
        rows.append({"stage": item.name, "state": state, "reasons": list(reasons)})
    if as_json:
        options.print_json(rows)
        return
    for row in rows:
        click.echo(f"{row['stage']:<12} {row['state']:<9} {in_short(row['reasons'])}".rstrip())


def in_short(reasons: Sequence[str]) -> str:
    """The first reasons, and how many more there are."""
    more = f"; and {len(reasons) - _SHOWN} more" if len(reasons) > _SHOWN else ""
    return "; ".join(reasons[:_SHOWN]) + more
