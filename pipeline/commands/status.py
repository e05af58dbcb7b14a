"""`bipedstudy status`: which stages are stale, and why; `bipedstudy graph`: the stages and what flows between them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import click

from pipeline import layout
from pipeline.commands import options
from pipeline.execution.executor import Planner, State
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
@options.answers
def status(study: Study, form: options.Form) -> None:
    """Say which stages are current, and why the others are not. Runs nothing."""
    survey(study, study.parameters(study.graph.stages), form)


def survey(
    study: Study, values: Mapping[str, Any], form: options.Form, forced: frozenset[str] = frozenset()
) -> None:  # fmt: skip
    """Give the state and the reasons of each stage in `values`, its parameters; `forced` ones would run in any case."""
    rows: list[dict[str, Any]] = []
    for item in Planner(study, values).survey(tuple(values)):
        state, reasons = _WORDS[item.state], item.reasons
        if item.name in forced:
            state, reasons = _WORDS[State.STALE], ("asked for by --force",)
        elif item.state is State.CURRENT and item.entry is not None and item.entry.refused:
            state, reasons = "refused", (item.entry.summary,)
        rows.append({"stage": item.name, "state": state, "reasons": list(reasons)})
    study.sources.memo.save()
    form.give(
        (layout.beside(f"{row['stage']:<13} {row['state']:<8} ", in_short(row["reasons"])) for row in rows),
        rows, ({**row, "reasons": "; ".join(row["reasons"])} for row in rows),
    )  # fmt: skip


@click.command("graph", epilog=options.examples("graph"))
@options.study
@options.answers
def graph(study: Study, form: options.Form) -> None:
    """Print the stages in order: what each reads, which parameters it uses, what it makes."""
    rows: list[dict[str, Any]] = [
        {
            "stage": stage.name,
            "reads": list(stage.inputs),
            "upstream": list(study.graph.upstream(stage.name)),
            "params": {file: list(keys) if keys else None for file, keys in stage.parameters.items()},
            "makes": list(stage.outs),
            "code": list(stage.code),
        }
        for stage in study.graph.stages.values()
    ]
    flat = ({key: " ".join(value) if key != "stage" else value for key, value in row.items()} for row in rows)
    form.give((line for row in rows for line in _flow(row)), rows, flat)


def _flow(row: Mapping[str, Any]) -> Iterator[str]:
    """A stage, and below it what it reads, which parameters it uses and what it makes."""
    yield row["stage"]
    files = [f"{file}.yaml" + (f" ({', '.join(keys)})" if keys else "") for file, keys in row["params"].items()]
    for word, items in (("reads", row["reads"]), ("params", files), ("makes", row["makes"])):
        if items:
            yield layout.beside(f"  {word:<7} ", ", ".join(items))
