"""`bipedstudy figures`: what is drawn, and whether it would be drawn again."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import click

from pipeline.commands import options
from pipeline.errors import FAILED, StudyError
from pipeline.report.pictures import TOLERANCE, compare
from pipeline.study import Study, shown


@click.command("figures")
@options.own_study
@click.option("--check", is_flag=True, help="Draw anew from the artefacts and compare; exit with 1 if they differ.")
@click.option(
    "--against",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Compare with the figures in DIR (default: results/figures).",
)
@click.option(
    "--tolerance",
    type=click.FloatRange(min=0),
    default=TOLERANCE,
    show_default=True,
    help="Largest rms difference of pixels, in grey levels of 255.",
)
@click.option("--exact", is_flag=True, help="Any other byte is a difference, also in PDF.")
def command(study: Study, check: bool, against: Path | None, tolerance: float, exact: bool) -> None:
    """List the figures, or with --check draw them anew and compare. Differences are drawn into results/differences."""
    from pipeline.report.redraw import FIGURES, redraw

    expected = against or study.store.place(FIGURES)
    if not expected.is_dir():
        raise StudyError(f"{shown(expected)} is not there yet; make it with: bipedstudy run-all")
    names = sorted(path.name for path in expected.iterdir() if not path.name.startswith("."))
    if not check:
        for name in names:
            click.echo(shown(expected / name))
        return
    with tempfile.TemporaryDirectory(prefix="bipedstudy-") as folder:
        drawn = redraw(study, Path(folder))
        found = compare(expected, drawn, study.results / "differences", tolerance)
    for difference in found:
        place = f"; see {shown(difference.picture)}" if difference.picture else ""
        click.echo(f"{difference.name} {difference.what}{place}")
    failed = [difference for difference in found if difference.fails or exact]
    click.echo(f"{len(names)} files, {len(found)} differ, {len(failed)} of them beyond what is allowed")
    if failed:
        sys.exit(FAILED)
