"""Files of a lab, opened only if they are plain files: a pipe never ends, and a device has no size."""

from __future__ import annotations

import stat
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import TextIO

from stages.imu.errors import SourceRefused, printable

#: Longest line of a table [characters]; a sparse file of gigabytes is one line.
LONGEST_LINE = 1_000_000
#: Characters read at a time.
BLOCK = 1 << 20


def check(path: Path) -> None:
    """Raises SourceRefused, in one sentence, unless there is a plain file at `path`."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError) as error:
        raise SourceRefused(f"{printable(path.name)} cannot be read ({getattr(error, 'strerror', error)})") from error
    if not stat.S_ISREG(mode):
        what = "a folder" if stat.S_ISDIR(mode) else "a pipe, device or socket"
        raise SourceRefused(f"{printable(path.name)} cannot be read: it is {what}, not a file")


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


def lines(file: TextIO, name: str) -> Iterator[str]:
    """The same, a line at a time."""
    return chain.from_iterable(blocks(file, name))
