"""What the cache holds beyond what lies in the results folder: earlier results, kept so that an edit can be undone."""

from __future__ import annotations

from pathlib import Path

from pipeline.cache.store import QUESTIONS, SWEEPS, Store

#: Earlier results of this size are worth a word [bytes].
WORTH_A_WORD = 2_000_000_000


def entries(store: Store) -> list[tuple[Path, str]]:
    """Folder of each stored result that is not the current one of its stage, and what to call it."""
    current = store.last_keys()
    found = []
    for folder in sorted(store.folder.iterdir()) if store.folder.is_dir() else ():
        if folder.name not in current and (folder / "manifest.json").exists() and not folder.is_symlink():
            entry = store.entry(folder.name)
            found.append((folder, f"an earlier result of {entry.stage}" if entry else "a damaged result"))
    return found


def journals(store: Store) -> list[tuple[Path, str]]:
    """Every file in which questions and sweeps keep what they computed, and what to call it; no link is followed."""
    places = (
        (store.folder / QUESTIONS, "what a question keeps"),
        (store.folder.parent / SWEEPS / ".cache", "what sweeps keep"),
    )
    return [(path, what) for folder, what in places
            if not any(each.is_symlink() for each in (folder, folder.parent)) and folder.is_dir()
            for path in sorted(folder.glob("*.jsonl")) if not path.is_symlink() and path.is_file()]  # fmt: skip


def size(place: Path) -> int:
    """Bytes of a file, or of all files in a folder; links are not followed."""
    paths = place.rglob("*") if place.is_dir() else (place,)
    return sum(path.lstat().st_size for path in paths if not path.is_dir())


def told(number: int) -> str:
    """A size in words: 0.4 MB, 2.1 GB."""
    return f"{number / 1e9:.1f} GB" if number >= 1e9 else f"{number / 1e6:.1f} MB"
