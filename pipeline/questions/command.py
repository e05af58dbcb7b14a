"""Turns what stages can be asked into commands: each file of a stage's folder `questions` is one, its `QUESTION`.

A question declares name, help, options and the function that answers; it is known here by these attributes only.
"""

import io
import sys
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import MISSING, Field
from functools import cache, partial
from inspect import cleandoc
from pathlib import Path
from typing import Any, get_origin

import click

from pipeline import completion, layout
from pipeline.cache import disk
from pipeline.commands import options
from pipeline.commands.options import Command
from pipeline.errors import ANSWER, StudyError, is_answer
from pipeline.home import importable, stage_module
from pipeline.parameters import yaml_text
from pipeline.parameters.value import Refused, allowed, checked, declared, present
from pipeline.parameters.yaml_text import Node
from pipeline.study import Study, shown
from pipeline.sweep import cluster as clusters

Question = Any
_PATH, _FILE = click.Path(path_type=Path), click.Path(dir_okay=False, path_type=Path)
_REPEATED = tuple[str, ...]
_METAVARS = {int: "INTEGER", float: "NUMBER", str: "WORD", _REPEATED: "WORD"}


@cache
def offered(study: Study, taken: frozenset[str]) -> tuple[dict[str, tuple[str, click.Command]], list[str]]:
    """Name -> stage and command of each question, and a sentence for each file of questions that cannot be used.

    `taken` are names of other commands.
    """
    found: dict[str, tuple[str, click.Command]] = {}
    declared_here, broken = questions(study)
    for stage, path, question in declared_here:
        try:
            asking = _command(stage, question)
            if question.name in {*taken, *found}:
                raise ValueError(f'there is a command "{question.name}" already')
            found[question.name] = stage, asking
        except Exception as error:  # whatever a file of somebody's own does, the other commands go on
            broken.append(_unusable(study, stage, path, error))
    return found, broken


def questions(study: Study) -> tuple[list[tuple[str, Path, Question]], list[str]]:
    """Stage, file and declaration of each question, and a sentence for each file that cannot be used."""
    found, broken = [], []
    importable(study.package, study.code_root)
    for stage in study.graph.stages:
        for path in sorted((study.code_root / study.package / stage / "questions").glob("[!_]*.py")):
            try:
                found.append((stage, path, stage_module(study.package, stage, f"questions.{path.stem}").QUESTION))
            except Exception as error:
                broken.append(_unusable(study, stage, path, error))
    return found, broken


def _unusable(study: Study, stage: str, path: Path, error: Exception) -> str:
    """Why a file of questions is passed over."""
    return f"stage {stage}: {path.relative_to(study.code_root)} cannot be used: {error}"


def _command(stage: str, question: Question) -> click.Command:
    """The command that asks this question of its stage; it ends the process with 3 if the answer is no."""
    given = [Option(name, *pair) for name, pair in declared(question.options).items()]

    def asked(study: Study, form: options.Form, figure: Path | None = None, jobs: int | None = None,
              connect: clusters.Connect = clusters.here, into: Path | None = None, **texts: Any
              ) -> None:  # fmt: skip
        from pipeline.questions.asking import Asked, vacant

        if figure is not None:
            _check_ending(disk.replaceable(figure))
        if into is not None:
            vacant(into)
        with ExitStack() as until_answered:
            try:
                values = {option.name: option.value(texts[option.name]) for option in given}
                parameters = study.parameters([stage])
                options.warn(study, parameters)
                client, workers = until_answered.enter_context(connect(_note))
                asking = until_answered.enter_context(
                    Asked(study, stage, question, parameters[stage], workers or jobs, client))
                asking.say_if_cold()
                answer = question.ask(parameters[stage], question.options(**values), asking)
            except question.wrong as wrong:
                raise StudyError(str(wrong)) from None
            except Exception as reason:
                if not is_answer(reason, study.package):
                    raise
                _give_no_answer(question, form, str(reason))
                sys.exit(ANSWER)
            asking.close()
            form.give((part for line in answer.lines for part in layout.folded(line)), answer.plain, answer.rows,
                      answer.tables)  # fmt: skip
            if figure is not None:
                _draw(answer, figure)
            if into is not None:
                asking.leave(answer, into)
        if answer.remark:
            _note(answer.remark)
        if answer.no:
            sys.exit(ANSWER)

    function: Command = asked
    if question.leaves:
        function = click.option("--into", metavar="DIR", type=_PATH,
                                help=f"Leave {question.leaves} in the new folder DIR.")(function)  # fmt: skip
    if question.draws:
        function = click.option("--figure", type=_FILE,
                                help="Draw into FILE (its ending names the format).")(function)  # fmt: skip
    function = options.study(options.answers(function, rows=question.rows))
    if question.pool:
        function = clusters.offered(function)
    for option in reversed(given):
        function = option.declared()(function)
    ending = options.examples(question.name, question.examples) if question.examples else None
    return click.command(question.name, help=cleandoc(question.help), epilog=ending)(function)


_note = partial(click.echo, err=True)


def _give_no_answer(question: Question, form: options.Form, reason: str) -> None:
    """Say why there is no answer."""
    if form.as_json:
        form.give((), {question.key or question.name: None, "reason": reason})
    else:
        _note(reason)


def _draw(answer: Any, figure: Path) -> None:
    """Draw the answer's picture, if it has one."""
    if answer.draw is None:
        _note("note: this answer has no picture; nothing was drawn")
        return
    content = io.BytesIO()
    answer.draw(lambda drawn: drawn.savefig(content, dpi=150, format=figure.suffix[1:]))
    disk.write(figure, content.getvalue())
    _note(f"drawn: {shown(figure)}")


class Described(dict[str, Any]):
    """The plain content of a YAML file whose outermost lines are `key: value`."""

    def __init__(self, node: Node, where: str) -> None:
        super().__init__(node.plain())
        self._node, self._where = node, where

    def place(self, *keys: Any) -> str:
        """Where the entry under these keys, one inside the other, stands: file, line and key, for messages.

        The line is that of the innermost one that is there.
        """
        node = self._node
        for key in keys:
            inside = node.value
            if (isinstance(inside, dict) and key in inside) or (isinstance(inside, list) and key in range(len(inside))):
                node = inside[key]
        named = ".".join(str(key) for key in keys)
        return f"{self._where}:{node.line}" + (f": {named}" if named else "")


class Option:
    """A field of a question's options: how it is given, and its checked value."""

    def __init__(self, name: str, field: Field[Any], kind: Any) -> None:
        self.name, self.field, self.kind = name, field, present(kind)
        about = field.metadata
        self.flag = name.upper() if about["positional"] else "--" + (about["name"] or name.replace("_", "-"))

    @property
    def repeated(self) -> bool:
        """Whether it takes several words."""
        return bool(self.kind == _REPEATED)

    def declared(self) -> Callable[[Command], Command]:
        """The decorator that gives a command this option."""
        about, default, kind = self.field.metadata, self.field.default, self.kind
        if about["positional"]:
            named = kind is Path or get_origin(kind) is Mapping or about["metavar"] == "FILE"
            complete = completion.files if named else completion.for_option(about)
            return click.argument(self.name, required=default is MISSING, shell_complete=complete,
                                  nargs=-1 if self.repeated else 1)  # fmt: skip
        said = about["description"] + ("" if about["unit"] in ("1", "-") else f" [{about['unit']}]") + "."
        if kind is bool:
            return click.option(self.flag, self.name, is_flag=True, help=said)
        if kind in (int, float) or about["choices"]:
            said += f" Allowed: {allowed(self.field, kind)}."
        given = default not in (MISSING, None, ())
        fallback: dict[str, Any] = {"default": _text(default)} if given else {}  # None would be a default to click
        return click.option(
            self.flag,
            self.name,
            **fallback,
            type=_PATH if kind is Path else str,
            shell_complete=completion.files if get_origin(kind) is Mapping else completion.for_option(about),
            required=default is MISSING,
            multiple=self.repeated,
            show_default=given,
            metavar=about["metavar"] or _METAVARS.get(kind, "FILE"),
            help=said,
        )

    def value(self, text: Any) -> Any:
        """The value of what was typed. Raises `StudyError`, or what the option's own reader raises."""
        if text is None or self.kind in (bool, Path):
            return text
        if self.field.metadata["read"]:
            return self.field.metadata["read"](text, self.flag)
        if get_origin(self.kind) is Mapping:
            node = yaml_text.read(Path(text), shown(Path(text)))
            if not isinstance(node.value, dict):
                raise StudyError(f"{shown(Path(text))}: expected lines of the form key: value")
            return Described(node, shown(Path(text)))
        plain = yaml_text.scalar(text) if self.kind in (int, float) else list(text) if self.repeated else text
        return self._checked(plain)

    def taken(self, given: Any) -> Any:
        """The value of what Python gives: a text as it is typed, a number, a mapping, or words. Raises as `value`."""
        given = _plainly(given)
        if get_origin(self.kind) is Mapping and isinstance(given, Mapping):
            return Described(Node.of(dict(given)), self.name)
        if self.kind is Path and given is not None:
            return Path(given)
        if self.field.metadata["read"] and isinstance(given, tuple | list):
            return self.value(":".join(map(str, given)))
        if self.repeated:
            words = given if isinstance(given, list | tuple | set) else [given]
            return self._checked([str(each) for each in words])
        if not (given is None or isinstance(given, str | int | float)):
            raise StudyError(f"{self.flag}: {given!r} is nothing that it takes")
        return self._checked(given) if isinstance(given, int | float) and self.kind is not bool else self.value(given)

    def _checked(self, plain: Any) -> Any:
        """A plain value, inside its bounds."""
        try:
            return checked(Node.of(plain), self.field, self.kind)
        except Refused as refused:
            raise StudyError(f"{self.flag} {refused.reason}") from None


def _plainly(given: Any) -> Any:
    """What Python gives, of a path its text and of NumPy's numbers and arrays the values."""
    if isinstance(given, Path):
        return str(given)
    return given.tolist() if hasattr(given, "tolist") else given


def _text(default: Any) -> str:
    """A default as it would be typed."""
    if isinstance(default, tuple):
        return ":".join(f"{value:g}" for value in default)
    return f"{default:g}" if isinstance(default, float) else str(default)


def _check_ending(path: Path) -> None:
    """Raise `StudyError` for an ending that is no picture format, before anything is computed."""
    from matplotlib.backend_bases import FigureCanvasBase

    known = sorted({*FigureCanvasBase.get_supported_filetypes()} - {"pgf"})  # which LaTeX draws
    if path.suffix.lstrip(".").lower() not in known:
        raise StudyError(f"{shown(path)}: the ending names the format, one of {', '.join(known)}")
