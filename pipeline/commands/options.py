"""Options that several commands share."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from pipeline import completion, layout
from pipeline.errors import StudyError
from pipeline.graph import FILE_NAME
from pipeline.home import face
from pipeline.study import Study, locate

Command = Callable[..., Any]
_FOLDER = click.Path(file_okay=False).shell_complete


def examples(command: str, lines: Sequence[str] = ()) -> str:
    """The end of a command's help: command lines, each as it is typed; without any those of the face's examples."""
    lines = lines or [line for line in _examples() if line.split()[1] == command]
    return "\b\n" + "\n".join(["Examples:" if len(lines) > 1 else "Example:", *(f"  {line}" for line in lines)])


@functools.cache
def _examples() -> tuple[str, ...]:
    return tuple((face() / "examples.txt").read_text(encoding="utf-8").splitlines())


def study(function: Command, *, with_results: bool = False) -> Command:
    """`--params`, `--results` and `--set`; the command gets a `Study` as its first argument.

    Outside of any study that is the one the program comes with, and the command says so; one `with_results` refuses.
    """

    @click.option("--params", metavar="DIR", shell_complete=_FOLDER,
                  help="Folder of the parameter files (default: the study's params).")
    @click.option("--results", metavar="DIR", shell_complete=_FOLDER,
                  help="Folder of the results (default: the study's results).")
    @click.option("--set", "settings", metavar="FILE.KEY=VALUE", multiple=True, shell_complete=completion.settings,
                  help="Change a parameter; repeatable.")
    @functools.wraps(function)
    def with_study(params: str | None, results: str | None, settings: tuple[str, ...], **options: Any) -> Any:
        found: Study = locate(params, results, settings)
        if found.borrowed and with_results:
            raise StudyError(f"there is no {FILE_NAME} in {Path.cwd()} or above it: run this inside a study, lay "
                             "one out with bipedstudy init DIR, or say with --results where results go")  # fmt: skip
        if found.borrowed:
            click.echo("note: not inside a study; this is about the one that bipedstudy comes with", err=True)
        return function(found, **options)

    return with_study


own_study = functools.partial(study, with_results=True)


def requests(function: Command) -> Command:
    """An option for each request of the study at hand, and `--verify`; the command gets a `Study` that knows them."""
    try:
        offered = locate().requests
    except StudyError:  # said by the command itself, which locates the study again
        return function

    @functools.wraps(function)
    def with_requests(found: Study, verify: bool = False, **options: Any) -> Any:
        texts = {request.NAME: options.pop(request.NAME) for request in offered}
        asked = dataclasses.replace(found, asked=tuple((name, text) for name, text in texts.items() if text))
        if not verify:
            return function(asked, **options)
        from pipeline.requests import to_verify
        from pipeline.requests import verify as verify_all

        chosen = to_verify(asked, options.get("stages") or tuple(asked.graph.stages))
        done = function(asked, **options)
        if not options.get("dry_run"):
            verify_all(asked, chosen, told=not options.get("as_json"))
        return done

    command: Command = with_requests
    for request in offered:
        if hasattr(request, "VERIFY_HELP"):
            command = click.option("--verify", is_flag=True, help=request.VERIFY_HELP)(command)
        command = click.option(f"--{request.NAME}", default="", metavar=request.METAVAR, help=request.HELP)(command)
    return command


def running(function: Command) -> Command:
    """`--jobs`, `--force`, `--dry-run`, `--wait`, `-v`: how stages are run."""
    for option in (
        click.option(
            "--jobs", "-j", metavar="N", type=click.IntRange(min=1), help="Stages side by side (default: cores)."
        ),
        click.option("--force", is_flag=True, help="Compute anew even what is current."),
        click.option("--dry-run", is_flag=True, help="Say what would run and why; run nothing."),
        click.option("--wait", is_flag=True, help="Wait for another run in the same results folder."),
        click.option("-v", "--verbose", is_flag=True, help="Say why each stage runs."),
    ):
        function = option(function)
    return function


as_json = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
"""`--json`: the answer as JSON on standard output, and nothing else there."""


as_csv = click.option("--csv", "as_csv", is_flag=True, help="Print CSV, a line a row.")
"""`--csv`: the answer's table on standard output, and nothing else there."""


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Print a table under its title, within the terminal's width."""
    click.echo("\n" + "\n".join([*layout.folded(title, 0), *layout.table(columns, rows)]))


def print_csv(rows: Sequence[Mapping[str, Any]]) -> None:
    """Print rows as CSV with all digits; what is nested in a row has columns of its own, their names joined by dots."""
    import csv
    import io

    lines = [dict(_flat(row)) for row in rows]
    text = io.StringIO()
    writer = csv.DictWriter(text, list(dict.fromkeys(name for line in lines for name in line)), lineterminator="\n")
    writer.writeheader()
    writer.writerows(lines)
    click.echo(text.getvalue(), nl=False)


def one_form(**asked: Any) -> None:
    """Raise `click.UsageError` if more than one of these options is given."""
    given = [f"--{name}" for name, value in asked.items() if value]
    if len(given) > 1:
        raise click.UsageError(f"{' and '.join(given)} exclude each other")


def _flat(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping) and set(value) == {"value", "unit"}:
        yield f"{name} [{value['unit']}]", value["value"]
    elif isinstance(value, (Mapping, list, tuple)):
        parts = value.items() if isinstance(value, Mapping) else enumerate(value, 1)
        for key, part in parts:
            yield from _flat(part, f"{name}.{key}" if name else str(key))
    else:
        yield name, str(value).lower() if isinstance(value, bool) else value


def print_json(value: Any) -> None:
    """Print a value as JSON; a number that JSON does not know (NaN, infinity) as null."""
    import json

    click.echo(json.dumps(_finite(value), indent=2, ensure_ascii=False, allow_nan=False))


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
