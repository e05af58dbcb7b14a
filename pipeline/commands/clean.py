"""`bipedstudy clean`: earlier results and old machine code, with their sizes."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import click

from pipeline.cache import lock, old
from pipeline.commands import options
from pipeline.study import Study, shown


@click.command("clean")
@options.own_study
@click.option("--dry-run", is_flag=True, help="Say what would be removed; remove nothing.")
@click.option("--wait", is_flag=True, help="Wait for another run in the same results folder.")
@options.as_json
def command(study: Study, dry_run: bool, wait: bool, as_json: bool) -> None:
    """Remove earlier results from the cache, and machine code of earlier sources; the current results stay.

    After this an undone edit is computed again. What questions and sweeps keep stays as well.
    """
    name = shown(study.results)
    with lock.held(study.results, name, "bipedstudy clean", wait, lambda said: click.echo(said, err=True)):
        if not dry_run:
            study.store.sweep()
        found = [(folder, what, old.size(folder)) for folder, what in _old(study)]
        for folder, what, size in found:
            if not dry_run:
                shutil.rmtree(folder, ignore_errors=True)
            if not as_json:
                click.echo(f"{old.told(size):>9}  {what}: {shown(folder)}")
    if as_json:
        options.print_json({"removed": not dry_run, "folders": [
            {"folder": shown(folder), "what": what, "bytes": size} for folder, what, size in found]})  # fmt: skip
        return
    total = old.told(sum(size for _, _, size in found))
    click.echo(f"{total:>9}  in {len(found)} folders {'would be removed' if dry_run else 'removed'}")


def _old(study: Study) -> Iterator[tuple[Path, str]]:
    """Every folder that can go, and what it is."""
    yield from old.entries(study.store)
    folders = {folder for module in study.offered("compiled") for folder in module.CODE.old(1)}
    beside = (study.code_root / study.package).rglob("__pycache__/numba-*")  # where 0.1.0 kept it
    yield from ((folder, "machine code of earlier sources") for folder in sorted({*folders, *beside}))
