"""Every question of the command line, asked from Python: `bs.ask("step_frequency", within="1%", hip_mass=0.4)`."""

from __future__ import annotations

import keyword
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, replace
from inspect import cleandoc
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bipedstudy.results import located, resolved
from pipeline import layout
from pipeline.commands.options import finite
from pipeline.errors import StudyError
from pipeline.parameters.value import declared
from pipeline.questions.asking import Asked
from pipeline.questions.command import Option, questions
from pipeline.study import Study, locate

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Reply:
    """An answer: `plain` is what --json prints, read by key as well; its text is what the command prints."""

    plain: Any
    lines: tuple[str, ...]
    rows: tuple[Mapping[str, Any], ...]
    draw: Callable[[Callable[[Any], None]], None] | None = None

    def __getitem__(self, key: Any) -> Any:
        return self.plain[key]

    def __repr__(self) -> str:
        return "\n".join(self.lines)

    def figure(self) -> Figure:
        """The picture that --figure draws. Raises `StudyError` if this answer has none."""
        if self.draw is None:
            raise StudyError("this answer has no picture")
        drawn: list[Figure] = []
        self.draw(drawn.append)
        return drawn[0]


def python_name(name: str) -> str:
    """A question's name as Python can have it: ground_sensitivity, continue_."""
    word = name.replace("-", "_")
    return f"{word}_" if keyword.iskeyword(word) else word


def names() -> list[str]:
    """The questions of the study around the working folder, by their names here."""
    return [python_name(question.name) for _, _, question in questions(locate())[0]]


def named(name: str) -> Callable[..., Reply]:
    """The question that is called `name` here. Raises KeyError."""
    found = {python_name(question.name): (stage, question) for stage, _, question in questions(locate())[0]}
    stage, question = found[name]

    def asked(*given: Any, study: str | Path | None = None, jobs: int | None = None, **keywords: Any) -> Reply:
        return _ask(located(study), stage, question, given, jobs, keywords)

    asked.__name__, asked.__doc__ = name, f"{cleandoc(question.help)}\n\n{_arguments(question)}"
    return asked


def _arguments(question: Any) -> str:
    """What a question takes in Python."""
    rows = [f"    {name}: {field.metadata['description']}" for name, (field, _) in declared(question.options).items()]
    return "\n".join([
        "Arguments, the first ones without a name:", *rows,
        "    study: a folder in a study (default: the working folder)", "    jobs: processes",
        'and parameters, as hip_mass=0.4, or settings={"biped.hip_mass": 0.4}.',
        "Raises StudyError for what is not allowed, and what the stage raises where the answer is no."])  # fmt: skip


def _by_place(question: Any, options: Mapping[str, Option], given: tuple[Any, ...]) -> dict[str, Any]:
    """What is given without a name, by the names of the options that stand first."""
    first = [name for name, option in options.items() if option.field.metadata["positional"]]
    if first and options[first[-1]].repeated and len(given) >= len(first):
        given = *given[:len(first) - 1], given[len(first) - 1:]
    if len(given) > len(first):
        raise StudyError(f"{question.name} takes {len(first)} arguments without a name; parameters are given by name, "
                         "as hip_mass=0.4")  # fmt: skip
    return dict(zip(first, given))


def _ask(
    study: Study, stage: str, question: Any, given: tuple[Any, ...], jobs: int | None, keywords: dict[str, Any]
) -> Reply:
    """Sort what is given into options and parameters, ask, and wrap the answer."""
    options = {name: Option(name, *pair) for name, pair in declared(question.options).items()}
    chosen = {name: keywords.pop(name) for name in options if name in keywords} | _by_place(question, options, given)
    for name, option in options.items():
        if name not in chosen and option.field.default is MISSING:
            raise StudyError(f"{question.name} needs {name}: {option.field.metadata['description']}")
    settings = resolved(study, stage, keywords.pop("settings", {}), keywords)
    here = replace(study, settings=settings)
    parameters = here.parameters((stage,))[stage]
    try:
        values = {name: options[name].taken(value) for name, value in chosen.items()}
        with Asked(here, stage, question, parameters, jobs) as asking:
            answer = question.ask(parameters, question.options(**values), asking)
    except question.wrong as wrong:
        raise StudyError(str(wrong)) from None
    lines = (*answer.lines, *(line for table in answer.tables for line in layout.titled(*table)))
    return Reply(finite(answer.plain), lines, tuple(answer.rows), answer.draw)
