"""One look for all figures: colour-blind-safe, readable in grey, the same bytes from the same data.

A figure has beside it the numbers behind it, every curve, set of points and map, as CSV. It says where it can be cut
into pieces that a phone shows one below the other; a box is left, top, right, bottom.
"""

import io
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from operator import itemgetter
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import PathCollection, QuadMesh
from matplotlib.container import BarContainer
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import FixedLocator, LogLocator, MaxNLocator, NullFormatter, NullLocator, StrMethodFormatter
from matplotlib.transforms import Bbox
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from stages.drawing.csv_table import table

#: Okabe and Ito's palette, one colour a source.
ANALYTIC, MULTIBODY, TWIN, MEASURED, GROUND = "#0072B2", "#D55E00", "#000000", "#999999", "#8C6D46"
SECOND, THIRD = "#009E73", "#CC79A7"
#: Four values of one parameter, from low to high: dark to light, distinct for every kind of colour vision.
SEQUENCE = ("#440154", "#0072B2", "#E69F00", "#D55E00")

ONE_COLUMN, TWO_COLUMNS = 3.5, 7.2  # inches
#: Span of values, greatest over least, that holds too few of 1, 2, 5 a decade.
FEW = 2.5
#: Letters an inch of a strip's text, and height of its lines [inches].
_LETTERS, _LINE = 17, 0.13

RULES: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.labelsize": 8,
    "legend.fontsize": 7,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.linewidth": 0.4,
    "grid.color": "#DDDDDD",
    "axes.axisbelow": True,
    "axes.formatter.limits": (-12, 12),  # a common power of ten would stand on the panel's letter, as an offset would
    "axes.formatter.useoffset": False,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
    "axes.titley": 1.0,  # ticks are below: what looks for room above them takes a fifth of the drawing
    "svg.hashsalt": "bipedstudy",
    "pdf.fonttype": 42,
}


@contextmanager
def drawing() -> Iterator[None]:
    """Draw under the study's rules, whatever the user's own defaults are."""
    with plt.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(RULES)
        yield


def panel_label(axes: Axes, letter: str) -> None:
    """A panel's letter, at its upper left corner outside the axes."""
    axes.set_title(f"({letter})", loc="left", fontweight="bold")


def panel_labels(panels: Iterable[Axes], letters: str = "abcdefghijkl") -> None:
    """The letters of several panels, in their order."""
    for axes, letter in zip(panels, letters):
        panel_label(axes, letter)


def round_ticks(axis: Axis) -> None:
    """Plain numbers 1, 2, 5 a decade on a logarithmic axis: readable where it spans less than a few decades."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def wedge(colour: str, marker: str = "^") -> Line2D:
    """The legend's key to what `mark_beyond` draws."""
    return Line2D([], [], color=colour, marker=marker, markersize=4, linestyle="none", label="beyond the axis")


def mark_beyond(axes: Axes) -> bool:
    """A wedge at the edge wherever a curve leaves through it, in the curve's colour; the limits of the axes must stand.
    Returns whether one does.

    Stretches that are nearer to each other than a fiftieth of the panel have one wedge, over the farthest point.
    """
    (left, right), found = axes.get_xlim(), False
    for edge, sign, wedge in zip(axes.get_ylim(), (-1.0, 1.0), ("v", "^"), strict=True):
        for line in [each for each in axes.lines if each.get_transform() == axes.transData]:
            x, y = np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)
            beyond = np.flatnonzero((sign * (y - edge) > 0.0) & (left <= x) & (x <= right))
            stretches = np.split(beyond, np.flatnonzero(np.diff(x[beyond]) > 0.02 * (right - left)) + 1)
            places = [x[each[np.argmax(sign * y[each])]] for each in stretches if len(each)]
            found |= bool(places)
            axes.plot(places, [float(sign > 0.0)] * len(places), wedge, color=line.get_color(), markersize=4,
                      clip_on=False, transform=axes.get_xaxis_transform(), label="_beyond", zorder=4, in_layout=False)
    return found


def few_ticks(axis: Axis, values: Sequence[float], narrow: float = 20.0, most: int = 3) -> None:
    """Labels of a logarithmic axis: about `most` at powers of ten; at 1, 2, 5 where values span less than `narrow`."""
    if len(values) and max(values) < narrow * min(values):
        round_ticks(axis)
        if max(values) < FEW * min(values):
            axis.set_major_locator(MaxNLocator(max(most - 1, 2)))
        elif most < 3:
            axis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    else:
        axis.set_major_locator(LogLocator(numticks=most + 1))
    axis.set_minor_locator(NullLocator())


@contextmanager
def laid_out(figure: Figure, dpi: int) -> Iterator[None]:
    """Lay a figure out once, for this resolution: as often as it is saved inside, it is only drawn.

    Saving alone would lay it out as well, and for that draw it twice, each time.
    """
    figure.dpi = dpi
    engine = figure.get_layout_engine()
    with plt.rc_context({"figure.constrained_layout.use": False}):
        if engine is not None:
            for _ in range(1 + any(axes.get_aspect() != "auto" for axes in figure.get_axes())):
                engine.execute(figure)  # once more where equal scales leave a panel another height than was planned
            for part in figure.subfigs:  # the solver's last digit is not the same twice
                part.bbox_relative.set_points(np.round(part.bbox_relative.get_points(), 9))
            for axes in figure.get_axes():
                place: Any = axes.get_position(original=True)
                axes.set_position(Bbox(np.round(place.get_points(), 9)), which="original")
        figure.set_layout_engine(None)
        yield


def in_few_colours(picture: Image.Image, pieces: str = "") -> bytes:
    """A picture as PNG with the 256 colours that fit it best: a quarter of the size, and no difference to be seen.

    It says which Matplotlib drew it, as each sets text in its own way, and its `pieces` for a narrow page.
    """
    buffer, about = io.BytesIO(), PngInfo()
    about.add_text("Software", f"Matplotlib {matplotlib.__version__}")
    if pieces:
        about.add_text("pieces", pieces)
    few = picture.convert("RGB").quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    few.save(buffer, "png", compress_level=6, pnginfo=about)
    return buffer.getvalue()


def with_strip(figure: Figure, said: str) -> Bbox:
    """Put words on a strip above a figure that is laid out; the box [inches] that holds both."""
    width, height = figure.get_size_inches()
    lines = textwrap.wrap(said, int(width * _LETTERS), break_on_hyphens=False)
    top = 1.0 + _LINE * (len(lines) + 0.8) / height
    strip = Rectangle((0.0, 1.0), 1.0, top - 1.0, transform=figure.transFigure, color="#FFE8A3", clip_on=False)
    figure.add_artist(strip)
    for legend in figure.legends:  # else they would move to the edge of the box
        place = legend.get_bbox_to_anchor().transformed(figure.transFigure.inverted())
        legend.set_bbox_to_anchor(place, figure.transFigure)
    figure.text(0.01, 0.5 * (1.0 + top), "\n".join(lines), fontsize=7, ha="left", va="center")
    return Bbox([[0.0, 0.0], [width, height * top]])


def pictures(name: str, figure: Figure, dpi: int, *, pdf: bool = True, said: str = "") -> dict[str, bytes]:
    """The figure as PNG and, if wanted, PDF, and its numbers as CSV, keyed by the path relative to the results folder;
    closes the figure. What is `said` of it stands on a strip above.
    """
    files = {}
    numbers = as_csv(figure)
    if numbers:
        files[f"figures/{name}.csv"] = numbers.encode()
    with laid_out(figure, dpi):
        box, buffer = with_strip(figure, said) if said else None, io.BytesIO()
        figure.savefig(buffer, format="png" if said else "rgba", dpi=dpi, bbox_inches=box)
        size = figure.canvas.get_width_height()
        drawn = Image.open(buffer) if said else Image.frombytes("RGBA", size, buffer.getvalue())
        files[f"figures/{name}.png"] = in_few_colours(drawn, "" if said else pieces(figure))
        if pdf:
            buffer = io.BytesIO()
            nameless = {"CreationDate": None, "Producer": None, "Creator": None}
            figure.savefig(buffer, format="pdf", dpi=dpi, metadata=nameless, bbox_inches=box)
            files[f"figures/{name}.pdf"] = buffer.getvalue()
    plt.close(figure)
    return files


#: Width that a piece may have, about what a phone shows at the size of print, and the empty edge around it [inches];
#: room of a legend's handle before its words, in their size.
PHONE, EDGE, HANDLE = 3.6, 0.04, 3.0
Box = tuple[float, float, float, float]


def pieces(figure: Figure) -> str:
    """The size of a figure that was drawn, then left, top, width and height of its pieces [inches], as words."""
    (width, height), dpi = figure.get_size_inches(), figure.dpi
    found = [[width, height]]
    for group in whole_parts(figure):
        boxes = [(box.x0 / dpi, height - box.y1 / dpi, box.x1 / dpi, height - box.y0 / dpi) for box in group]
        found += [[left - EDGE, top - EDGE, right - left + 2 * EDGE, bottom - top + 2 * EDGE]
                  for left, top, right, bottom in (cut(boxes) if boxes else ())]  # fmt: skip
    return "; ".join(" ".join(f"{value:.3f}" for value in box) for box in found) + ";"


def whole_parts(figure: Figure) -> list[list[Bbox]]:
    """What must stay whole [pixels]: entries of each legend; then axes with their labels and colour bars, and words."""
    bars = {axes: [one.colorbar.ax for one in (*axes.images, *axes.collections) if one.colorbar is not None]
            for axes in figure.get_axes()}  # fmt: skip
    apart = [axes for axes in bars if axes.get_visible() and not any(axes in own for own in bars.values())]
    legends: list[list[Bbox]] = []
    found = [Bbox.union([box for one in (axes, *bars[axes]) if (box := one.get_tightbbox()) is not None])
             for axes in apart]  # fmt: skip
    for level in (figure, *figure.subfigs):
        found += [text.get_window_extent() for text in level.texts if text.get_text()]
        for legend in level.legends:
            room = HANDLE * legend.prop.get_size_in_points() / 72.0 * figure.dpi
            entries = [text.get_window_extent() for text in legend.get_texts()]
            legends.append([Bbox([[box.x0 - room, box.y0], [box.x1, box.y1]]) for box in entries])
    return [*legends, found]


def cut(boxes: list[Box]) -> list[Box]:
    """The pieces of boxes as they are read: columns, as many together as fit; rows where there are no columns."""
    left, top, right, bottom = zip(*boxes, strict=True)
    for axis in (0, 1) if max(right) - min(left) > PHONE else ():
        groups: list[list[Box]] = []
        for run in runs(boxes, axis):
            both = [*(groups[-1] if groups else ()), *run]
            narrow = max(box[2] for box in both) - min(box[0] for box in both) <= PHONE
            if groups and (narrow if axis == 0 else len(runs(both, 0)) > 1):
                groups[-1] = both
            else:
                groups.append(run)
        if len(groups) > 1:
            return [piece for group in groups for piece in cut(group)]
    return [(min(left), min(top), max(right), max(bottom))]


def runs(boxes: list[Box], axis: int) -> list[list[Box]]:
    """Boxes in groups that do not overlap, from left to right (axis 0) or from top to bottom (1)."""
    groups: list[list[Box]] = []
    for box in sorted(boxes, key=itemgetter(axis)):
        if groups and box[axis] < max(each[axis + 2] for each in groups[-1]):
            groups[-1].append(box)
        else:
            groups.append([box])
    return groups


COLUMNS = ("panel", "series", "x", "y")
#: Digits that are kept: more than a picture shows.
NUMBER = "%.6g"


def as_csv(figure: Figure) -> str:
    """A row for each point that is shown of every curve, below lines with # that say what x and y are; "" if none."""
    panels = {name: axes for name, axes in _panels(figure) if axes.axison}
    rows = [row for name, axes in panels.items() for row in _rows(name, axes)]
    if not rows:
        return ""
    text = ""
    for name, axes in panels.items():
        x, y = (" ".join(label.split()) for label in (axes.get_xlabel(), axes.get_ylabel()))
        text += f"# panel {name}: x: {x or 'as below'}; y: {y or 'as beside'}\n"
    return text + table([COLUMNS, *rows])


def _panels(figure: Figure) -> Iterator[tuple[str, Axes]]:
    """Axes by their letters, or by their numbers."""
    for number, axes in enumerate(figure.get_axes(), 1):
        yield axes.get_title(loc="left").strip("()") or str(number), axes


def _rows(panel: str, axes: Axes) -> Iterator[tuple[str, str, str, str]]:
    """The rows of each series, in the order of `COLUMNS`."""
    low, high = sorted(axes.get_xlim())
    places = _words(axes)
    for count, (name, points) in enumerate(_series(axes), 1):
        series = str(count) if name.startswith("_") else name
        shown = points[(points[:, 0] >= low) & (points[:, 0] <= high)].tolist()
        yield from ((panel, series, NUMBER % x, places.get(y, NUMBER % y)) for x, y in shown)


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
