"""The reference of every command and every parameter, made from the code: docs/reference.md.

`python -m pipeline.reference` writes it; a test holds the file against the code.
"""

import dataclasses
import itertools
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, get_args

import click

from pipeline.cache import disk
from pipeline.cli import cli
from pipeline.parameters import loading
from pipeline.parameters.value import allowed, declared
from pipeline.study import Study, locate

FILE = Path(__file__).resolve().parent.parent / "docs/reference.md"
_HEAD = """# Reference

This page lists every command and every parameter; `python -m pipeline.reference` makes it from the code.
"""
_EVERY = ("`--params`", "`--results`", "`--set`", "`--json`")  #: Most commands have these: they are not named again.


def text(study: Study) -> str:
    """The whole reference as Markdown."""
    return "\n".join([_HEAD, *_commands(), *_parameters(study)]) + "\n"


def _commands() -> Iterator[str]:
    context = click.Context(cli, info_name="bipedstudy")
    commands = {name: command for name in cli.list_commands(context) if (command := cli.get_command(context, name))}
    options = {n: [_option(one) for one in c.params if isinstance(one, click.Option)] for n, c in commands.items()}
    common = {row for row, count in Counter(itertools.chain(*options.values())).items() if count > 1}
    yield "## Commands\n\nOptions of several commands; most have `--params`, `--results`, `--set` and `--json`:\n"
    yield from [*_listed(sorted(common)), ""]
    for name, command in commands.items():
        yield from _command(name, command, options[name], common)


def _command(name: str, command: click.Command, options: list[tuple[str, str]], common: set[Any]) -> Iterator[str]:
    arguments = [_argument(item) for item in command.params if isinstance(item, click.Argument)]
    yield f"### bipedstudy {' '.join([name, *arguments])}\n"
    yield f"{_paragraphs(command.help or '')}\n"
    if rows := [row for row in options if row not in common]:
        yield from [*_listed(rows), ""]
    named = [row[0] for row in options if row in common and not row[0].startswith(_EVERY)]
    if shared := [option.rpartition("`")[0] + "`" for option in named]:
        yield f"Also {', '.join(shared)}\n"


def _listed(rows: Iterable[tuple[str, str]]) -> Iterator[str]:
    return (f"- {option}: {meaning}" for option, meaning in rows)


def _argument(item: click.Argument) -> str:
    name = (item.metavar or (item.name or "").upper()).removesuffix("...").strip("[]")
    name = f"{name}..." if item.nargs == -1 else name
    return name if item.required else f"[{name}]"


def _option(item: click.Option) -> tuple[str, str]:
    names = " ".join(f"`{name}`" for name in (*item.opts, *item.secondary_opts))
    value = "" if item.is_flag else f" {item.metavar or item.type.name.upper()}"
    default = f" Default: {item.default}." if item.show_default is True else ""
    more = " Repeatable." if item.multiple and "epeatable" not in (item.help or "") else ""
    return names + value, f"{item.help or ''}{default}{more}"


def _paragraphs(words: str) -> str:
    return "\n\n".join(" ".join(part.split()) for part in words.replace("\b", "").split("\n\n"))


def _parameters(study: Study) -> Iterator[str]:
    known = study.parameters_classes()
    yield "## Parameters\n\nBy file of `params/`, which has values and sources."
    yield "A change makes the stages that read it stale: `bipedstudy graph` prints them.\n"
    for file, kinds in sorted(loading.sections(known.values()).items()):
        fields = {key: pair for kind in kinds for key, pair in declared(kind).items()}
        yield from [f"### {file}.yaml\n", *(f"- `{file}.{key}` {_field(*pair)}" for key, pair in fields.items()), ""]
        for key, (field, kind) in fields.items():
            if (inner := _rows(field, kind)) is not None:
                yield f"Columns of `{file}.{key}`:\n"
                yield from [*(f"- `{name}` {_field(*pair)}" for name, pair in declared(inner).items()), ""]


def _field(field: dataclasses.Field[Any], kind: Any) -> str:
    """What is allowed, with its unit, and the meaning."""
    about = field.metadata
    described = about["description"] + (f", {about['symbol']}" if about["symbol"] else "")
    if _rows(field, kind):
        return f"(a table): {described}"
    if field.default is not dataclasses.MISSING:
        described += " (optional)" if field.default is None else f" (default: {field.default})"
    limits = "a file" if about["file"] else allowed(field, kind)
    return f"({limits.replace(' and ', ', ')}): {described}"


def _rows(field: dataclasses.Field[Any], kind: Any) -> type | None:
    """The class of a table's rows; None for what is no table, or a word beside which a row is allowed."""
    kinds = [kind, *get_args(kind)] if not field.metadata["choices"] else []
    return next((item for item in kinds if isinstance(item, type) and dataclasses.is_dataclass(item)), None)


if __name__ == "__main__":
    disk.write(FILE, text(locate(start=FILE.parent)).encode())
