"""The reference of every command and every parameter, made from the code: docs/reference.md.

`python -m pipeline.reference` writes it; a test holds the file against the code.
"""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from pipeline import layout
from pipeline.cache import disk
from pipeline.cli import cli
from pipeline.parameters import loading
from pipeline.parameters.value import allowed, declared
from pipeline.study import Study, locate

FILE = Path(__file__).resolve().parent.parent / "docs/reference.md"
_HEAD = """# Reference

Every command and every parameter. Made from the code by `python -m pipeline.reference`; do not edit.
"""
_SHARED = ("--params", "--results", "--set")


def text(study: Study) -> str:
    """The whole reference as Markdown."""
    return "\n".join([_HEAD, *_commands(), *_parameters(study)]) + "\n"


def _commands() -> Iterator[str]:
    context = click.Context(cli, info_name="bipedstudy")
    yield "## Commands\n"
    yield (
        "Commands end with 0, with 1 if something failed, with 2 and a sentence if the input is wrong, and with 3 if"
        " the answer is no.\nMost take `--params DIR`, `--results DIR` and `--set FILE.KEY=VALUE`, not repeated below:"
        " the folder of the parameter files, that of\nthe results, and a parameter to change for this command, as often"
        " as wanted.\n"
    )
    for name in cli.list_commands(context):
        command = cli.get_command(context, name)
        assert command is not None
        arguments = [_argument(item) for item in command.params if isinstance(item, click.Argument)]
        yield f"### bipedstudy {' '.join([name, *arguments])}\n"
        yield f"{_paragraphs(command.help or '')}\n"
        options = [item for item in command.params if isinstance(item, click.Option)]
        rows = [_option(item) for item in options if item.opts[0] not in _SHARED]
        if rows:
            yield from [*layout.markdown(("option", "meaning"), rows), ""]
        if command.epilog:
            lines = [line.strip() for line in command.epilog.splitlines() if line.strip().startswith("bipedstudy")]
            yield f"Examples: {', '.join(f'`{line}`' for line in lines)}\n"


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
    yield "## Parameters\n"
    yield (
        "By file of `params/`. Values and their sources stand in the files. *Read by*: the stages that a change makes"
        " stale.\n"
    )
    for file, kinds in sorted(loading.sections(known.values()).items()):
        yield f"### {file}.yaml\n"
        fields = {key: pair for kind in kinds for key, pair in declared(kind).items()}
        read = {name: {key for kind in loading.sections([cls]).get(file, ()) for key in declared(kind)}
                for name, cls in known.items()}  # fmt: skip
        rows = [(f"`{file}.{key}`", *_field(*pair), ", ".join(name for name, keys in read.items() if key in keys))
                for key, pair in fields.items()]  # fmt: skip
        yield from [*layout.markdown(("parameter", "meaning", "unit", "allowed", "read by"), rows), ""]
        for key, (field, kind) in fields.items():
            if (inner := _rows(field, kind)) is not None:
                yield f"Columns of `{file}.{key}`:\n"
                columns = [(f"`{name}`", *_field(*pair)) for name, pair in declared(inner).items()]
                yield from [*layout.markdown(("column", "meaning", "unit", "allowed"), columns), ""]


def _field(field: dataclasses.Field[Any], kind: Any) -> tuple[str, str, str]:
    """Meaning, unit and what is allowed."""
    about = field.metadata
    described = about["description"] + (f", {about['symbol']}" if about["symbol"] else "")
    if _rows(field, kind):
        return described, "", "a table"
    if field.default is not dataclasses.MISSING:
        described += f" (without it: {'none' if field.default is None else field.default})"
    free = "a file" if about["file"] else "true, false" if kind is bool else "a word" if about["unit"] == "-" else ""
    limits = allowed(field) if about["choices"] or not free else free
    return described, "" if about["unit"] == "-" else about["unit"], limits


def _rows(field: dataclasses.Field[Any], kind: Any) -> type | None:
    """The class of a table's rows; None for what is no table, or a word beside which a row is allowed."""
    kinds = [kind, *typing.get_args(kind)] if not field.metadata["choices"] else []
    return next((item for item in kinds if isinstance(item, type) and dataclasses.is_dataclass(item)), None)


if __name__ == "__main__":
    disk.write(FILE, text(locate(start=FILE.parent)).encode())
