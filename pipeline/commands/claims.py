"""`bipedstudy claims`: what the paper claims and whether it holds here."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from pipeline.commands import options
from pipeline.errors import StudyError
from pipeline.parameters import yaml_text
from pipeline.study import Study, shown

VERDICT = {True: "holds", False: "does not hold", None: "open"}
_MARKS = ("<!-- claims -->", "<!-- /claims -->")
_KEYS = {"id", "stated", "found", "holds", "why"}


@click.command("claims")
@options.own_study
@options.as_json
@click.option("--markdown", is_flag=True, help="Print the README's table.")
@click.option(
    "--into", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Write that table into FILE."
)
def command(study: Study, as_json: bool, markdown: bool, into: Path | None) -> None:
    """Print each claim of the paper: what it states, what was found, whether it holds, and why."""
    claims = read(study)
    if as_json:
        options.print_json(claims)
    elif into is not None:
        place(into, as_markdown(claims))
    elif markdown:
        click.echo(as_markdown(claims))
    else:
        for claim in claims:
            click.echo(f"{claim['id']}: {VERDICT[claim['holds']]}")
            for key in ("stated", "found", "why"):
                click.echo(f"  {key:<7} {claim[key]}")


def place(path: Path, table: str) -> None:
    """Put the table between the marks of a text file. Raises `StudyError` if the marks are missing."""
    text = path.read_text(encoding="utf-8")
    before, start, rest = text.partition(_MARKS[0])
    _, end, after = rest.partition(_MARKS[1])
    if not (start and end):
        raise StudyError(f"{shown(path)}: the table goes between the lines {_MARKS[0]} and {_MARKS[1]}; one is missing")
    path.write_text(f"{before}{start}\n{table}\n{end}{after}", encoding="utf-8")


def read(study: Study) -> list[dict[str, Any]]:
    """The list in results/claims.yaml. Raises `StudyError` if it is missing or was damaged."""
    path = study.store.place("results/claims.yaml")
    if not path.exists():
        raise StudyError(f"{shown(path)} is not there yet; make it with: bipedstudy run comparison")
    claims = yaml_text.read(path, shown(path)).plain()
    if not isinstance(claims, list) or not all(isinstance(claim, dict) and set(claim) >= _KEYS for claim in claims):
        raise StudyError(f"{shown(path)}: not a list of claims with {', '.join(sorted(_KEYS))}")
    for claim in claims:
        if claim["holds"] not in (True, False, None):
            raise StudyError(f"{shown(path)}: claim {claim['id']}: holds must be true, false or null")
    return claims


def as_markdown(claims: list[dict[str, Any]]) -> str:
    """The verdict table of the README."""
    lines = ["| Claim | Stated in the paper | Found here | Verdict | Why |", "| --- | --- | --- | --- | --- |"]
    for claim in claims:
        cells = [claim["id"], claim["stated"], claim["found"], VERDICT[claim["holds"]], claim["why"]]
        lines.append("| " + " | ".join(" ".join(str(cell).split()).replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)
