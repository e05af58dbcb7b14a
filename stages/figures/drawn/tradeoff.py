"""Work and precision: four errors of three models over the cost of a step, with the front that nothing beats."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from stages.drawing import style
from stages.figures.entry import Entry, Given
from stages.tradeoff.result import ERRORS, Result, Row, front

LABELS = ("hip position [m]", "period [s]", "multiplier [1]", "peak force [N]")
MARKERS = "osD^vP*X<>hd"
COLOURS = (style.ANALYTIC, style.MULTIBODY, style.SECOND, style.THIRD, style.GROUND, style.SEQUENCE[0],
           style.SEQUENCE[2], style.MEASURED)
#: Errors below this are round-off and drawn at it.
FLOOR = 1e-16
#: Spans of costs and of errors below which ticks are at 1, 2, 5 a decade.
NARROW = (20.0, 100.0)
#: Span of values, greatest over least, that holds too few of 1, 2, 5 a decade.
FEW = 2.5


def draw(given: Given) -> Figure:
    """Errors over evaluations."""
    spent = [row.evaluations for row in given.tradeoff.rows]
    return work_and_precision(given.tradeoff, spent, "evaluations for a step [1]")


def caption(given: Given) -> str:
    return (f"Errors against a converged reference over the cost of a step: {given.tradeoff.summary()}. A triangle: an "
            "error of at most what the reference itself may be off by, which is drawn.")


def work_and_precision(result: Result, spent: Sequence[float], label: str) -> Figure:
    """Rows of panels: the models with most ways; columns: the four errors."""
    models = [reference.model for reference in result.references if math.isfinite(
        reference.independent_differs.hip_position)]
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
        line.legend(handles[:len(ways)], names[:len(ways)], loc="outside lower center", ncols=4, handletextpad=0.1,
                    columnspacing=1.2)
    figure.legend(handles[len(ways):], names[len(ways):], loc="outside upper center", ncols=4)
    figure.supxlabel(label, fontsize=8)
    return figure


def panel(axes: Axes, pairs: Sequence[tuple[Row, float]], ways: Sequence[str], error: str) -> None:
    """One error of one model: a marker a way, the front as a line, the paper's setting ringed, the default boxed."""
    rows, costs = [row for row, _ in pairs], [cost for _, cost in pairs]
    known = [(row, cost, max(float(size), FLOOR)) for row, cost in pairs
             if math.isfinite(size := getattr(row.errors, error))]
    for number, way in enumerate(ways):
        points(axes, [(cost, size) for row, cost, size in known if row.way == way and row.completed],
               MARKERS[number % len(MARKERS)], markersize=3.5, color=COLOURS[number % len(COLOURS)], label=way)
    best = front(rows, costs, error)
    least = [max(float(getattr(rows[i].errors, error)), FLOOR) for i in best]
    axes.plot([costs[i] for i in best], least, color=style.TWIN, linewidth=0.7, zorder=1,
              label="front: nothing is cheaper and as accurate")
    ring = {"markerfacecolor": "none", "markeredgecolor": style.TWIN}
    for mark, shape, width, said in (("paper", "o", 8, "the paper's setting"), ("default", "s", 9, "default here")):
        points(axes, [(cost, size) for row, cost, size in known if mark in row.mark], shape, markersize=width,
               markeredgewidth=0.8, label=said, **ring)
    points(axes, [(cost, size) for row, cost, size in known
                  if getattr(row.errors, error) <= getattr(row.doubt, error)], "v", markersize=7, markeredgewidth=0.6,
           label="at most that", **ring)
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


FIGURE = Entry(
    "Speed against accuracy", 50, ("tradeoff",), draw, caption,
    claims=("constraints_reduce_effort", "tight_tolerances_add_rounding", "stiff_solver"),
)  # fmt: skip
