"""What the models cost and where they end: work and precision, and the map of extremes."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.analytic.parameters import Settings as Analytic
from stages.biped.design import Biped
from stages.drawing import style
from stages.extremes.parameters import (
    CRASHED,
    FAILED,
    HUNG,
    INACCURATE,
    REFUSED,
    RIGHT,
    TOGETHER,
    UNCONFIRMED,
    USUAL,
    WRONG,
)
from stages.figures.entry import Entry, Given
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.parameters import Settings as Multibody
from stages.tradeoff.result import ERRORS, Result, Row, front
from stages.twin.parameters import Settings as Twin

# Work and precision: the hip's error of each model over the cost of a step, with the front that nothing beats.

MARKERS = "osD^vP*X<>hd"
COLOURS = (
    style.ANALYTIC,
    style.MULTIBODY,
    style.SECOND,
    style.THIRD,
    style.GROUND,
    style.SEQUENCE[0],
    style.SEQUENCE[2],
    style.MEASURED,
)
#: Errors below this are round-off and drawn at it.
FLOOR = 1e-16
#: Spans of costs and of errors below which ticks are at 1, 2, 5 a decade.
NARROW = (20.0, 100.0)


def draw_tradeoff(given: Given) -> Figure:
    """Errors over evaluations."""
    spent = [row.evaluations for row in given.tradeoff.rows]
    return work_and_precision(given.tradeoff, spent, "evaluations for a step [1]")


def caption_tradeoff(given: Given) -> str:
    return (
        "Error of the hip's position against a converged reference over the cost of a step: "
        f"{given.tradeoff.summary()}. A triangle: an error of at most what the reference itself may be off by, which "
        "is drawn. Errors of period, multiplier and peak force: `bipedstudy show tradeoff`."
    )


def work_and_precision(result: Result, spent: Sequence[float], label: str) -> Figure:
    """The hip's error over what was `spent`, a panel for each model that has a reference of its own."""
    models = [
        reference.model for reference in result.references if math.isfinite(reference.independent_differs.hip_position)
    ]
    columns = min(len(models), 2)
    rows = -(-len(models) // columns)
    size = 0.5 * columns * style.TWO_COLUMNS, 2.3 * rows + 0.5
    figure, grid = plt.subplots(rows, columns, figsize=size, squeeze=False)
    for axes in grid.flat[len(models) :]:
        axes.set_visible(False)  # the others keep their widths, which a phone shows whole
    for model, axes in zip(models, grid.flat):
        pairs = [(row, cost) for row, cost in zip(result.rows, spent) if row.model == model]
        ways = list(dict.fromkeys(row.way for row, _ in pairs))
        panel(axes, pairs, ways, ERRORS[0])
        axes.set(xlabel=label, ylabel="hip error [m]")
        axes.set_title(model, loc="left")
        handles, names = axes.get_legend_handles_labels()
        axes.legend(handles[: len(ways)], names[: len(ways)], loc="upper left", bbox_to_anchor=(1.0, 1.0),
                    handletextpad=0.1, borderaxespad=0.0)  # fmt: skip
    figure.legend(handles[len(ways) :], names[len(ways) :], loc="outside upper center", ncols=2 * columns)
    return figure


def panel(axes: Axes, pairs: Sequence[tuple[Row, float]], ways: Sequence[str], error: str) -> None:
    """One error of one model: a marker a way, the front as a line, the paper's setting ringed, the default boxed."""
    rows, costs = [row for row, _ in pairs], [cost for _, cost in pairs]
    known = [
        (row, cost, max(float(size), FLOOR)) for row, cost in pairs if math.isfinite(size := getattr(row.errors, error))
    ]
    for number, way in enumerate(ways):
        points(
            axes,
            [(cost, size) for row, cost, size in known if row.way == way and row.completed],
            MARKERS[number % len(MARKERS)],
            markersize=3.5,
            color=COLOURS[number % len(COLOURS)],
            label=way,
        )
    best = front(rows, costs, error)
    least = [max(float(getattr(rows[i].errors, error)), FLOOR) for i in best]
    axes.plot(
        [costs[i] for i in best],
        least,
        color=style.TWIN,
        linewidth=0.7,
        zorder=1,
        label="front: nothing is cheaper and as accurate",
    )
    ring = {"markerfacecolor": "none", "markeredgecolor": style.TWIN}
    for mark, shape, width, said in (("paper", "o", 8, "the paper's setting"), ("default", "s", 9, "default here")):
        points(
            axes,
            [(cost, size) for row, cost, size in known if mark in row.mark],
            shape,
            markersize=width,
            markeredgewidth=0.8,
            label=said,
            **ring,
        )
    points(
        axes,
        [(cost, size) for row, cost, size in known if getattr(row.errors, error) <= getattr(row.doubt, error)],
        "v",
        markersize=7,
        markeredgewidth=0.6,
        label="at most that",
        **ring,
    )
    axes.set(xscale="log", yscale="log")
    style.few_ticks(axes.xaxis, [cost for cost in costs if math.isfinite(cost)], NARROW[0], 3)
    style.few_ticks(axes.yaxis, [size for *_, size in known], NARROW[1], 5)


def points(axes: Axes, places: Sequence[tuple[float, float]], mark: str, **look: Any) -> None:
    """A marker at each place; an entry of the legend where there is none."""
    axes.plot(*(zip(*places) if places else ([], [])), mark, **look)


# The map of extremes: a row for every parameter, a column for every model, a bar for every value tried.

#: Status: colour, what a reader is shown. Dark and light take turns, for print in grey.
STATUS = {
    RIGHT: (style.ANALYTIC, "right"),
    INACCURATE: ("#E69F00", "inaccurate, warned"),
    REFUSED: ("#CCCCCC", "refused with a reason"),
    FAILED: ("#000000", "ended early with a reason"),
    UNCONFIRMED: (style.SECOND, "no reference"),
    WRONG: (style.MULTIBODY, "wrong without a sign"),
    CRASHED: (style.THIRD, "crashed"),
    HUNG: (style.SEQUENCE[0], "hung"),
}
#: Units of the axes: of a parameter its own, of others what they are measured in.
UNITS = {f"{kind.FILE}.{field.name}": field.metadata["unit"] for kind in (Biped, Slope, ContactLaw, Analytic, Multibody,
         Twin) for field in dataclasses.fields(kind)}  # fmt: skip
UNITS |= {"leg length": "m", "size, similar": "m", "slope_deg, rigid legs": "deg"}
#: Height of a row [inches], and the share of a cell that its bars fill.
ROW, FILLED = 0.27, 0.88


def draw_extremes(given: Given) -> Figure:
    """Each cell has a bar for each value that was tried, from the lowest on the left to the highest, in the colour of
    what became of it; of draws, where all parameters vary at once, those of one status side by side.
    """
    cells: dict[tuple[str, str], list[tuple[float, str]]] = {}
    for engine, axis, value, status, *_ in given.extremes.rows():
        cells.setdefault((axis, engine), []).append((value, status))
    engines, order = list(dict.fromkeys(engine for _, engine in cells)), list(STATUS)
    axes_of = sorted(dict.fromkeys(axis for axis, _ in cells), key=lambda axis: (axis in (TOGETHER, USUAL), axis))
    figure, panel = plt.subplots(figsize=(style.ONE_COLUMN, 1.9 + ROW * len(axes_of)))
    bars: dict[str, list[tuple[float, float, float]]] = {status: [] for status in order}
    for (axis, engine), found in cells.items():
        found.sort(key=lambda one: (order.index(one[1]), one[0]) if axis == TOGETHER else (0, one[0]))
        wide = FILLED / len(found)
        for number, (_, status) in enumerate(found):
            bars[status].append((engines.index(engine) + number * wide, axes_of.index(axis), 0.9 * wide))
    for status, (colour, words) in STATUS.items():
        if bars[status]:
            left, row, width = zip(*bars[status])
            panel.barh(row, width, 0.7, left=left, color=colour, label=words)
    spans = {axis: [value for (name, _), found in cells.items() if name == axis for value, _ in found if value > 0.0]
             for axis in axes_of}  # fmt: skip
    panel.set_yticks(range(len(axes_of)), [label(axis, spans[axis]) for axis in axes_of])
    panel.set_xticks([number + 0.5 * FILLED for number in range(len(engines))], engines, rotation=60, ha="left",
                     rotation_mode="anchor")  # fmt: skip
    panel.tick_params(axis="x", top=True, bottom=False, labeltop=True, labelbottom=False)
    panel.set(ylim=(len(axes_of) - 0.4, -0.6), xlim=(-0.1, len(engines)))
    panel.grid(visible=False)
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def label(axis: str, span: list[float]) -> str:
    """Axis with its ends and unit; of what has no values its name."""
    if axis in (TOGETHER, USUAL) or not span:
        return axis
    low, high, unit = min(span), max(span), UNITS.get(axis, "1").replace("^2", "²")
    name = axis.removeprefix("biped.").removeprefix("ground.").replace("_deg", "").replace("_", " ").replace(".", " ")
    return f"{name}\n{low:g}{'' if low == high else f' to {high:g}'}{'' if unit == '1' else f' {unit}'}"


def caption_extremes(given: Given) -> str:
    return (
        f"What every model answers far from the usual parameters: {given.extremes.summary()}. A cell has a bar for "
        "each value that was tried, from the lowest on the left to the highest; zero, where it was tried, stands first."
    )


FIGURES = {
    "tradeoff": Entry(
        "Speed against accuracy",
        50,
        ("tradeoff",),
        draw_tradeoff,
        caption_tradeoff,
        claims=("constraints_reduce_effort", "tight_tolerances_add_rounding", "stiff_solver"),
    ),
    "extremes": Entry("The extremes", 60, ("extremes",), draw_extremes, caption_extremes),
}
