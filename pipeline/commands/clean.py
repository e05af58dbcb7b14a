"""`bipedstudy clean`: earlier results, old machine code, and if asked for what questions and sweeps keep."""

from __future__ import annotations

import contextlib
import functools
import shutil
from collections.abc import Iterator
from pathlib import Path

import click

from pipeline import layout
from pipeline.cache import lock, old
from pipeline.cache.store import SWEEPS
from pipeline.commands import options
from pipeline.study import Study, shown


@click.command("clean", epilog=options.examples("clean"))
@options.own_study
@click.option("--dry-run", is_flag=True, help="Say what would be removed; remove nothing.")
@click.option("--journals", is_flag=True, help="Also what questions and sweeps keep: asked again, they compute anew.")
@click.option("--wait", is_flag=True, help="Wait for another run in the same results folder.")
@options.as_json
def command(study: Study, dry_run: bool, journals: bool, wait: bool, as_json: bool) -> None:
    """Remove earlier results from the cache, and machine code of earlier sources; the current results stay.

    After this an undone edit is computed again. What questions and sweeps keep stays, unless --journals is given.
    """
    with contextlib.ExitStack() as locks:
        for folder in (study.results, *([study.results / SWEEPS] if (study.results / SWEEPS).is_dir() else [])):
            said = functools.partial(click.echo, err=True)
            locks.enter_context(lock.held(folder, shown(folder), "bipedstudy clean", wait, said))
        if not dry_run:
            study.store.sweep()
        kept = old.journals(study.store) if journals else ()
        found = [(folder, what, old.size(folder)) for folder, what in (*_old(study), *kept)]
        for folder, what, size in found:
            if not dry_run and folder.is_dir():
                shutil.rmtree(folder, ignore_errors=True)
            elif not dry_run:
                folder.unlink(missing_ok=True)
            if not as_json:
                click.echo(layout.beside(f"{old.told(size):>9}  ", f"{what}: {shown(folder)}"))
    if as_json:
        options.print_json({"removed": not dry_run, "folders": [
            {"folder": shown(folder), "what": what, "bytes": size} for folder, what, size in found]})  # fmt: skip
        return
    total = old.told(sum(size for _, _, size in found))
    click.echo(f"{total:>9}  in {len(found)} places {'would be removed' if dry_run else 'removed'}")


def _old(study: Study) -> Iterator[tuple[Path, str]]:
    """Every folder that can go, and what it is."""
    yield from old.entries(study.store)
    folders = {folder for module in study.offered("compiled") for folder in module.CODE.old(1)}
    beside = (study.code_root / study.package).rglob("__pycache__/numba-*")  # where 0.1.0 kept it
    yield from ((folder, "machine code of earlier sources") for folder in sorted({*folders, *beside}))
