"""The numbers behind a figure: every curve, every set of points and every map in it, as CSV."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection, QuadMesh
from matplotlib.container import BarContainer
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from stages.drawing.csv_table import table

COLUMNS = ("panel", "series", "x", "y")
#: Digits that are kept: more than a picture shows.
NUMBER = "%.6g"


def as_csv(figure: Figure) -> str:
    """A row for each point that is shown of every curve, below lines with # that say what x and y are; "" if none."""
    panels = {name: axes for name, axes in _panels(figure) if axes.axison}
    rows = "".join(text for name, axes in panels.items() for text in _rows(name, axes))
    if not rows:
        return ""
    text = ""
    for name, axes in panels.items():
        x, y = (" ".join(label.split()) for label in (axes.get_xlabel(), axes.get_ylabel()))
        text += f"# panel {name}: x: {x or 'as below'}; y: {y or 'as beside'}\n"
    return text + _line(*COLUMNS) + rows


def _line(*words: str) -> str:
    return table([words])


def _panels(figure: Figure) -> Iterator[tuple[str, Axes]]:
    """Axes by their letters, or by their numbers."""
    for number, axes in enumerate(figure.get_axes(), 1):
        yield axes.get_title(loc="left").strip("()") or str(number), axes


def _rows(panel: str, axes: Axes) -> Iterator[str]:
    """The rows of each series: many thousand points may be, so that numbers are written at one go."""
    low, high = sorted(axes.get_xlim())
    places = _words(axes)
    for count, (name, points) in enumerate(_series(axes), 1):
        series = str(count) if name.startswith("_") else name
        shown = points[(points[:, 0] >= low) & (points[:, 0] <= high)].tolist()
        if places:
            yield from (_line(panel, series, NUMBER % x, places.get(y, NUMBER % y)) for x, y in shown)
        else:
            begin = _line(panel, series)[:-1].replace("%", "%%")
            yield f"{begin},{NUMBER},{NUMBER}\n" * len(shown) % tuple(chain.from_iterable(shown))


def _words(axes: Axes) -> dict[float, str]:
    """What stands at places of a vertical axis of words."""
    if not isinstance(axes.yaxis.get_major_locator(), FixedLocator):
        return {}
    words = [" ".join(label.get_text().split()) for label in axes.get_yticklabels()]
    return {place: word for place, word in zip(map(float, axes.get_yticks()), words, strict=False)
            if any(sign.isalpha() for sign in word)}  # fmt: skip


def _series(axes: Axes) -> Iterator[tuple[str, np.ndarray]]:
    """Name and points (n, 2) of what is drawn in the axes' own scales."""
    for line in axes.lines:
        if line.get_transform() == axes.transData:
            x, y = (np.asarray(values) for values in line.get_data(orig=False))
            if x.shape == y.shape:
                yield str(line.get_label()), np.column_stack([np.ravel(x), np.ravel(y)]).astype(float)
    for bars in axes.containers:
        if isinstance(bars, BarContainer):
            ends = [(one.get_x() + one.get_width(), one.get_y() + 0.5 * one.get_height())
                    if bars.orientation == "horizontal" else (one.get_x() + 0.5 * one.get_width(), one.get_height())
                    for one in bars.patches]  # fmt: skip
            yield f"{bars.get_label()}, ends of bars", np.array(ends).reshape(-1, 2)
    for points in axes.collections:
        if isinstance(points, PathCollection):
            yield str(points.get_label()), np.ma.filled(np.ma.asarray(points.get_offsets(), dtype=float), np.nan)
        elif isinstance(points, QuadMesh):
            yield from _cells(points)


def _cells(mesh: QuadMesh) -> Iterator[tuple[str, np.ndarray]]:
    """The middles (n, 2) of a map's cells, a series for each value that cells have."""
    corners = np.asarray(mesh.get_coordinates())
    middles = 0.25 * (corners[1:, 1:] + corners[1:, :-1] + corners[:-1, 1:] + corners[:-1, :-1])
    values: np.ndarray = np.ma.filled(np.ma.asarray(mesh.get_array(), dtype=float), np.nan)
    for value in np.unique(values[np.isfinite(values)]):
        yield f"{mesh.get_label()}: {value:g}", middles[values == value]
