"""`bipedstudy figures`: what is drawn, a figure of one's own edit, and whether all would be drawn again."""

from __future__ import annotations

import contextlib
import sys
import tempfile
from pathlib import Path

import click

from pipeline import completion
from pipeline.cache import disk, fingerprint, processor
from pipeline.commands import options
from pipeline.errors import FAILED, Declined, StudyError
from pipeline.execution import display
from pipeline.report import standing
from pipeline.report.pictures import TOLERANCE, compare
from pipeline.study import Study, shown


@click.command("figures", epilog=options.examples("figures"))
@click.argument("names", nargs=-1, metavar="NAME...", shell_complete=completion.figures)
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
    help=f"Largest rms difference of pixels, in grey levels of 255 (default: {TOLERANCE:g}, or none at all for figures "
    "made by such a processor and by such versions as there are here).",
)
@click.option("--exact", is_flag=True, help="Any other byte is a difference, also in PDF.")
def command(
    study: Study, names: tuple[str, ...], into: Path | None, check: bool, against: Path | None,
    tolerance: float | None, exact: bool,
) -> None:  # fmt: skip
    """Draw the figures that are named, in seconds and from the artefacts alone; the beginning of a name is enough.

    Without names list all figures, or with --check draw them anew and compare. Differences are drawn into
    results/differences.
    """
    from pipeline.report.drawing import FIGURES, draw

    if names:
        if check or against or exact:
            raise click.UsageError("--check, --against and --exact are for all figures: give no names")
        noted: set[str] = set()
        for files, caption, said in draw(study, names, into or study.results / "drawn"):
            standing.echo("" if said in noted else said)
            noted.add(said)
            click.echo("\n".join([*map(shown, files), caption]))
        return
    expected = against or study.store.place(FIGURES)
    if not expected.is_dir():
        raise StudyError(f"{shown(expected)} is not there yet; make it with: bipedstudy run-all")
    present = sorted(path.name for path in expected.iterdir() if not path.name.startswith("."))
    if against is None:
        standing.say(study, *study.graph.needed_for((study.graph.maker(FIGURES),)))
    if not check:
        for name in present:
            click.echo(shown(expected / name))
        return
    how, exact = _strictness(study, exact, tolerance, against)
    shows = display.for_terminal(False, False)
    count = len({Path(name).stem for name in present})
    with tempfile.TemporaryDirectory(prefix="bipedstudy-") as folder:
        try:
            with contextlib.suppress(Declined):  # what is there and is not drawn is told below
                for number, _ in enumerate(draw(study, [""], Path(folder), marked=False), 1):
                    shows.points(min(number, count), max(count, 1), f"{number} figures drawn")
        finally:
            shows.close()
        found = compare(
            expected, Path(folder), study.results / "differences", TOLERANCE if tolerance is None else tolerance
        )
    for difference in found:
        place = f"; see {shown(difference.picture)}" if difference.picture else ""
        click.echo(f"{difference.name} {difference.what}{place}")
    failed = [difference for difference in found if difference.fails or exact]
    click.echo(f"{len(present)} files, {len(found)} differ, {len(failed)} of them beyond what is allowed: {how}")
    if failed:
        sys.exit(FAILED)


def _strictness(study: Study, exact: bool, tolerance: float | None, against: Path | None) -> tuple[str, bool]:
    """How figures are compared, in words, and whether byte by byte: as they were made here, or as it was asked for."""
    if exact:
        return "byte by byte, as asked for", True
    if tolerance is not None:
        return f"{tolerance:g} of 255 rms, as asked for", False
    allowed = f"{TOLERANCE:g} of 255 rms"
    if against is not None:
        return f"{allowed}, as nothing tells what processor made those in {shown(against)}", False
    from pipeline.cache import artefact
    from pipeline.report.drawing import FIGURES

    stage = next(stage for stage in study.graph.stages.values() if FIGURES in stage.outs)
    place = study.store.place(stage.artefact)
    if not place.exists():
        return f"{allowed}, as {shown(place)} is not there to tell what made them", False
    about = artefact.provenance(disk.content(place, shown(place)), shown(place))
    if fingerprint.made_as_here(about):
        return "byte by byte, as they were made by such a processor and such versions as there are here", True
    made, here = about.get("processor", "an unknown processor"), processor.words()
    return f"{allowed}, as they were made by {made if made != here else 'other versions'}, and here is {here}", False
