"""`bipedstudy compare OTHER`: what changed since another results folder."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline import layout
from pipeline.cache import disk
from pipeline.commands import options
from pipeline.errors import ANSWER
from pipeline.graph import FIGURES
from pipeline.report.page import address, template
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
@options.answers
def compare(study: Study, other: Path, tolerance: float, page: Path | None, form: options.Form) -> None:
    """Say what changed from the results in OTHER to those of the study: parameters, verdicts, numbers, figures.

    OTHER is a results folder or a study. Ends with 0 if nothing changed and with 3 if something did, or could not be
    compared. --csv prints the numbers.
    """
    from pipeline.changes.folders import between

    found = between(study, other, tolerance)
    if page is not None:
        disk.write(page, html(found))
    form.give(_lines(found), found.plain(), found.numbers)
    if page is not None:
        click.echo(f"written: {shown(page)}", err=True)
    if found.any:
        sys.exit(ANSWER)


def _lines(found: Changes) -> Iterator[str]:
    for sentence in found.unread:
        yield from layout.folded(sentence)
    if not found.any:
        small = f" ({found.small} numbers changed by less)" if found.small else ""
        yield f"nothing changed from {shown(found.before)} to {shown(found.after)}{small}"
    if found.parameters:
        yield from layout.titled("Parameters", ("parameter", "before", "after"), [
            (row["key"], *("none" if value is None else value for value in (row["before"], row["after"])))
            for row in found.parameters])  # fmt: skip
    if found.claims:
        turned = [(row["id"], row["before"] or "not judged", row["after"] or "not judged") for row in found.turned]
        others = len(found.claims) - len(turned)
        title = f"Claims: {len(turned)} with another verdict, {others} more with other numbers"
        yield from layout.titled(title, ("claim", "before", "after"), turned)
    if found.numbers:
        yield from _numbers(found)
    if found.figures:
        yield from layout.titled(f"Figures: {len(found.figures)} changed", ("figure", "what"),
                                 [(row["name"], row["what"]) for row in found.figures])  # fmt: skip


def _numbers(found: Changes) -> Iterator[str]:
    """How many changed in each stage, and those single ones that changed most."""
    many = Counter(row["stage"] for row in found.numbers)
    listed = [row for row in found.numbers if row["relative"] is not None and isinstance(row["before"], float)
              and max(abs(row["before"]), abs(row["after"])) > _ROUND_OFF]  # fmt: skip
    what = "single ones that changed most:" if listed else "all of them in arrays, words or round-off"
    counted = ", ".join(f"{stage} {count}" for stage, count in many.items())
    title = f"Numbers: {len(found.numbers)} changed ({counted}), {found.small} by less; {what}"
    yield from ("", *layout.folded(title, 0))
    for row in listed[:_PRINTED]:
        yield f"  {row['stage']} {row['path']}"
        values = f"{layout.short(row['before'])} -> {layout.short(row['after'])} {row['unit']}".rstrip()
        yield f"    {values} ({share(row['relative'])})"


def share(relative: float | None) -> str:
    """A relative change in per cent; nothing for what is no number."""
    if relative is None:
        return ""
    return "from zero" if abs(relative) == float("inf") else f"{100 * relative:+.3g} %"


def html(found: Changes) -> bytes:
    """The page, with pictures side by side; self-contained like the report."""
    folders = [folder / FIGURES.removeprefix("results/") for folder in (found.before, found.after)]
    pictures = [(row["name"], row["what"], *(address(disk.read(folder / f"{row['name']}.png")) for folder in folders))
                for row in found.figures]  # fmt: skip
    return template(_TEMPLATE).render(
        found=found, before=shown(found.before), after=shown(found.after), most=_MOST, share=share, short=layout.short,
        pictures=pictures,
    ).encode()  # fmt: skip
