"""How a lab's files are opened, and the one way the ingest says no.

A file is opened only if it is a plain one: a pipe never ends, and a device has no size.
"""

import importlib
import stat
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

#: Longest line of a table [characters]; a sparse file of gigabytes is one line.
LONGEST_LINE = 1_000_000
#: Characters read at a time.
BLOCK = 1 << 20


class SourceRefused(ValueError):
    """A source cannot be read or a recording cannot be used; the message is one sentence a user can act on."""


def printable(name: object, limit: int = 60) -> str:
    """A name from a source, safe to show: control characters escaped, shortened to `limit` characters."""
    text = "".join(one if one.isprintable() else one.encode("unicode_escape").decode("ascii") for one in str(name))
    return f"'{text[:limit]}…'" if len(text) > limit else f"'{text}'"


def refuse(*rows: tuple[bool, str]) -> None:
    """Raises SourceRefused with the sentence of the first row that holds: whether something is wrong, and what."""
    for wrong, sentence in rows:
        if wrong:
            raise SourceRefused(sentence)


@contextmanager
def as_file(content: bytes, name: str) -> Iterator[Path]:
    """A file of this content and name, for as long as it is read."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, name)
        path.write_bytes(content)
        yield path


def check(path: Path) -> None:
    """Raises SourceRefused, in one sentence, unless there is a plain file at `path`."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError) as error:
        raise SourceRefused(f"{printable(path.name)} cannot be read ({getattr(error, 'strerror', error)})") from error
    what = "a folder" if stat.S_ISDIR(mode) else "a pipe, device or socket"
    refuse((not stat.S_ISREG(mode), f"{printable(path.name)} cannot be read: it is {what}, not a file"))


@contextmanager
def opening(path: Path, what: str, or_folder: bool = False) -> Iterator[None]:
    """Raises SourceRefused for what is no plain file, and for all that a reader stumbles over: it is no `what`."""
    if not (or_folder and path.is_dir()):
        check(path)
    try:
        yield
    except SourceRefused:
        raise
    except Exception as error:  # readers of a format raise whatever a broken file makes them raise
        raise SourceRefused(f"{printable(path.name)} is no {what}") from error


def library(name: str, extra: str, path: Path) -> Any:
    """A library that not every lab has. Raises SourceRefused, naming the extra that brings it, where it is missing."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise SourceRefused(
            f"{printable(path.name)}: to read it, {name.partition('.')[0]} is needed: pip install 'bipedstudy[{extra}]'"
        ) from None


def place_of(file: str, wanted: str, has: Sequence[str]) -> int:
    """Where a column stands among the names that a file has. Raises SourceRefused unless it is there once."""
    name = f"{printable(file)} has no column {printable(wanted)}; it has {printable(', '.join(has[:12]), 200)}"
    refuse((wanted not in has, name),
           (has.count(wanted) > 1, f"{printable(file)} has the column {printable(wanted)} more than once"))
    return has.index(wanted)


def blocks(file: TextIO, name: str) -> Iterator[list[str]]:
    """The lines of a text, opened with any kind of newline, without their ends; some `BLOCK` characters at a time.

    Raises SourceRefused for a line that no table has.
    """
    begun = ""
    while text := file.read(BLOCK):
        *whole, begun = (begun + text).split("\n")
        if len(begun) >= LONGEST_LINE:
            raise SourceRefused(f"{printable(name)} is no table (a line of more than {LONGEST_LINE:,} characters)")
        yield whole
    if begun:
        yield [begun]
