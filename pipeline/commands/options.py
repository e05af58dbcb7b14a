"""Options that several commands share, and those that ask something of several stages, as one stage declares them.

`--accuracy` is of the latter, where a study has it. A stage's module `request` declares one: NAME of the option and of
the key it stands for, METAVAR, HELP, FORM and `words()` for messages, FILES that have the key, FREE, its value with
which nothing is asked, `parsed(text)`, and `level(value)`, the study's level that goes with it. With VERIFY_HELP,
`verified(asked, result)` and `line(found)` show what a run reached.
"""

import contextlib
import csv
import functools
import io
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import click
import yaml

from pipeline import completion, layout
from pipeline.cache import disk
from pipeline.cache.store import MANIFEST
from pipeline.errors import StudyError
from pipeline.graph import FILE_NAME
from pipeline.home import face, result_class
from pipeline.study import Study, locate, shown

Command = Callable[..., Any]
#: Title, names of the columns, and rows.
Table = tuple[str, Sequence[str], Sequence[Sequence[Any]]]
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
_FOLDER = click.Path(file_okay=False).shell_complete


def examples(command: str, lines: Sequence[str] = ()) -> str:
    """The end of a command's help: command lines, each as it is typed; without any those of the face's examples."""
    given = (face() / "examples.txt").read_text(encoding="utf-8").splitlines()
    lines = lines or [line for line in given if line.split()[1] == command]
    return "\b\n" + "\n".join(["Examples:" if len(lines) > 1 else "Example:", *(f"  {line}" for line in lines)])


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
        study = replace(found, requested=tuple((name, text) for name, text in texts.items() if text))
        if not verify:
            return function(study, **options)
        chosen = to_verify(study, options.get("stages") or tuple(study.graph.stages))
        done = function(study, **options)
        if not options.get("dry_run"):
            keep_verifications(study, chosen, show=not options.get("as_json"))
        return done

    command: Command = with_requests
    for request in offered:
        if hasattr(request, "VERIFY_HELP"):
            command = click.option("--verify", is_flag=True, help=request.VERIFY_HELP)(command)
        command = click.option(f"--{request.NAME}", default="", metavar=request.METAVAR, help=request.HELP)(command)
    return command


def cached(function: Command) -> Command:
    """`--cache`; the command gets a `Study` that takes stored results from there too."""

    @click.option("--cache", metavar="DIR", type=click.Path(exists=True, file_okay=False, path_type=Path),
                  help="Take results from the cache of this results folder too; it is only read.")
    @functools.wraps(function)
    def with_cache(found: Study, cache: Path | None, **options: Any) -> Any:
        if cache is not None:
            hidden = cache.absolute() / ".cache"
            place = hidden if hidden.is_dir() else cache.absolute()
            found = replace(found, cache=place)
            if not any(place.glob(f"*/{MANIFEST}")):
                click.echo(f"note: {shown(cache)} has no stored results: what is not in results is computed", err=True)
        return function(found, **options)

    return with_cache


def running(function: Command) -> Command:
    """`--cache`, `--jobs`, `--force`, `--dry-run`, `--wait`, `-v`: how stages are run."""
    function = cached(function)
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


def warn(study: Study, values: Mapping[str, Any]) -> None:
    """Say on standard error what stages have to say of parameters (stage -> parameters) before they compute."""
    for sentence in study.warnings(values):
        click.echo(f"warning: {sentence}", err=True)


@dataclass(frozen=True)
class Form:
    """In which form a command answers: as text, or with --json or --csv with that alone on standard output."""

    as_json: bool = False
    as_csv: bool = False

    @property
    def is_text(self) -> bool:
        """Whether people read it."""
        return not (self.as_json or self.as_csv)

    def give(self, lines: Iterable[Any], plain: Any, rows: Iterable[Mapping[str, Any]] = (),
             tables: Iterable[Table] = ()) -> None:  # fmt: skip
        """Print the answer: lines as they are and tables under their titles, or `plain`, or `rows` with all digits.

        A number that JSON does not know (NaN, infinity) is null there. What is nested in a row has columns of its own,
        their names joined by dots.
        """
        if self.as_json:
            click.echo(json.dumps(finite(plain), indent=2, ensure_ascii=False, allow_nan=False))
        elif self.as_csv:
            flat, text = [dict(_flat(row)) for row in rows], io.StringIO()
            columns = dict.fromkeys(name for row in flat for name in row)
            if not flat:
                click.echo("note: this answer has no rows", err=True)
                return
            writer = csv.writer(text, lineterminator="\n")
            writer.writerows([_cell(cell) for cell in row]
                             for row in (columns, *([row.get(name, "") for name in columns] for row in flat)))
            click.echo(text.getvalue(), nl=False)
        else:
            for line in (*lines, *(line for table in tables for line in layout.titled(*table))):
                click.echo(line)


def answers(function: Command, *, rows: bool = True, others: Sequence[str] = ()) -> Command:
    """`--json` and, where the answer has `rows`, `--csv`; the command gets a `Form`.

    Only one of them may be given, nor one of `others` beside it.
    """

    @functools.wraps(function)
    def with_form(*given: Any, as_json: bool, as_csv: bool = False, **options: Any) -> Any:
        forms = {"json": as_json, "csv": as_csv, **{name: options[name] for name in others}}
        requested = [f"--{name}" for name, value in forms.items() if value]
        if len(requested) > 1:
            raise click.UsageError(f"{' and '.join(requested)} exclude each other")
        return function(*given, form=Form(as_json, as_csv), **options)

    if rows:
        with_form = click.option("--csv", "as_csv", is_flag=True, help="Print CSV, a line a row.")(with_form)
    return click.option("--json", "as_json", is_flag=True, help="Print JSON.")(with_form)


answers_without_rows = functools.partial(answers, rows=False)


def _flat(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping) and set(value) == {"value", "unit"}:
        yield f"{name} [{value['unit']}]", value["value"]
    elif isinstance(value, (Mapping, list, tuple)):
        parts = value.items() if isinstance(value, Mapping) else enumerate(value, 1)
        for key, part in parts:
            yield from _flat(part, f"{name}.{key}" if name else str(key))
    else:
        yield name, str(value).lower() if isinstance(value, bool) else value


def _cell(value: Any) -> Any:
    """What stands in a cell: a text that a spreadsheet would take for a formula, and may run, begins with '."""
    if isinstance(value, str) and value.startswith(_FORMULA) and len(value) > 1:
        with contextlib.suppress(ValueError):
            float(value)
            return value
        return f"'{value}"
    return value


def finite(value: Any) -> Any:
    """What JSON knows of a value: null for a number that is not finite, lists for tuples."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


_SEAL = "seal: "
Request = ModuleType
#: The request, a stage, and what is asked of it.
Asked = tuple[Request, str, Any]


def all_requested(study: Study, values: Mapping[str, Any]) -> Iterator[Asked]:
    """What requests ask of stages; `values` is stage -> parameters."""
    for stage, own in values.items():
        for request in study.requests:
            section = next((section for section in vars(own).values() if stage == section.FILE), None)
            requested = getattr(section, request.NAME, request.FREE)
            if stage in request.FILES and requested != request.FREE:
                yield request, stage, requested


def to_verify(study: Study, stages: Iterable[str]) -> list[Asked]:
    """What is asked of these stages. Raises `StudyError` if nothing is."""
    names = [study.graph.stage(name).name for name in stages]
    found = list(all_requested(study, study.parameters(names)))
    if not found:
        options = " or ".join(f"--{request.NAME}" for request in study.requests)
        raise StudyError(f"--verify estimates an error that was requested, and none is asked of {', '.join(names)}; "
                         f"give {options}, or its key in the stage's parameter file")  # fmt: skip
    return found


def keep_verifications(study: Study, chosen: list[Asked], *, show: bool) -> None:
    """Keep what each stage's result says of its request beside the artefact and, if `show`, print it.

    Holds the lock.
    """
    from pipeline.cache import artefact  # with h5py, which takes its time

    with disk.locked(study.results, shown(study.results), "bipedstudy --verify", True, click.echo):
        for request, stage, requested in chosen:
            path = study.graph.stages[stage].artefact
            content = disk.content(study.store.place(path), shown(study.store.place(path)))
            key = artefact.provenance(content, path)["key"]
            result = artefact.decode(content, result_class(study.package, stage), path)
            found = {"stage": stage, "artefact_key": key, **request.verified(requested, result)}
            place, text = record_of(study, request, stage), yaml.safe_dump(found, sort_keys=False)
            disk.inside(study.results, place, shown(place))
            disk.write(place, f"{text}{_SEAL}{disk.digest(text.encode())}\n".encode())
            if show:
                click.echo(f"{request.line(found)}; {shown(place)}")


def record_of(study: Study, request: Request, stage: str) -> Path:
    """Where the verification of a stage's artefact is kept: results/<request>/<stage>.yaml."""
    return study.results / str(request.NAME) / f"{stage}.yaml"


def verifications(study: Study, about: Mapping[str, str]) -> Iterator[str]:
    """Of each request that an artefact's provenance names: its verification, or else what was requested."""
    for request in study.requests:
        if request.NAME not in about:
            continue
        line = f"{request.NAME} {about[request.NAME]}"
        with contextlib.suppress(yaml.YAMLError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
            record = record_of(study, request, about.get("stage", ""))
            text, _, seal = (disk.read(record, disk.TEXT) or b"").decode().rpartition(_SEAL)
            found = yaml.safe_load(text)
            if seal.strip() == disk.digest(text.encode()) and found["artefact_key"] == about.get("key"):
                line = request.line(found)
        yield line
