"""`bipedstudy compare OTHER`: what changed since another results folder."""

from __future__ import annotations

import base64
import sys
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline import layout
from pipeline.commands import options
from pipeline.errors import ANSWER
from pipeline.study import Study, shown

if TYPE_CHECKING:
    from pipeline.changes.folders import Changes

_TEMPLATE = Path(__file__).with_name("page.html")
#: Numbers that are printed (all are in --csv), and on the page; smaller ones, in their units, are round-off as a rule.
_PRINTED, _MOST, _ROUND_OFF = 12, 300, 1e-9


@click.command("compare", epilog=options.examples("compare"))
@click.argument("other", metavar="OTHER", type=click.Path(exists=True, file_okay=False, path_type=Path))
@options.own_study
@click.option("--tolerance", type=click.FloatRange(min=0), default=1e-9, show_default=True,
              help="Relative change of a number that counts as none.")
@click.option("--page", metavar="FILE", type=click.Path(dir_okay=False, path_type=Path),
              help="Write a page with all of it, and pictures side by side.")
@options.as_json
@options.as_csv
def command(
    study: Study, other: Path, tolerance: float, page: Path | None, as_json: bool, as_csv: bool
) -> None:  # fmt: skip
    """Say what changed from the results in OTHER to those of the study: parameters, verdicts, numbers, figures.

    OTHER is a results folder or a study. Ends with 0 if nothing changed and with 3 if something did, or could not be
    compared. --csv prints the numbers.
    """
    options.one_form(json=as_json, csv=as_csv)
    from pipeline.changes.folders import between, plain, rows

    found = between(study, other, tolerance)
    if page is not None:
        from pipeline.cache import disk

        disk.write(page, html(found))
    if as_json:
        options.print_json({**plain(found), "changed": found.any})
    elif as_csv:
        options.print_csv(rows(found))
    else:
        _print(found)
    if page is not None:
        click.echo(f"written: {shown(page)}", err=True)
    if found.any:
        sys.exit(ANSWER)


def _print(found: Changes) -> None:
    for sentence in found.unread:
        click.echo("\n".join(layout.folded(sentence)))
    if not found.any:
        small = f" ({found.small} numbers changed by less)" if found.small else ""
        click.echo(f"nothing changed from {shown(found.before)} to {shown(found.after)}{small}")
        return
    if found.parameters:
        options.print_table("Parameters", ("parameter", "before", "after"), [
            (each.key, each.before if each.before is not None else "none",
             each.after if each.after is not None else "none") for each in found.parameters])  # fmt: skip
    if found.claims:
        turned = [each for each in found.claims if each.turned]
        others = f"{len(found.claims) - len(turned)} more with other numbers"
        options.print_table(f"Claims: {len(turned)} with another verdict, {others}", ("claim", "before", "after"), [
            (each.id, each.before or "not judged", each.after or "not judged") for each in turned])  # fmt: skip
    if found.numbers:
        _print_numbers(found)
    if found.figures:
        options.print_table(f"Figures: {len(found.figures)} changed", ("figure", "what"),
                            [(each.name, each.what) for each in found.figures])  # fmt: skip


def _print_numbers(found: Changes) -> None:
    """How many changed in each stage, and those single ones that changed most."""
    many = Counter(each.stage for each in found.numbers)
    counted = ", ".join(f"{stage} {count}" for stage, count in many.items())
    listed = [each for each in found.numbers if each.relative is not None and isinstance(each.before, float)
              and max(abs(each.before), abs(each.after)) > _ROUND_OFF]  # fmt: skip
    what = "single ones that changed most:" if listed else "all of them in arrays, words or round-off"
    title = f"Numbers: {len(found.numbers)} changed ({counted}), {found.small} by less; {what}"
    click.echo("\n" + "\n".join(layout.folded(title, 0)))
    for each in listed[:_PRINTED]:
        click.echo(f"  {each.stage} {each.path.replace('/', '.')}")
        values = f"{layout.short(each.before)} -> {layout.short(each.after)} {each.unit}".rstrip()
        click.echo(f"    {values} ({share(each.relative)})")


def share(relative: float | None) -> str:
    """A relative change in per cent; nothing for what is no number."""
    if relative is None:
        return ""
    if abs(relative) == float("inf"):
        return "from zero"
    return f"{100 * relative:+.3g} %"


def html(found: Changes) -> bytes:
    """The page, with pictures side by side; self-contained like the report."""
    from pipeline.report.page import template

    pictures = [(each.name, each.what, _data(each.before), _data(each.after)) for each in found.figures]
    return template(_TEMPLATE).render(
        found=found, before=shown(found.before), after=shown(found.after), most=_MOST, share=share, short=layout.short,
        pictures=pictures,
    ).encode()  # fmt: skip


def _data(path: Path) -> str:
    """A picture as an address of data; nothing for a page's fragment or what is not there."""
    from pipeline.cache import disk

    content = disk.read(path) if path.suffix == ".png" else None
    return "" if content is None else "data:image/png;base64," + base64.b64encode(content).decode()
