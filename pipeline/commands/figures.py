"""`bipedstudy figures`: what is drawn, a figure of one's own edit, and whether all would be drawn again."""

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
@click.argument("names", nargs=-1, metavar="NAME...")
@options.own_study
@click.option(
    "--into",
    metavar="DIR",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder for figures that are named (default: results/drawn; results/figures are the stage's own).",
)
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
@click.option("--exact", is_flag=True, help="Any other byte is a difference, also in PDF: for results of this machine.")
def command(
    study: Study, names: tuple[str, ...], into: Path | None, check: bool, against: Path | None, tolerance: float,
    exact: bool,
) -> None:  # fmt: skip
    """Draw the figures that are named, in seconds and from the artefacts alone; the beginning of a name is enough.

    Without names list all figures, or with --check draw them anew and compare. Differences are drawn into
    results/differences.
    """
    from pipeline.report.drawing import FIGURES, draw

    if names:
        if check or against or exact:
            raise click.UsageError("--check, --against and --exact are for all figures: give no names")
        for files, caption in draw(study, names, into or study.results / "drawn"):
            click.echo("\n".join([*map(shown, files), caption]))
        return
    expected = against or study.store.place(FIGURES)
    if not expected.is_dir():
        raise StudyError(f"{shown(expected)} is not there yet; make it with: bipedstudy run-all")
    present = sorted(path.name for path in expected.iterdir() if not path.name.startswith("."))
    if not check:
        for name in present:
            click.echo(shown(expected / name))
        return
    with tempfile.TemporaryDirectory(prefix="bipedstudy-") as folder:
        for _ in draw(study, [""], Path(folder)):
            pass
        found = compare(expected, Path(folder), study.results / "differences", tolerance)
    for difference in found:
        place = f"; see {shown(difference.picture)}" if difference.picture else ""
        click.echo(f"{difference.name} {difference.what}{place}")
    failed = [difference for difference in found if difference.fails or exact]
    click.echo(f"{len(present)} files, {len(found)} differ, {len(failed)} of them beyond what is allowed")
    if failed:
        sys.exit(FAILED)
