"""The documents: the reference is complete and current, the tutorial's commands work as they stand there."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import click
import pytest

from pipeline import reference, yaml_text
from pipeline.cli import cli
from pipeline.study import locate


def test_the_reference_is_current(repository):
    written = (repository / "docs/reference.md").read_text()
    assert written == reference.text(locate(start=repository)), "run: python -m pipeline.reference"


def test_the_reference_names_every_parameter_of_every_file(repository):
    text = (repository / "docs/reference.md").read_text()
    for path in (repository / "params").glob("*.yaml"):
        for key, entry in yaml_text.read(path, path.name).value.items():
            assert f"| `{path.stem}.{key}` |" in text
            for row in entry.value["rows"].value if "rows" in entry.value else ():
                assert all(f"| `{column}` |" in text for column in row.value)


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
            if isinstance(option, click.Option) and option.opts[0] not in ("--params", "--results", "--set"):
                assert option.help, f"{name} {option.opts[0]} has no help"
                assert all(f"`{word}`" in sections[name] for word in option.opts), f"{name} {option.opts}"


@pytest.mark.slow
def test_the_tutorial_works_as_it_is_written(repository, tmp_path):
    text = (repository / "docs/own_biped.md").read_text()
    script = "\n".join(re.findall(r"^```sh\n(.*?)^```", text, flags=re.M | re.S))
    assert script.count("bipedstudy") >= 12
    tools = tmp_path / "bin"
    tools.mkdir()
    program = tools / "bipedstudy"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m pipeline.cli "$@"\n')
    program.chmod(0o755)
    environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}", "PYTHONPATH": str(repository)}
    done = subprocess.run(["bash", "-euxc", script], cwd=tmp_path, env=environment, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr
    study = tmp_path / "my_biped"
    assert (study / "results/multibody.h5").exists() and (study / "lab.sqlite").exists()
    assert "complete" in (study / "bipedstudy-completion.sh").read_text()
    # models and (synthetic) recording agree on the heavier biped within a percent, as the tutorial says
    found = dict(re.findall(r"^(analytic|multibody|imu) .*?(\d\.\d+) (?:Hz|\+-)", done.stdout, flags=re.M))
    frequencies = [float(word) for word in found.values()]
    assert len(frequencies) == 3 and max(frequencies) / min(frequencies) < 1.01, found
