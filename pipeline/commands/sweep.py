"""`bipedstudy sweep SPEC.yaml`: one stage at many points."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline import layout
from pipeline.commands import options
from pipeline.commands.show import plain_values
from pipeline.errors import ANSWER, StudyError
from pipeline.study import Study, shown

if TYPE_CHECKING:
    from pipeline.sweep.sweep import Summary


@click.command("sweep", epilog=options.examples("sweep"))
@click.argument("spec", type=click.Path(dir_okay=False, path_type=Path), metavar="SPEC")
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="The table (default: results/sweeps).")
@click.option("--jobs", "-j", metavar="N", type=click.IntRange(min=1), help="Processes (default: cores).")
@click.option("--cluster", metavar="ADDRESS", help="Compute on the dask cluster of the scheduler at ADDRESS.")
@click.option("--tls-ca-file", metavar="FILE", help="Authority of the cluster's certificates, for ADDRESS = tls://...")
@click.option("--tls-cert", metavar="FILE", help="Certificate that shows who you are.")
@click.option("--tls-key", metavar="FILE", help="Its key, if it is not in the certificate's file.")
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
    cluster: str | None,
    tls_ca_file: str | None,
    tls_cert: str | None,
    tls_key: str | None,
    dry_run: bool,
    wait: bool,
    as_json: bool,
    as_csv: bool,
) -> None:
    """Compute a stage at every point that the file SPEC describes, and write one table with a row for each.

    docs/sweeps.md shows how a SPEC is written. What was computed before is not computed again, also after an
    interruption. A point without a result is a row with its reason; ends with 3 if no point has one.
    """
    from pipeline.cache import lock
    from pipeline.execution import display
    from pipeline.sweep import spec as specs
    from pipeline.sweep.sweep import Sweep

    options.one_form(json=as_json, csv=as_csv)
    if jobs and cluster:
        raise StudyError("--jobs is for this machine; a cluster has as many workers as it has")
    files = {"tls_ca_file": tls_ca_file, "tls_client_cert": tls_cert, "tls_client_key": tls_key}
    certificates = {name: file for name, file in files.items() if file}
    if certificates and not cluster:
        raise StudyError("--tls-ca-file, --tls-cert and --tls-key are for --cluster tls://...")
    for file in certificates.values():
        if not Path(file).is_file():
            raise StudyError(f"--cluster {cluster}: there is no file {file}")
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
        lock.held(sweep.folder, shown(sweep.folder), said, wait, shows.note),
        _client(cluster, certificates, shows.note) as (client, workers),
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


@contextlib.contextmanager
def _client(address: str | None, certificates: Mapping[str, str], note: Callable[[str], None]) -> Iterator[Any]:
    if address is None:
        yield None, 0
        return
    from pipeline.sweep import cluster

    if cluster.is_open(address):
        note(f"the way to {address} is not encrypted, and whoever reaches that port can run programs there as you can; "
             "docs/sweeps.md has the way with certificates")  # fmt: skip
    client = cluster.connected(address, certificates)
    try:
        yield client, cluster.threads(client)
    finally:
        client.close()
