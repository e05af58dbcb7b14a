"""What the shell completes: stages, parameters, figures, claims and files, from the study's text files alone.

Nothing here imports a stage, so that a press of the key answers at once. Where there is no study nothing is offered.
"""

import re
from collections.abc import Callable, Iterable
from functools import partial
from operator import attrgetter
from typing import Any

import click
from click.shell_completion import CompletionItem

from pipeline.errors import StudyError
from pipeline.study import Study, locate

Completer = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]
_KEY = re.compile(r"^([a-z]\w*):", re.MULTILINE)
_CLAIM = re.compile(r"^- id: *\"?([^\s\"]+)", re.MULTILINE)


def _completer(words: Callable[[Study], Iterable[str]]) -> Completer:
    def complete(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        given = ctx.params.get(param.name or "") or ()
        try:
            study = locate(ctx.params.get("params"), ctx.params.get("results"))
            known = [word for word in words(study) if word.startswith(incomplete)]
        except (StudyError, OSError):
            return []
        return [CompletionItem(word) for word in dict.fromkeys(known) if word not in given]

    return complete


def _parameters(study: Study, ending: str = "") -> list[str]:
    return [f"{path.stem}.{key}{ending}" for path in sorted(study.params.glob("*.yaml"))
            for key in _KEY.findall(path.read_text(encoding="utf-8"))]  # fmt: skip


def _figures(study: Study) -> list[str]:
    return sorted(path.stem for path in (study.results / "figures").iterdir() if not path.name.startswith("."))


def _claims(study: Study) -> list[str]:
    return _CLAIM.findall((study.results / "claims.yaml").read_text(encoding="utf-8"))


stages = _completer(attrgetter("graph.stages"))
parameters = _completer(_parameters)
settings = _completer(partial(_parameters, ending="="))
figures = _completer(_figures)
claims = _completer(_claims)


def files(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Leaves it to the shell to complete a path."""
    return [CompletionItem(incomplete, type="file")]


def stages_or_files(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """A stage, or a path where no stage begins so."""
    return stages(ctx, param, incomplete) or files(ctx, param, incomplete)


def for_option(about: Any) -> Completer | None:
    """What completes an option that a question declares, by what it declares."""
    if about["choices"]:
        return _completer(lambda study: about["choices"])
    return parameters if about["metavar"].startswith("FILE.KEY") else None
