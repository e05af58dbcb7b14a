"""Text that fits the terminal: lines folded between words, tables whose cells fold or whose columns go on below.

A word is never broken: a path, a key or an address that is longer than the line stands in a line of its own.
"""

import math
import re
import shutil
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

#: Columns where there is no terminal, and the least that a text is folded to.
_USUAL, _NARROWEST = 80, 60
_GAP = 2
#: Columns of a stage's name: the longest has so many letters.
STAGE = 15
#: A column of words gets so much before it goes on below.
_READABLE = 16
_NUMBER = re.compile(r"[-+]?(\d[\d_]*\.?\d*([eE][-+]?\d+)?|nan|inf)%?|-|none|")


def width() -> int:
    """Columns to write in: those of the terminal, at least 60; 80 where there is none."""
    return max(_NARROWEST, shutil.get_terminal_size((_USUAL, 24)).columns)


def folded(line: str, hang: int | None = None, columns: int | None = None) -> list[str]:
    """A line folded between its words; what follows the first is indented by `hang` (default: 2 more than the line)."""
    indent = len(line) - len(line.lstrip())
    below = " " * (indent + 2 if hang is None else hang)
    return _wrapped(line, columns or width(), below)


def beside(head: str, text: str, columns: int | None = None) -> str:
    """`head`, and beside it `text` folded within what is left of the line."""
    first, *rest = _wrapped(text, (columns or width()) - len(head)) if text else [""]
    return "\n".join([f"{head}{first}".rstrip(), *(" " * len(head) + line for line in rest)])


def table(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> Iterator[str]:
    """The lines of a table: numbers to the right, words folded; columns without room go on below with the first again.

    Where the first column alone does not distinguish the rows and the second does, both stand again.
    """
    body = [[str(head), *(short(row[index]) for row in rows)] for index, head in enumerate(columns)]
    least, room = [_least(*column) for column in body], width() - _GAP
    pairs = {*zip(*(column[1:] for column in body[:2]))}
    together = len(body) > 2 and len({*body[0][1:]}) < len(rows) == len(pairs)
    for number, panel in enumerate(_panels(least, 2 if together else 1, room)):
        if number:
            yield ""
        shown = [body[index] for index in panel]
        sizes = _shared([max(map(len, column)) for column in shown], [least[index] for index in panel], room)
        for row in zip(*shown):
            yield from _row(row, sizes, [_are_numbers(column[1:]) for column in shown])


def _least(head: str, *cells: str) -> int:
    """The smallest width of a column: numbers stand whole, words fold to what can be read."""
    whole = max(map(len, cells), default=0)
    words = max(_longest_word(cells), min(_READABLE, whole))
    return max(_longest_word([head]), whole if _are_numbers(cells) else words)


def _are_numbers(cells: Sequence[str]) -> bool:
    return any(cells) and all(map(_NUMBER.fullmatch, cells))


def titled(title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> list[str]:
    """The lines of a table below an empty line and its title; without rows there is no table."""
    return ["", *folded(title, 0), *(table(columns, rows) if rows else [])]


def markdown(columns: Iterable[Any], rows: Iterable[Iterable[Any]]) -> list[str]:
    """The lines of a table in Markdown."""
    cells = [[" ".join(str(cell).split()).replace("|", "\\|") for cell in row] for row in (columns, *rows)]
    head, *body = ("| " + " | ".join(row) + " |" for row in cells)
    return [head, "| " + " | ".join("---" for _ in cells[0]) + " |", *body]


def short(value: Any) -> str:
    """A value in few digits."""
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(short(item) for item in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _panels(least: Sequence[int], keys: int, room: int) -> list[list[int]]:
    """Which columns stand side by side: all, or the key columns and as many others as fit."""
    if sum(least) + _GAP * (len(least) - 1) <= room:
        return [list(range(len(least)))]
    first = list(range(keys))
    panels: list[list[int]] = []
    for index in range(keys, len(least)):
        together = [*(panels[-1] if panels else first), index]
        if panels and sum(least[each] for each in together) + _GAP * (len(together) - 1) <= room:
            panels[-1] = together
        else:
            panels.append([*first, index])
    return panels or [first]


def _shared(natural: Sequence[int], least: Sequence[int], room: int) -> list[int]:
    """Widths of columns side by side: what each needs, and what is left to those that fold most."""
    sizes = list(least)
    left = room - sum(sizes) - _GAP * (len(sizes) - 1)
    while left > 0:
        most = max(range(len(sizes)), key=lambda index: (math.ceil(natural[index] / max(1, sizes[index])),
                                                         natural[index]))  # fmt: skip
        if natural[most] <= sizes[most]:
            break
        sizes[most] += 1
        left -= 1
    return sizes


def _row(cells: Sequence[str], sizes: Sequence[int], numbers: Sequence[bool]) -> Iterator[str]:
    lines = [_wrapped(cell, size) for cell, size in zip(cells, sizes)]
    for height in range(max(map(len, lines))):
        parts = [column[height] if height < len(column) else "" for column in lines]
        aligned = [f"{part:>{size}}" if number else f"{part:<{size}}"
                   for part, size, number in zip(parts, sizes, numbers)]  # fmt: skip
        yield (" " * _GAP + (" " * _GAP).join(aligned)).rstrip()


def _wrapped(text: str, size: int, below: str = "") -> list[str]:
    return textwrap.wrap(
        text, max(1, size), subsequent_indent=below, break_long_words=False, break_on_hyphens=False
    ) or [""]  # fmt: skip


def _longest_word(texts: Sequence[str]) -> int:
    return max((len(word) for text in texts for word in text.split()), default=0)
