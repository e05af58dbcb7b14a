"""`bipedstudy sweep SPEC.yaml`: one stage at many points."""

from __future__ import annotations

import dataclasses
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline import layout
from pipeline.commands import options
from pipeline.commands.show import plain_values
from pipeline.errors import ANSWER
from pipeline.study import Study, shown
from pipeline.sweep import cluster_options

if TYPE_CHECKING:
    from pipeline.sweep.sweep import Summary


@click.command("sweep", epilog=options.examples("sweep"))
@click.argument("spec", type=click.Path(dir_okay=False, path_type=Path), metavar="SPEC")
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="The table (default: results/sweeps).")
@cluster_options.offered
@click.option("--dry-run", is_flag=True, help="Say how many points there are and what each computes; run nothing.")
@click.option("--wait", is_flag=True, help="Wait for another sweep in the same results folder.")
@options.own_study
@options.as_json
@options.as_csv
def command(
    study: Study,
    spec: Path,
    out: Path | None,
    jobs: int | None,
    cluster: cluster_options.Cluster,
    dry_run: bool,
    wait: bool,
    as_json: bool,
    as_csv: bool,
) -> None:
    """Compute a stage at every point that the file SPEC describes, and write one table with a row for each.

    docs/sweeps.md shows how a SPEC is written. What was computed before is not computed again, also after an
    interruption. A point without a result is a row with its reason; ends with 3 if no point has one.
    """
    from pipeline.cache import disk
    from pipeline.execution import display
    from pipeline.sweep import spec as specs
    from pipeline.sweep.sweep import Sweep

    options.one_form(json=as_json, csv=as_csv)
    shows = display.for_terminal(False, as_json or as_csv)
    sweep = Sweep(study, specs.read(spec), shows)
    names = ", ".join(sweep.chain.touched)
    if dry_run:
        varied = ", ".join(sweep.spec.names)
        click.echo("\n".join(layout.folded(f"{len(sweep.points)} points, each computes {names}; varied: {varied}")))
        return
    target = out or sweep.folder / f"{spec.stem}.h5"
    said = " ".join(["bipedstudy", *sys.argv[1:]])
    with (
        disk.locked(sweep.folder, shown(sweep.folder), said, wait, shows.note),
        cluster.client(shows.note) as (client, workers),
    ):
        summary = sweep.run(target, workers or jobs or os.cpu_count() or 1, client)
    if as_json:
        options.print_json({**dataclasses.asdict(summary), "busy": summary.busy, "table": shown(target)})
    elif as_csv:
        options.print_csv(rows_of(target))
    else:
        for line in lines(summary):
            click.echo("\n".join(layout.folded(line)))
        click.echo(f"table: {shown(target)}")
    if not summary.outcomes.get("computed"):
        sys.exit(ANSWER)


def lines(summary: Summary) -> list[str]:
    """A sweep's summary: outcomes, and what it cost."""
    parts = [f"{count} {outcome}" for outcome, count in sorted(summary.outcomes.items())]
    said = [f"{summary.points} points: {', '.join(parts)}; {summary.reused} were known"]
    if summary.busy is not None:
        said.append(f"{summary.computed_now} points in {summary.seconds:.1f} s on {summary.workers} workers; "
                    f"{100 * summary.busy:.0f} % of their time went into points")  # fmt: skip
    return said


def rows_of(path: Path) -> list[dict[str, Any]]:
    """The rows of a sweep's table."""
    import h5py

    with h5py.File(path) as file:
        columns = {name: plain_values(item) for name, item in file["table"].items()}
    return [dict(zip(columns, row)) for row in zip(*columns.values())]
