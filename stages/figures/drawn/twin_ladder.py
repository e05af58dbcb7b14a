"""From the simple model to the twin: what each detail adds to a step's period and length, and to its multipliers.

Beside each machine the constraint model of the same machine: what is left between the two is contact.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.drawing import style
from stages.figures.entry import Entry, Given
from stages.twin_ladder.result import Result, RungGait

SIMPLE = "constraint model"
SLOWER, QUICKER = style.MULTIBODY, style.ANALYTIC
#: Bars shorter than this part of the axis get a black line, or they could not be seen.
THIN = 0.004
#: Where the wedges stand, from the row before: below the bar, beside which its change is written.
BELOW = 1.38


def draw(given: Given) -> Figure:
    """Waterfalls of period and step length, and the largest multipliers of each rung."""
    ladder = given.twin_ladder
    rungs = [rung for rung in ladder.rungs if rung.found]
    figure, panels = plt.subplots(1, 3, figsize=(style.TWO_COLUMNS, 3.4), sharey=True, width_ratios=(1.1, 1.1, 1.0))
    changes = ladder.changes()
    waterfall(panels[0], 1e3 * ladder.simple_period_s, [1e3 * change for _, change, _ in changes])
    waterfall(panels[1], 1e3 * ladder.simple_step_length_m, [1e3 * change for *_, change in changes])
    multipliers(panels[2], rungs)
    same_machine(panels, ladder)
    names = [SIMPLE, *(rung.name + (" = the twin" if rung.is_twin else "") for rung in rungs)]
    panels[0].set_yticks(range(len(names)), [textwrap.fill(name, 22) for name in names])
    panels[0].set_ylim(len(names) - 0.4, -0.6)
    for axes, label in zip(panels, ("period of a step [ms]", "length of a step [mm]", "multipliers of a step [1]")):
        axes.set_xlabel(label)
    style.panel_labels(panels)
    figure.legend(*panels[2].get_legend_handles_labels(), loc="outside upper center", ncols=3)  # bars may be anywhere
    return figure


def waterfall(axes: Axes, first: float, changes: list[float]) -> None:
    """The first value as a dot, then a bar from level to level for each change, written beside it."""
    levels = first + np.cumsum([0.0, *changes])
    low, high = levels.min(), levels.max()
    span = max(high - low, 1e-9)
    axes.set_xlim(low - 0.45 * span, high + 0.45 * span)
    axes.plot(first, 0, "o", color=style.TWIN, markersize=4)
    axes.text(first + 0.04 * span, 0, f"{first:.1f}", va="center", ha="left", fontsize=6.5)
    for row, change in enumerate(changes, 1):
        begin, end = levels[row - 1], levels[row]
        colour = SLOWER if change > 0 else QUICKER
        axes.plot([begin, begin], [row - 1, row], color=style.MEASURED, linewidth=0.6)
        axes.barh(row, change, left=begin, height=0.55, color=colour)
        if abs(change) < THIN * span:
            axes.plot([end, end], [row - 0.275, row + 0.275], color=style.TWIN, linewidth=1.0)
        ahead = change >= 0
        place = max(begin, end) + 0.04 * span if ahead else min(begin, end) - 0.04 * span
        words = f"{change:+.2f}" if abs(change) >= 5e-3 else "0.00"
        axes.text(place, row, words, va="center", ha="left" if ahead else "right", fontsize=6.5)


def same_machine(panels: Sequence[Axes], ladder: Result) -> None:
    """Wedges below the bars point at the constraint model of each rung's own machine."""
    rows = [rung.name for rung in ladder.rungs if rung.found]
    name = "constraint model of the same machine"
    for rung, own in ladder.left():
        row = rows.index(rung.name) + BELOW
        values = np.array([1e3 * own.period_s]), np.array([1e3 * own.step_length_m]), own.multipliers[:, 0]
        for axes, places in zip(panels, values, strict=True):
            axes.plot(places, [row] * len(places), "^", color=style.TWIN, markersize=3.5, label=name)
        name = "_"  # said once


def multipliers(axes: Axes, rungs: list[RungGait]) -> None:
    """Real parts of the two largest in the plane and of the largest out of it; the limits of stability dashed."""
    rows = np.arange(1, len(rungs) + 1)
    for limit in (-1.0, 1.0):
        axes.axvline(limit, color=style.TWIN, linewidth=0.7, linestyle="--")
    for number in (0, 1):
        values = [rung.plane_multipliers[number, 0] for rung in rungs]
        name = "two largest in the plane" if number == 0 else None
        axes.plot(values, rows, "o", color=style.MULTIBODY, markersize=4, label=name)
    sideways = [(rung.side_multipliers[0, 0], row) for rung, row in zip(rungs, rows, strict=True)
                if len(rung.side_multipliers)]  # fmt: skip
    if sideways:
        axes.plot(*zip(*sideways, strict=True), "D", color=style.SECOND, markersize=3.5, label="largest out of it: yaw")
    axes.set_xlim(-1.2, 1.2)


def caption(given: Given) -> str:
    beside = " Wedges: the constraint model of the same machine." if given.twin_ladder.left() else ""
    return f"What each detail does to a step: {given.twin_ladder.summary()}.{beside}"


FIGURE = Entry(
    "From the simple model to the twin", 20, ("twin_ladder",), draw, caption,
    claims=("twin_like_simple", "outsole_slows"),
)  # fmt: skip
