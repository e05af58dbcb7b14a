"""`bipedstudy init DIR`: a new study of one's own."""

from __future__ import annotations

import re
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
def init(folder: Path, update: bool) -> None:
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
    target = folder.absolute()
    readme = (face() / "new_study.md").read_text(encoding="utf-8").format(name=target.name)
    with disk.whole(target) as unfinished:
        for name, content in {**_given(), "README.md": readme.encode(), ".gitignore": b"results/\n"}.items():
            disk.write(unfinished / name, content)
        if target.exists():
            target.rmdir()
    click.echo(f"a new study is in {shown(target)}; next: cd {shown(target)}, and see its README.md")


def _update(folder: Path) -> None:
    """Bring a study that runs the installed stages to this version. Raises `StudyError` if it has stages of its own."""
    study = locate(start=folder)
    if study.borrowed or study.code_root == study.root:
        raise StudyError(f"{shown(folder)}: is not a study that `init` laid out")
    for name, new in _given().items():
        path = study.root / name
        old = disk.read(path)
        if name == FILE_NAME and new != old:
            disk.write(path.with_suffix(".yaml.old"), old or b"")
            disk.write(path, new)
            click.echo(f"{shown(path)}: written anew; the old one is {path.name}.old")
        elif not path.exists():
            disk.write(path, new)
            click.echo(f"{shown(path)}: added")


def _given() -> dict[str, bytes]:
    """The parameter files that this program comes with, and its dvc.yaml without the stages' code.

    That lies with the installed package and not in a new study.
    """
    text = (home() / FILE_NAME).read_text(encoding="utf-8")
    kept = "".join(line for line in text.splitlines(keepends=True) if not line.strip().startswith("- stages/"))
    graph = re.sub(r"^ *deps:\n(?! *- )", "", kept, flags=re.MULTILINE)
    files = sorted((home() / "params").glob("*.yaml"))
    return {FILE_NAME: graph.encode(), **{f"params/{file.name}": file.read_bytes() for file in files}}
