"""`bipedstudy report`: the page that shows the whole study."""

from __future__ import annotations

from pathlib import Path

import click

from pipeline.commands import options
from pipeline.graph import REPORT
from pipeline.study import Study, shown


@click.command("report", epilog=options.examples("report"))
@options.own_study
@click.option(
    "--into", type=click.Path(dir_okay=False, path_type=Path), help="Write FILE (default: results/report.html)."
)
@click.option("--no-times", is_flag=True, help="Leave out how long stages took: the same results give the same bytes.")
def command(study: Study, into: Path | None, no_times: bool) -> None:
    """Write one self-contained page: claims, figures, animation, parameters, provenance. run-all does this too."""
    from pipeline.cache import disk
    from pipeline.report import page
    from pipeline.report.content import entries
    from pipeline.report.standing import Standing, echo

    made = entries(study)
    names = tuple(study.graph.stages)
    found = Standing(study, names)
    stale = {name: "; ".join(item.reasons) for name, item in found.found.items()}
    echo(f"{found.said(names)}; the page says so" if stale else found.doubt)
    path = into or study.results / REPORT
    disk.write(path, page.render(study, made, not no_times, stale))
    click.echo(f"written: {shown(path)}")
