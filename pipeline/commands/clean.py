"""`bipedstudy clean`: earlier results (kept to undo an edit), old machine code, what questions and sweeps keep."""

from __future__ import annotations

import contextlib
import functools
import shutil
from collections.abc import Iterator
from pathlib import Path

import click

from pipeline import layout
from pipeline.cache import disk
from pipeline.cache.store import QUESTIONS, SWEEPS, Store
from pipeline.commands import options
from pipeline.study import Study, shown

#: Earlier results of this size are worth a word [bytes].
WORTH_A_WORD = 2_000_000_000


@click.command("clean", epilog=options.examples("clean"))
@options.own_study
@click.option("--dry-run", is_flag=True, help="Say what would be removed; remove nothing.")
@click.option("--journals", is_flag=True, help="Also what questions and sweeps keep: asked again, they compute anew.")
@click.option("--wait", is_flag=True, help="Wait for another run in the same results folder.")
@options.answers_without_rows
def clean(study: Study, dry_run: bool, journals: bool, wait: bool, form: options.Form) -> None:
    """Remove earlier results from the cache, and machine code of earlier sources; the current results stay.

    After this an undone edit is computed again. What questions and sweeps keep stays, unless --journals is given.
    """
    with contextlib.ExitStack() as locks:
        for folder in (study.results, *([study.results / SWEEPS] if (study.results / SWEEPS).is_dir() else [])):
            said = functools.partial(click.echo, err=True)
            locks.enter_context(disk.locked(folder, shown(folder), "bipedstudy clean", wait, said))
        if not dry_run:
            study.store.sweep()
        found = [(folder, what, size_of(folder)) for folder, what in _removable(study, journals)]
        for folder, what, size in found:
            if not dry_run and folder.is_dir():
                shutil.rmtree(folder, ignore_errors=True)
            elif not dry_run:
                folder.unlink(missing_ok=True)
            if form.is_text:
                click.echo(layout.beside(f"{told(size):>9}  ", f"{what}: {shown(folder)}"))
    plain = [{"folder": shown(folder), "what": what, "bytes": size} for folder, what, size in found]
    total, how = told(sum(size for _, _, size in found)), "would be removed" if dry_run else "removed"
    form.give([f"{total:>9}  in {len(found)} places {how}"], {"removed": not dry_run, "folders": plain})


def _removable(study: Study, journals: bool) -> Iterator[tuple[Path, str]]:
    """Every folder and file that can go, and what it is; no link is followed."""
    store = study.store
    yield from earlier(store)
    folders = {folder for module in study.offered("compiled") for folder in module.CODE.old(1)}
    beside = (study.code_root / study.package).rglob("__pycache__/numba-*")  # where 0.1.0 kept it
    yield from ((folder, "machine code of earlier sources") for folder in sorted({*folders, *beside}))
    kept = {store.folder / QUESTIONS: "what a question keeps", study.results / SWEEPS / ".cache": "what sweeps keep"}
    for folder, what in kept.items() if journals else ():
        if folder.is_dir() and not (folder.is_symlink() or folder.parent.is_symlink()):
            yield from ((path, what) for path in sorted(folder.glob("*.jsonl"))
                        if not path.is_symlink() and path.is_file())  # fmt: skip


def earlier(store: Store) -> Iterator[tuple[Path, str]]:
    """Folder of each stored result that is not the current one of its stage, and what to call it."""
    current = store.last_keys()
    for folder in sorted(store.folder.iterdir()) if store.folder.is_dir() else ():
        if folder.name not in current and (folder / "manifest.json").exists() and not folder.is_symlink():
            entry = store.entry(folder.name)
            yield folder, f"an earlier result of {entry.stage}" if entry else "a damaged result"


def size_of(place: Path) -> int:
    """Bytes of a file, or of all files in a folder; links are not followed."""
    paths = place.rglob("*") if place.is_dir() else (place,)
    return sum(path.lstat().st_size for path in paths if not path.is_dir())


def told(number: int) -> str:
    """A size in words: 0.4 MB, 2.1 GB."""
    return f"{number / 1e9:.1f} GB" if number >= 1e9 else f"{number / 1e6:.1f} MB"
