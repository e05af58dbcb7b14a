"""The reference is complete and current."""

from __future__ import annotations

import re

import click

from pipeline import reference
from pipeline.cli import cli
from pipeline.parameters import yaml_text
from pipeline.study import locate


def test_the_reference_is_current(repository):
    written = (repository / "docs/reference.md").read_text()
    assert written == reference.text(locate(start=repository)), "run: python -m pipeline.reference"


def test_the_reference_names_every_parameter_of_every_file(repository):
    text = (repository / "docs/reference.md").read_text()
    for path in (repository / "params").glob("*.yaml"):
        for key, entry in yaml_text.read(path, path.name).value.items():
            assert f"- `{path.stem}.{key}` (" in text
            for row in entry.value["rows"].value if "rows" in entry.value else ():
                assert all(f"- `{column}` (" in text for column in row.value)


def test_the_reference_names_every_command_and_option(repository):
    text = (repository / "docs/reference.md").read_text()
    parts = re.split(r"^### bipedstudy ", text, flags=re.M)[1:]
    sections = {part.split()[0]: part for part in parts}
    context = click.Context(cli)
    assert set(cli.list_commands(context)) == set(sections)
    for name in cli.list_commands(context):
        command = cli.get_command(context, name)
        assert command.help, name
        for option in command.params:
            if isinstance(option, click.Option) and option.opts[0] not in ("--params", "--results", "--set", "--json"):
                assert option.help, f"{name} {option.opts[0]} has no help"
                assert all(f"`{word}`" in sections[name] for word in option.opts), f"{name} {option.opts}"


def test_the_site_has_every_page_and_the_page_of_stages_every_stage(repository):
    index = (repository / "docs/index.md").read_text().splitlines()
    assert {path.stem for path in (repository / "docs").glob("*.md")} - set(index) == {"index"}
    stages = (repository / "docs/stages.md").read_text()
    assert [name for name in locate(start=repository).graph.stages if f"| `{name}` |" not in stages] == []


def test_the_pages_name_files_that_are_there(repository):
    """A Python file in backquotes is one of the checkout, by its whole path or the end of it."""
    tops = ("pipeline", "stages", "tests", "benchmarks", "docs")
    there = [f"/{path.relative_to(repository).as_posix()}" for top in tops for path in (repository / top).rglob("*.py")]
    for page in (*(repository / "docs").glob("*.md"), repository / "README.md"):
        named = re.findall(r"`((?:\w+/)*\w+\.py)`", page.read_text(encoding="utf-8"))
        assert [name for name in named if not any(path.endswith(f"/{name}") for path in there)] == [], page.name
