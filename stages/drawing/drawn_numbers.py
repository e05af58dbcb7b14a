"""The numbers behind a figure: every curve and every set of points in it, as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure

COLUMNS = ("panel", "series", "x", "x label", "y", "y label")
#: Digits that are kept: more than a picture shows.
DIGITS = 9


def as_csv(figure: Figure) -> str:
    """A row for each point of every curve on axes with scales; empty for a figure without any."""
    rows = [row for number, axes in enumerate(figure.get_axes(), 1) if axes.axison for row in _rows(axes, number)]
    if not rows:
        return ""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(rows)
    return text.getvalue()


def _rows(axes: Axes, number: int) -> Iterator[tuple[str, ...]]:
    panel = axes.get_title(loc="left").strip("()") or str(number)
    labels = [label.replace("\n", " ") for label in (axes.get_xlabel(), axes.get_ylabel())]
    for count, (name, points) in enumerate(_series(axes), 1):
        series = str(count) if name.startswith("_") else name
        for x, y in points:
            yield panel, series, f"{x:.{DIGITS}g}", labels[0], f"{y:.{DIGITS}g}", labels[1]


def _series(axes: Axes) -> Iterator[tuple[str, np.ndarray]]:
    """Name and points (n, 2) of what is drawn in the axes' own scales."""
    for line in axes.lines:
        if line.get_transform() == axes.transData:
            x, y = (np.asarray(values) for values in line.get_data(orig=False))
            if x.shape == y.shape:
                yield str(line.get_label()), np.column_stack([np.ravel(x), np.ravel(y)]).astype(float)
    for points in axes.collections:
        if isinstance(points, PathCollection):
            yield str(points.get_label()), np.ma.filled(np.ma.asarray(points.get_offsets(), dtype=float), np.nan)
