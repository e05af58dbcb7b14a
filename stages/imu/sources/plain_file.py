"""Files of a lab, opened only if they are plain files: a pipe never ends, and a device has no size."""

from __future__ import annotations

import stat
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

from stages.imu.errors import SourceRefused, printable

#: Longest line of a table [characters]; a sparse file of gigabytes is one line.
LONGEST_LINE = 1_000_000


def check(path: Path) -> None:
    """Raises SourceRefused, in one sentence, unless there is a plain file at `path`."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError) as error:
        raise SourceRefused(f"{printable(path.name)} cannot be read ({getattr(error, 'strerror', error)})") from error
    if not stat.S_ISREG(mode):
        what = "a folder" if stat.S_ISDIR(mode) else "a pipe, device or socket"
        raise SourceRefused(f"{printable(path.name)} cannot be read: it is {what}, not a file")


def lines(file: TextIO, name: str) -> Iterator[str]:
    """The lines of a text, one in memory at a time. Raises SourceRefused for one that no table has."""
    while line := file.readline(LONGEST_LINE):
        if len(line) == LONGEST_LINE:
            raise SourceRefused(f"{printable(name)} is no table (a line of more than {LONGEST_LINE:,} characters)")
        yield line
