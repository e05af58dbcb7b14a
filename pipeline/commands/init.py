"""`bipedstudy init DIR`: a new study for a biped of one's own."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

import click

from pipeline.cache import durable
from pipeline.errors import StudyError
from pipeline.study import shown

_HOME = Path(__file__).resolve().parent.parent.parent
_README = """# {name}

A study of a biped of your own, made with `bipedstudy init`. It starts with the biped of the paper.

    bipedstudy gait               # the gait of the design in params/biped.yaml
    bipedstudy run multibody      # the same design in Exudyn
    bipedstudy run-all            # everything, into results/
    bipedstudy status             # what is current, and why the rest is not

`params/` holds every value with its unit and source: put yours in, with where they come from. `dvc.yaml` is the graph
of the stages; their code is the installed package's, so a change of it is noticed by `bipedstudy`, not by `dvc repro`.
"""


@click.command("init")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
def command(folder: Path) -> None:
    """Lay out a new study in DIR: parameters to edit, the graph of stages, and a README.

    DIR must not exist yet, or be empty. The parameters are those of the study this program comes with.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise StudyError(f"{shown(folder)}: is there already and not an empty folder; choose another")
    sources = sorted((_HOME / "params").glob("*.yaml"))
    if not sources or not (_HOME / "dvc.yaml").is_file():
        raise StudyError(f"{_HOME}: holds no parameters to start from; install the package with pip install --editable")
    target = folder.absolute()
    unfinished = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        for source in sources:
            durable.write(unfinished / "params" / source.name, source.read_bytes())
        durable.write(unfinished / "dvc.yaml", _graph((_HOME / "dvc.yaml").read_text(encoding="utf-8")).encode())
        durable.write(unfinished / "README.md", _README.format(name=target.name).encode())
        durable.write(unfinished / ".gitignore", b"results/\n")
        if target.exists():
            target.rmdir()
        unfinished.rename(target)
    except BaseException:
        shutil.rmtree(unfinished, ignore_errors=True)
        raise
    click.echo(f"a new study is in {shown(target)}; next: cd {shown(target)}, edit params/biped.yaml, bipedstudy gait")


def _graph(text: str) -> str:
    """dvc.yaml without the stages' code, which lies with the installed package and not in the new study."""
    kept = "".join(line for line in text.splitlines(keepends=True) if not line.strip().startswith("- stages/"))
    return re.sub(r"^ *deps:\n(?! *- )", "", kept, flags=re.MULTILINE)
