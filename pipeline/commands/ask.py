"""Turns what stages can be asked into commands: each file of a stage's folder `questions` is one, its `QUESTION`.

A question declares name, help, options and the function that answers; it is known here by these attributes only.
"""

from __future__ import annotations

import sys
import types
import typing
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import MISSING, Field
from functools import cache
from inspect import cleandoc
from pathlib import Path
from typing import Any

import click

from pipeline.commands import options
from pipeline.commands.options import Command
from pipeline.errors import ANSWER, Stopped, StudyError, is_answer
from pipeline.parameters import yaml_text
from pipeline.parameters.value import Refused, allowed, checked, declared
from pipeline.parameters.yaml_text import Node
from pipeline.stage_modules import importable, stage_module
from pipeline.study import Study, shown

Question = Any
_FILE = click.Path(dir_okay=False, path_type=Path)
_METAVARS = {int: "INTEGER", float: "NUMBER", str: "WORD"}


@cache
def offered(study: Study, taken: frozenset[str]) -> tuple[dict[str, tuple[str, Question]], list[str]]:
    """Name -> stage and question; and a sentence for each file of questions that cannot be used.

    `taken` are names of other commands.
    """
    found: dict[str, tuple[str, Question]] = {}
    broken = []
    importable(study.code_root)
    for stage in study.graph.stages:
        for path in sorted((study.code_root / study.package / stage / "questions").glob("[!_]*.py")):
            try:
                question = stage_module(study.package, stage, f"questions.{path.stem}").QUESTION
                declared(question.options)
                if question.name in {*taken, *found}:
                    raise ValueError(f'there is a command "{question.name}" already')
                found[question.name] = stage, question
            except Exception as error:  # whatever a file of somebody's own does, the other commands go on
                broken.append(f"stage {stage}: {path.relative_to(study.code_root)} cannot be used: {error}")
    return found, broken


def command(stage: str, question: Question) -> click.Command:
    """The command that asks this question of its stage."""

    def asked(study: Study, as_json: bool, figure: Path | None = None, jobs: int | None = None,
              into: Path | None = None, **given: Any) -> None:  # fmt: skip
        if figure is not None:
            _check_ending(figure)
        _answer(study, stage, question, given, as_json, figure, jobs, into)

    function: Command = asked
    for decorate in reversed(list(_parameters(question))):
        function = decorate(function)
    return click.command(question.name, help=cleandoc(question.help))(function)


def _parameters(question: Question) -> Iterator[Callable[[Command], Command]]:
    """Decorators that declare the command's options, in the order in which its help lists them."""
    for name, (field, kind) in declared(question.options).items():
        yield _parameter(name, field, _some(kind))
    if question.pool:
        yield click.option("--jobs", "-j", metavar="N", type=click.IntRange(min=1),
                           help="How much is computed side by side (default: cores).")  # fmt: skip
    yield options.study
    yield options.as_json
    if question.draws:
        yield click.option("--figure", type=_FILE, help="Draw into FILE (its ending names the format).")
    if question.leaves:
        yield click.option("--into", metavar="DIR", type=click.Path(path_type=Path),
                           help=f"Leave {question.leaves} in the new folder DIR.")  # fmt: skip


def _parameter(name: str, field: Field[Any], kind: Any) -> Callable[[Command], Command]:
    about = field.metadata
    required = field.default is MISSING
    if about["positional"]:
        return click.argument(name, required=required)
    unit = "" if about["unit"] in ("1", "-") else f" [{about['unit']}]"
    said = f"{about['description']}{unit}."
    if kind is bool:
        return click.option(_flag(name, about), name, is_flag=True, help=said)
    limits = allowed(field) if kind in (int, float) or about["choices"] else ""
    default = None if required or field.default in (None, ()) else _text(field.default)
    return click.option(
        _flag(name, about),
        name,
        required=required,
        multiple=_is_repeated(kind, about),
        default=default,
        show_default=default is not None,
        metavar=about["metavar"] or _METAVARS.get(kind, "WORD" if _is_repeated(kind, about) else "FILE"),
        help=f"{said} Allowed: {limits}." if limits else said,
    )


def _flag(name: str, about: Mapping[str, Any]) -> str:
    """How the option is given, and called in messages."""
    return name.upper() if about["positional"] else "--" + (about["name"] or name.replace("_", "-"))


def _text(default: Any) -> str:
    """A default as it would be typed."""
    if isinstance(default, tuple):
        return ":".join(f"{value:g}" for value in default)
    return f"{default:g}" if isinstance(default, float) else str(default)


def _some(kind: Any) -> Any:
    """The type of a value that may be None, if it is not."""
    if typing.get_origin(kind) in (typing.Union, types.UnionType):
        return next(each for each in typing.get_args(kind) if each is not type(None))
    return kind


def _is_repeated(kind: Any, about: Mapping[str, Any]) -> bool:
    return typing.get_origin(kind) is tuple and not about["read"]


def _value(text: Any, flag: str, field: Field[Any], kind: Any) -> Any:
    """The checked value of what was typed. Raises `StudyError`, or what the option's own reader raises."""
    if text is None or kind is bool:
        return text
    if field.metadata["read"]:
        return field.metadata["read"](text, flag)
    if kind is Path:
        return Path(text)
    if typing.get_origin(kind) not in (None, tuple):
        described = yaml_text.read(Path(text), shown(Path(text))).plain()
        if not isinstance(described, dict):
            raise StudyError(f"{shown(Path(text))}: expected lines of the form key: value")
        return described
    try:
        return checked(_node(text, kind), field, kind)
    except Refused as refused:
        gap = "" if refused.reason.startswith("[") else " "
        raise StudyError(f"{flag}{gap}{refused.reason}") from None


def _node(text: Any, kind: Any) -> Node:
    if isinstance(text, tuple):
        return Node([_node(each, typing.get_args(kind)[0]) for each in text], 0)
    return Node(text if kind is str else yaml_text.scalar(text), 0)


def _answer(
    study: Study, stage: str, question: Question, given: dict[str, Any], as_json: bool, figure: Path | None,
    jobs: int | None, into: Path | None,
) -> None:  # fmt: skip
    """Ask, and print, draw and keep the answer; ends the process with 3 if the answer is no."""
    from pipeline.commands.asking import Asked
    from pipeline.commands.show import print_table

    with ExitStack() as until_answered:
        try:
            values = {
                name: _value(given[name], _flag(name, field.metadata), field, _some(kind))
                for name, (field, kind) in declared(question.options).items()
            }
            parameters = study.parameters([stage])
            for sentence in study.warnings(parameters):
                click.echo(f"warning: {sentence}", err=True)
            asking = until_answered.enter_context(Asked(study, stage, question, parameters[stage], jobs))
            folder = until_answered.enter_context(asking.new_file(into)) if into is not None else None
            asking.say_if_cold()
            try:
                answer = question.ask(parameters[stage], question.options(**values), asking)
            except KeyboardInterrupt:
                raise Stopped(asking.kept()) from None
        except question.wrong as wrong:
            raise StudyError(str(wrong)) from None
        except Exception as reason:
            if not is_answer(reason, study.package):
                raise
            if as_json:
                options.print_json({question.key or question.name: None, "reason": str(reason)})
            else:
                click.echo(str(reason), err=True)
            sys.exit(ANSWER)
        asking.close()
        if as_json:
            options.print_json(answer.plain)
        else:
            for line in answer.lines:
                click.echo(line)
            for title, columns, rows in answer.tables:
                print_table(title, columns, rows)
        if figure is not None:
            answer.draw(lambda drawn: drawn.savefig(figure, dpi=150))
            click.echo(f"drawn: {shown(figure)}", err=True)
        if folder is not None:
            asking.leave(answer, folder)
        if answer.remark:
            click.echo(answer.remark, err=True)
    if answer.no:
        sys.exit(ANSWER)


def _check_ending(path: Path) -> None:
    """Raise `StudyError` for an ending that is no picture format, before anything is computed."""
    from matplotlib.backend_bases import FigureCanvasBase

    known = sorted(FigureCanvasBase.get_supported_filetypes())
    if path.suffix.lstrip(".").lower() not in known:
        raise StudyError(f"{shown(path)}: the ending names the format, one of {', '.join(known)}")
