"""Tables as CSV, as people open them in a spreadsheet."""

import contextlib
import csv
import io
from collections.abc import Iterable, Sequence

#: How a text begins that a spreadsheet takes for a formula, and may run.
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def table(rows: Iterable[Sequence[object]]) -> str:
    """A CSV text; a number has the digits that give it back, one that is not known is an empty cell."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([_cell(cell) for cell in row] for row in rows)
    return text.getvalue()


def _cell(cell: object) -> object:
    """A cell that stays what it is: a text that would be a formula, as a run's name may be, begins with '."""
    if isinstance(cell, float) and cell != cell:
        return ""
    if isinstance(cell, str) and cell.startswith(_FORMULA) and len(cell) > 1:
        with contextlib.suppress(ValueError):
            float(cell)
            return cell
        return f"'{cell}"
    return cell
