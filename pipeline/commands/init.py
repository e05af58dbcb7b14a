"""`bipedstudy init DIR`: a new study of one's own."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

import click

from pipeline.cache import durable
from pipeline.errors import StudyError
from pipeline.graph import FILE_NAME
from pipeline.home import face, home
from pipeline.study import shown


@click.command("init")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
def command(folder: Path) -> None:
    """Lay out a new study in DIR: parameters to edit, the graph of stages, and a README.

    DIR must not exist yet, or be empty. The parameters are those of the study this program comes with.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise StudyError(f"{shown(folder)}: is there already and not an empty folder; choose another")
    given = home()
    readme = (face() / "new_study.md").read_text(encoding="utf-8")
    target = folder.absolute()
    unfinished = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        for source in sorted((given / "params").glob("*.yaml")):
            durable.write(unfinished / "params" / source.name, source.read_bytes())
        durable.write(unfinished / FILE_NAME, _graph((given / FILE_NAME).read_text(encoding="utf-8")).encode())
        durable.write(unfinished / "README.md", readme.format(name=target.name).encode())
        durable.write(unfinished / ".gitignore", b"results/\n")
        if target.exists():
            target.rmdir()
        unfinished.rename(target)
    except BaseException:
        shutil.rmtree(unfinished, ignore_errors=True)
        raise
    click.echo(f"a new study is in {shown(target)}; next: cd {shown(target)}, and see its README.md")


def _graph(text: str) -> str:
    """dvc.yaml without the stages' code, which lies with the installed package and not in the new study."""
    kept = "".join(line for line in text.splitlines(keepends=True) if not line.strip().startswith("- stages/"))
    return re.sub(r"^ *deps:\n(?! *- )", "", kept, flags=re.MULTILINE)
