"""What the models cost and where they end: work and precision, and the map of extremes."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from stages.analytic.parameters import Settings as Analytic
from stages.biped.design import Biped
from stages.drawing import style
from stages.extremes.engines import (
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

# Work and precision: four errors of three models over the cost of a step, with the front that nothing beats.

LABELS = ("hip position [m]", "period [s]", "multiplier [1]", "peak force [N]")
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
#: Span of values, greatest over least, that holds too few of 1, 2, 5 a decade.
FEW = 2.5


def draw_tradeoff(given: Given) -> Figure:
    """Errors over evaluations."""
    spent = [row.evaluations for row in given.tradeoff.rows]
    return work_and_precision(given.tradeoff, spent, "evaluations for a step [1]")


def caption_tradeoff(given: Given) -> str:
    return (
        f"Errors against a converged reference over the cost of a step: {given.tradeoff.summary()}. A triangle: an "
        "error of at most what the reference itself may be off by, which is drawn."
    )


def work_and_precision(result: Result, spent: Sequence[float], label: str) -> Figure:
    """Rows of panels: the models with most ways; columns: the four errors."""
    models = [
        reference.model for reference in result.references if math.isfinite(reference.independent_differs.hip_position)
    ]
    figure = plt.figure(figsize=(style.TWO_COLUMNS, 2.2 * len(models) + 0.5))
    for model, line in zip(models, figure.subfigures(len(models), 1, squeeze=False)[:, 0], strict=True):
        pairs = [(row, cost) for row, cost in zip(result.rows, spent) if row.model == model]
        ways = list(dict.fromkeys(row.way for row, _ in pairs))
        panels = line.subplots(1, len(ERRORS), sharex=True)
        for axes, error, title in zip(panels, ERRORS, LABELS, strict=True):
            panel(axes, pairs, ways, error)
            axes.set_title(f"error of {title}", fontsize=7)
        line.suptitle(model, fontsize=8, fontweight="bold")
        handles, names = panels[0].get_legend_handles_labels()
        line.legend(
            handles[: len(ways)],
            names[: len(ways)],
            loc="outside lower center",
            ncols=4,
            handletextpad=0.1,
            columnspacing=1.2,
        )
    figure.legend(handles[len(ways) :], names[len(ways) :], loc="outside upper center", ncols=4)
    figure.supxlabel(label, fontsize=8)
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
    ticks(axes.xaxis, [cost for cost in costs if math.isfinite(cost)], NARROW[0], 3)
    ticks(axes.yaxis, least, NARROW[1], 5)
    if not best:
        axes.set(yscale="linear", yticks=[])
        axes.text(0.5, 0.5, "not measured", transform=axes.transAxes, ha="center", fontsize=7)


def points(axes: Axes, places: Sequence[tuple[float, float]], mark: str, **look: Any) -> None:
    """A marker at each place; an entry of the legend where there is none."""
    axes.plot(*(zip(*places) if places else ([], [])), mark, **look)


def ticks(axis: Axis, values: Sequence[float], narrow: float, most: int) -> None:
    """Labels of a logarithmic axis: about `most` at powers of ten; at 1, 2, 5 where values span less than `narrow`."""
    if values and max(values) < narrow * min(values):
        style.round_ticks(axis)
        if max(values) < FEW * min(values):
            axis.set_major_locator(MaxNLocator(most - 1))
    else:
        axis.set_major_locator(LogLocator(numticks=most + 1))
    axis.set_minor_locator(NullLocator())


# The map of extremes: a row for every model and parameter, a mark for every value tried.

#: Status: colour, marker, what a reader is told.
MARKS = {
    RIGHT: (style.ANALYTIC, "o", "right"),
    INACCURATE: ("#E69F00", "^", "inaccurate, and told"),
    REFUSED: ("#BBBBBB", "s", "refused with a reason"),
    FAILED: ("#000000", "x", "ended early with a reason"),
    UNCONFIRMED: (style.SECOND, "P", "no reference"),
    WRONG: (style.MULTIBODY, "*", "wrong without a sign"),
    CRASHED: (style.MULTIBODY, "v", "crashed"),
    HUNG: (style.MULTIBODY, "D", "hung"),
}
#: Units of the axes: of a parameter its own, of others what they are measured in.
UNITS = {f"{kind.FILE}.{field.name}": field.metadata["unit"] for kind in (Biped, Slope, ContactLaw, Analytic, Multibody,
         Twin) for field in dataclasses.fields(kind)}  # fmt: skip
UNITS |= {"leg length": "m", "size, similar": "m", "slope_deg, rigid legs": "deg"}
ROW = 0.135  # inches
#: Where a value of zero stands, left of the lowest.
ZERO = -0.14


def draw_extremes(given: Given) -> Figure:
    """Panel (a): one parameter varied, the axis scaled from its lowest to its highest value. Panel (b): all varied."""
    extremes = given.extremes
    rows = list(extremes.rows())
    single = [row for row in rows if row[1] not in (TOGETHER, USUAL)]
    names = sorted(dict.fromkeys((row[1], row[0]) for row in single), key=lambda name: (name[0], name[1]))
    figure, (panel, bars) = plt.subplots(
        1, 2, figsize=(style.TWO_COLUMNS, 1.1 + ROW * len(names)), width_ratios=(3.2, 1.0)
    )
    spans = {axis: [row[2] for row in single if row[1] == axis and row[2] > 0.0] for axis, _ in names}
    for status, (colour, marker, words) in MARKS.items():
        own = [row for row in single if row[3] == status]
        if status in extremes.status:
            place = [scaled(row[2], spans[row[1]]) for row in own]
            height = [names.index((row[1], row[0])) for row in own]
            panel.plot(place, height, marker, color=colour, markersize=3.6, label=words, linestyle="none")
    panel.set_yticks(range(len(names)), [label(axis, engine, spans[axis]) for axis, engine in names], fontsize=6)
    panel.set(ylim=(len(names) - 0.4, -0.6), xlim=(ZERO - 0.04, 1.04))
    panel.set_xticks([ZERO, 0.0, 0.5, 1.0], ["zero", "lowest", "middle (by ratio)", "highest"])
    panel.grid(axis="y", linewidth=0.3)
    together(bars, rows, len(names))
    style.panel_labels((panel, bars))
    figure.legend(*panel.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


def scaled(value: float, span: list[float]) -> float:
    """Place of a value between the lowest and the highest of its axis, by ratio; zero stands left of them."""
    if value <= 0.0:
        return ZERO
    low, high = min(span), max(span)
    return 0.5 if low == high else float(np.log(value / low) / np.log(high / low))


def label(axis: str, engine: str, span: list[float]) -> str:
    """Axis with its ends and unit, and the engine."""
    low, high = min(span), max(span)
    words = f"{low:g}" if low == high else f"{low:g} to {high:g}"
    unit = UNITS.get(axis, "1")
    name = axis.split(".")[-1].replace("_deg", "").replace("_", " ")
    return f"{name}, {words}{'' if unit == '1' else f' {unit}'}: {engine}"


def together(axes: Axes, rows: list[tuple[str, str, float, str, float, float, str, str]], singles: int) -> None:
    """Shares of each status where all parameters vary at once, a bar an engine, beside so many rows of single ones."""
    engines = list(dict.fromkeys(row[0] for row in rows if row[1] == TOGETHER))
    for height, engine in enumerate(engines):
        count = Counter(row[3] for row in rows if row[0] == engine and row[1] == TOGETHER)
        left, total = 0.0, sum(count.values())
        for status, (colour, _, _) in MARKS.items():
            axes.barh(height, count[status] / total, left=left, color=colour, height=0.6)
            left += count[status] / total
    if not engines:
        axes.text(0.5, 0.0, "none in this map", ha="center", va="center", fontsize=7)
    counts = Counter(row[0] for row in rows if row[1] == TOGETHER)
    axes.set_yticks(range(len(engines)), [f"{engine}\n{counts[engine]} draws" for engine in engines])
    axes.set(ylim=(max(len(engines), singles / 5) - 0.4, -0.6), xlim=(0.0, 1.0), xlabel="share [1]")


def caption_extremes(given: Given) -> str:
    return f"What every model answers far from the usual parameters: {given.extremes.summary()}."


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
