"""A design map: two axes as a map of the largest multiplier, more as all pairs of the axes."""

from collections.abc import Mapping
from itertools import combinations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure

from stages.analytic.maps.answers import STABLE, UNANSWERED, UNSTABLE
from stages.analytic.maps.box import Axis, Box
from stages.drawing import style

#: Colours from stable (blue, below 1) to unstable (red), light at the boundary: distinguished by every colour vision.
COLOURS, NO_GAIT, BOUNDARY = "RdBu_r", "#BDB7AB", "#111111"
#: Multipliers beyond this have the last colour. Cells along an axis of a picture of scattered designs.
LARGEST, CELLS = 2.0, 60
GAITS = (STABLE, UNSTABLE)


def draw(box: Box, columns: Mapping[str, np.ndarray]) -> Figure:
    """The map of `box` from its columns, those of the axes, "outcome", "largest_multiplier" and "period_s"."""
    if len(box.axes) == 1:
        return curve(box.axes[0], columns)
    if len(box.axes) == 2:
        return plane(box, columns)
    return pairs(box, columns)


def label(axis: Axis) -> str:
    """An axis in words, with its unit."""
    name = axis.name.partition(".")[2].removesuffix("_deg").replace("_", " ")
    return f"{name} [{'°' if axis.unit == 'deg' else axis.unit.replace('^2', '²')}]"


def scale(axis: Axis) -> str:
    """Matplotlib's word for how an axis is spread."""
    return "log" if axis.log else "linear"


def walks(columns: Mapping[str, np.ndarray]) -> np.ndarray:
    """Which designs have a gait."""
    return np.isin(columns["outcome"], [int(each) for each in GAITS])


def norm(largest: np.ndarray) -> TwoSlopeNorm:
    """From the least multiplier there is to `LARGEST`, light at 1."""
    least = float(np.nanmin(largest, initial=0.95))
    return TwoSlopeNorm(1.0, min(max(least, 0.0), 0.95), LARGEST)


def curve(axis: Axis, columns: Mapping[str, np.ndarray]) -> Figure:
    """One axis: the largest multiplier and the step frequency along it."""
    figure, panels = plt.subplots(2, 1, figsize=(style.ONE_COLUMN, 3.6), sharex=True)
    order = np.argsort(columns[axis.name])
    along = columns[axis.name][order]
    for panel, values, colour in zip(
        panels, (columns["largest_multiplier"], 1 / columns["period_s"]), (style.MULTIBODY, style.ANALYTIC), strict=True
    ):
        panel.plot(along, values[order], ".-", color=colour, markersize=3)
    panels[0].axhline(1.0, color=BOUNDARY, linewidth=0.6)
    panels[0].set_ylabel("largest multiplier [1]")
    panels[1].set(ylabel="step frequency [Hz]", xlabel=label(axis))
    return figure


def plane(box: Box, columns: Mapping[str, np.ndarray]) -> Figure:
    """Two axes: colour for the largest multiplier, contours of the step frequency, the boundary of stability, and where
    no gait is.
    """
    x, y = (columns[axis.name] for axis in box.axes)
    largest = np.where(walks(columns), columns["largest_multiplier"], np.nan)
    figure, axes = plt.subplots(figsize=(style.TWO_COLUMNS, 5.2))
    axes.set_facecolor(NO_GAIT)
    shades: ScalarMappable
    if box.seed is None:
        across, up = x.reshape(box.shape)[:, 0], y.reshape(box.shape)[0]
        field, rhythm = (values.reshape(box.shape).T for values in (largest, 1 / columns["period_s"]))
        shades = axes.pcolormesh(
            across, up, field, cmap=COLOURS, norm=norm(largest), shading="nearest", rasterized=True)
        lines(axes, across, up, field, rhythm)
    else:
        shades = axes.scatter(x, y, c=largest, s=9, cmap=COLOURS, norm=norm(largest), linewidths=0, rasterized=True)
    axes.set(xlabel=label(box.axes[0]), ylabel=label(box.axes[1]),
             xscale=scale(box.axes[0]), yscale=scale(box.axes[1]))  # fmt: skip
    for axis, ticks in zip(box.axes, (axes.xaxis, axes.yaxis), strict=True):
        if axis.log:
            style.round_ticks(ticks)
    axes.plot([], [], color=BOUNDARY, linewidth=1.6, label="boundary of stability")
    axes.plot([], [], color="#555555", linewidth=0.6, label="step frequency [Hz]")
    unknown = (columns["outcome"] == UNANSWERED).any()
    axes.plot([], [], "s", color=NO_GAIT, label="no gait, or not answered" if unknown else "no gait")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    figure.colorbar(shades, label="largest multiplier [1]", extend="max")
    axes.grid(False)
    return figure


def lines(axes: Axes, across: np.ndarray, up: np.ndarray, field: np.ndarray, rhythm: np.ndarray) -> None:
    """The boundary of stability and contours of the step frequency, where there are any."""
    known = rhythm[np.isfinite(rhythm)]
    if min(field.shape) < 2 or not known.size:
        return
    if known.max() > known.min():
        contours = axes.contour(across, up, np.ma.masked_invalid(rhythm), 8, colors="#555555", linewidths=0.6)
        axes.clabel(contours, fmt="%.3g", fontsize=7)
    if np.nanmin(field) < 1 < np.nanmax(field):
        axes.contour(across, up, np.ma.masked_invalid(field), [1.0], colors=BOUNDARY, linewidths=1.6)


def pairs(box: Box, columns: Mapping[str, np.ndarray]) -> Figure:
    """More axes: for each pair, below the diagonal the share of designs that walk stably, above it the median of the
    largest multiplier among gaits, over all others; on the diagonal both along one axis.
    """
    count = len(box.axes)
    figure, panels = plt.subplots(count, count, figsize=(1.2 + 1.25 * count, 1.4 + 1.2 * count), sharex="col")
    stable, gait = columns["outcome"] == STABLE, walks(columns)
    largest = columns["largest_multiplier"]
    cells = min(int(np.clip(np.sqrt(len(stable) / 20), 4, CELLS)), *(box.shape if box.seed is None else (CELLS,)))
    places = [place(axis, columns[axis.name], cells) for axis in box.axes]
    edges = [axis.at(np.linspace(0, 1, cells + 1)) for axis in box.axes]
    for first, second in combinations(range(count), 2):
        below, above = panels[second, first], panels[first, second]
        cell = places[second] * cells + places[first]
        below.pcolormesh(
            edges[first], edges[second], averaged(stable, cell, cells), cmap="cividis", vmin=0, vmax=1, rasterized=True)
        cell = places[first] * cells + places[second]
        above.set_facecolor(NO_GAIT)
        above.pcolormesh(edges[second], edges[first], middle(largest[gait], cell[gait], cells), cmap=COLOURS,
                         norm=norm(largest), rasterized=True)  # fmt: skip
    for index, axis in enumerate(box.axes):
        diagonal(panels[index, index], edges[index], places[index], stable, gait)
        for row in range(count) if axis.log else ():
            panels[row, index].set_xscale("log")
            style.few_ticks(panels[row, index].xaxis, (axis.low, axis.high), most=2)
            if row != index:
                panels[index, row].set_yscale("log")
                style.few_ticks(panels[index, row].yaxis, (axis.low, axis.high), most=2)
        name = label(axis).replace(" [", "\n[")
        panels[-1, index].set_xlabel(name)
        panels[index, 0].set_ylabel(name if index else "share of\ndesigns [1]")
    for panel in panels.ravel():
        panel.grid(False)
    for panel in panels[:, 1:].ravel():
        panel.tick_params(labelleft=False)
    panels[0, 0].plot([], [], color=style.ANALYTIC, label="walk stably (diagonal: share along one axis)")
    panels[0, 0].plot([], [], color="#777777", linestyle="--", label="have a gait")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    for panel, words, more in ((panels[1, 0], "share that walks stably (below the diagonal) [1]", "neither"),
                               (panels[0, 1], "median of the largest multiplier (above) [1]", "max")):
        figure.colorbar(panel.collections[0], ax=panels, label=words, extend=more, aspect=40)
    return figure


def place(axis: Axis, values: np.ndarray, cells: int) -> np.ndarray:
    """The cell of each value along an axis."""
    edges = axis.at(np.linspace(0, 1, cells + 1))
    return np.clip(np.searchsorted(edges, values, side="right") - 1, 0, cells - 1)


def averaged(values: np.ndarray, cell: np.ndarray, cells: int) -> np.ndarray:
    """Mean of the values in each cell, (cells, cells); NaN in an empty one."""
    many = np.bincount(cell, minlength=cells**2)
    with np.errstate(invalid="ignore"):
        mean: np.ndarray = np.bincount(cell, values, cells**2) / many
    return mean.reshape(cells, cells)


def middle(values: np.ndarray, cell: np.ndarray, cells: int) -> np.ndarray:
    """Median of the values in each cell, (cells, cells); NaN in an empty one."""
    order = np.lexsort((values, cell))
    many = np.bincount(cell, minlength=cells**2)
    starts = np.cumsum(many) - many
    medians = np.full(cells**2, np.nan)
    filled = many > 0
    medians[filled] = values[order][(starts + many // 2)[filled]]
    return medians.reshape(cells, cells)


def diagonal(axes: Axes, edges: np.ndarray, cell: np.ndarray, stable: np.ndarray, gait: np.ndarray) -> None:
    """Along one axis, the share of designs that have a gait and that walk stably."""
    cells, many = len(edges) - 1, np.bincount(cell, minlength=len(edges) - 1)
    with np.errstate(invalid="ignore"):
        for which, colour, line in ((gait, "#777777", "--"), (stable, style.ANALYTIC, "-")):
            axes.stairs(np.bincount(cell, which, cells) / many, edges, color=colour, linestyle=line, baseline=None)
    axes.set_ylim(0, 1.05)
