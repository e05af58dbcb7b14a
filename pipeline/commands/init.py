"""`bipedstudy init DIR`: a new study of one's own."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

import click

from pipeline.cache import disk
from pipeline.commands import options
from pipeline.errors import StudyError
from pipeline.graph import FILE_NAME
from pipeline.home import face, home
from pipeline.study import locate, shown


@click.command("init", epilog=options.examples("init"))
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--update", is_flag=True, help="DIR is a study laid out by an earlier version: renew its graph.")
def command(folder: Path, update: bool) -> None:
    """Lay out a new study in DIR: parameters to edit, the graph of stages, and a README.

    DIR must not exist yet, or be empty. The parameters are those of the study this program comes with. With --update
    dvc.yaml is written anew (the old one stays beside it), parameter files that are missing are added, and none is
    changed.
    """
    if update:
        _update(folder)
        return
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise StudyError(f"{shown(folder)}: is there already and not an empty folder; choose another")
    given = home()
    readme = (face() / "new_study.md").read_text(encoding="utf-8")
    target = folder.absolute()
    unfinished = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        for source in sorted((given / "params").glob("*.yaml")):
            disk.write(unfinished / "params" / source.name, source.read_bytes())
        disk.write(unfinished / FILE_NAME, _graph((given / FILE_NAME).read_text(encoding="utf-8")).encode())
        disk.write(unfinished / "README.md", readme.format(name=target.name).encode())
        disk.write(unfinished / ".gitignore", b"results/\n")
        if target.exists():
            target.rmdir()
        unfinished.rename(target)
    except BaseException:
        shutil.rmtree(unfinished, ignore_errors=True)
        raise
    click.echo(f"a new study is in {shown(target)}; next: cd {shown(target)}, and see its README.md")


def _update(folder: Path) -> None:
    """Bring a study that runs the installed stages to this version. Raises `StudyError` if it has stages of its own."""
    study = locate(start=folder)
    if study.borrowed or study.code_root == study.root:
        raise StudyError(f"{shown(folder)}: is not a study that `init` laid out")
    given, path = home(), study.root / FILE_NAME
    new, old = _graph((given / FILE_NAME).read_text(encoding="utf-8")).encode(), disk.read(path) or b""
    if new != old:
        disk.write(path.with_suffix(".yaml.old"), old)
        disk.write(path, new)
        click.echo(f"{shown(path)}: written anew; the old one is {path.name}.old")
    for source in sorted((given / "params").glob("*.yaml")):
        target = study.params / source.name
        if not target.exists():
            disk.write(target, source.read_bytes())
            click.echo(f"{shown(target)}: added")


def _graph(text: str) -> str:
    """dvc.yaml without the stages' code, which lies with the installed package and not in the new study."""
    kept = "".join(line for line in text.splitlines(keepends=True) if not line.strip().startswith("- stages/"))
    return re.sub(r"^ *deps:\n(?! *- )", "", kept, flags=re.MULTILINE)
