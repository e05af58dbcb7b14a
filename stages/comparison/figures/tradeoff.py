"""Work and precision: four errors of three models over the cost of a step, with the front that nothing beats."""

from __future__ import annotations

import math
from collections.abc import Sequence

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.comparison.figures import style
from stages.tradeoff.result import ERRORS, Result, Row, front

NAME = "tradeoff"
LABELS = ("hip position [m]", "last period [s]", "leading multiplier [1]", "peak force [N]")
MARKERS = "osD^vP*X<>hd"
COLOURS = (style.ANALYTIC, style.MULTIBODY, style.SECOND, style.THIRD, style.GROUND, style.SEQUENCE[0],
           style.SEQUENCE[2], style.MEASURED)
#: Errors below this are round-off and drawn at it.
FLOOR = 1e-16
#: A span of less than this has ticks at 1, 2, 5 a decade.
NARROW = 20.0


def draw(result: Result, costs: Sequence[float] | None = None, label: str = "evaluations for a step [1]") -> Figure:
    """Rows of panels: the models with most ways; columns: the four errors. `costs` default to evaluations."""
    spent = [row.evaluations for row in result.rows] if costs is None else list(costs)
    models = [reference.model for reference in result.references if math.isfinite(
        reference.independent_differs.hip_position)]
    figure, panels = plt.subplots(
        len(models), 4, figsize=(style.TWO_COLUMNS, 2.0 * len(models) + 0.4), squeeze=False, sharex="row")
    for number, (line, model) in enumerate(zip(panels, models, strict=True)):
        pairs = [(row, cost) for row, cost in zip(result.rows, spent) if row.model == model]
        ways = list(dict.fromkeys(row.way for row, _ in pairs))
        for axes, error, title in zip(line, ERRORS, LABELS, strict=True):
            panel(axes, pairs, ways, error)
            axes.set_title(f"error of the\n{title[:title.index('[')].strip()}" if number == 0 else "")
            axes.set_ylabel(title[title.index("["):])
        line[3].legend(*line[0].get_legend_handles_labels(), title=model, loc="center left", fontsize=5.5,
                       bbox_to_anchor=(1.0, 0.5), title_fontsize=6)
    figure.supxlabel(label, fontsize=8)
    return figure


def panel(axes: Axes, pairs: Sequence[tuple[Row, float]], ways: Sequence[str], error: str) -> None:
    """One error of one model: a marker a way, the front as a line, the paper's setting ringed, the default boxed."""
    rows, costs = [row for row, _ in pairs], [cost for _, cost in pairs]

    def value(row: Row) -> float:
        return max(float(getattr(row.errors, error)), FLOOR)

    for number, way in enumerate(ways):
        points = [(cost, value(row)) for row, cost in pairs
                  if row.way == way and row.completed and math.isfinite(getattr(row.errors, error))]
        axes.plot(*(zip(*points) if points else ([], [])), MARKERS[number % len(MARKERS)], markersize=3,
                  color=COLOURS[number % len(COLOURS)], label=way)
    best = front(rows, costs, error)
    axes.plot([costs[i] for i in best], [value(rows[i]) for i in best], color=style.TWIN, linewidth=0.7, zorder=1,
              label="front")
    for mark, shape, size in (("paper", "o", 9), ("default", "s", 10)):
        marked = [(cost, value(row)) for row, cost in pairs if mark in row.mark and math.isfinite(value(row))]
        axes.plot(*(zip(*marked) if marked else ([], [])), shape, markersize=size, markerfacecolor="none",
                  markeredgecolor=style.TWIN, markeredgewidth=0.8, label=f"{mark}'s setting"
                  if mark == "paper" else "this study's default")
    axes.set_xscale("log")
    axes.set_yscale("log")
    known = [cost for cost in costs if math.isfinite(cost)]
    if known and max(known) < NARROW * min(known):
        style.round_ticks(axes.xaxis)
        axes.tick_params(axis="x", labelrotation=60)
    if best and max(values := [value(rows[i]) for i in best]) < NARROW * min(values):
        style.round_ticks(axes.yaxis)
    if not best:
        axes.set_yscale("linear")
        axes.set_yticks([])
        axes.text(0.5, 0.5, "not measured", transform=axes.transAxes, ha="center", fontsize=6)
