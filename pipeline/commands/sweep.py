"""`bipedstudy sweep SPEC.yaml`: one stage at many points."""

from __future__ import annotations

import dataclasses
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline import layout
from pipeline.cache import disk
from pipeline.commands import options
from pipeline.commands.show import plain_values
from pipeline.errors import ANSWER
from pipeline.execution import display
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
@options.answers
def sweep(
    study: Study, spec: Path, out: Path | None, jobs: int | None, cluster: cluster_options.Cluster, dry_run: bool,
    wait: bool, form: options.Form,
) -> None:  # fmt: skip
    """Compute a stage at every point that the file SPEC describes, and write one table with a row for each.

    docs/sweeps.md shows how a SPEC is written. What was computed before is not computed again, also after an
    interruption. A point without a result is a row with its reason; ends with 3 if no point has one.
    """
    from pipeline.sweep import spec as specs
    from pipeline.sweep.sweep import Sweep

    shows = display.for_terminal(False, not form.is_text)
    made = Sweep(study, specs.read(spec), shows)
    if dry_run:
        names, varied = ", ".join(made.chain.touched), ", ".join(made.spec.names)
        for line in layout.folded(f"{len(made.points)} points, each computes {names}; varied: {varied}"):
            click.echo(line)
        return
    target = out or made.folder / f"{spec.stem}.h5"
    said = " ".join(["bipedstudy", *sys.argv[1:]])
    with (
        disk.locked(made.folder, shown(made.folder), said, wait, shows.note),
        cluster.client(shows.note) as (client, workers),
    ):
        summary = made.run(target, workers or jobs or os.cpu_count() or 1, client)
    form.give(_lines(summary, target), {**dataclasses.asdict(summary), "busy": summary.busy, "table": shown(target)},
              _rows(target))  # fmt: skip
    if not summary.outcomes.get("computed"):
        sys.exit(ANSWER)


def _lines(summary: Summary, target: Path) -> Iterator[str]:
    """A sweep's summary: outcomes, what it cost, and where its table is."""
    parts = [f"{count} {outcome}" for outcome, count in sorted(summary.outcomes.items())]
    yield from layout.folded(f"{summary.points} points: {', '.join(parts)}; {summary.reused} were known")
    if summary.busy is not None:
        yield from layout.folded(f"{summary.computed_now} points in {summary.seconds:.1f} s on {summary.workers} "
                                 f"workers; {100 * summary.busy:.0f} % of their time went into points")  # fmt: skip
    yield f"table: {shown(target)}"


def _rows(path: Path) -> Iterator[dict[str, Any]]:
    """The rows of a sweep's table."""
    import h5py

    with h5py.File(path) as file:
        columns = {name: plain_values(item) for name, item in file["table"].items()}
    yield from (dict(zip(columns, row)) for row in zip(*columns.values()))
