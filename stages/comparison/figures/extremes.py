"""The map of extremes: a row for every model and parameter, a mark for every value tried."""

from __future__ import annotations

from collections import Counter

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.comparison.figures import style
from stages.extremes.result import Result
from stages.extremes.verdict import CRASHED, FAILED, HUNG, INACCURATE, REFUSED, RIGHT, UNCONFIRMED, WRONG

NAME = "extremes"

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
DRAWS = "all together"
ROW = 0.155  # inches


def draw(extremes: Result) -> Figure:
    """Panel (a): one parameter varied, the axis scaled from its lowest to its highest value. Panel (b): all varied."""
    rows = list(extremes.rows())
    single = [row for row in rows if row[1] != DRAWS]
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
    panel.set_ylim(len(names) - 0.4, -0.6)
    panel.set_xlim(-0.11, 1.04)
    panel.set_xticks([-0.07, 0.0, 0.5, 1.0], ["0", "lowest", "middle (by ratio)", "highest"])
    panel.grid(axis="y", linewidth=0.3)
    style.panel_label(panel, "a")
    together(bars, rows)
    figure.legend(*panel.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


def scaled(value: float, span: list[float]) -> float:
    """Place of a value between the lowest and the highest of its axis, by ratio; zero stands left of them."""
    if value <= 0.0:
        return -0.07
    low, high = min(span), max(span)
    return 0.5 if low == high else float(np.log(value / low) / np.log(high / low))


def label(axis: str, engine: str, span: list[float]) -> str:
    """Axis with its ends, and the engine."""
    return f"{axis.split('.')[-1].replace('_', ' ')}, {min(span):g} to {max(span):g}: {engine}"


def together(axes: plt.Axes, rows: list[tuple[str, str, float, str, float, float, str, str]]) -> None:
    """Shares of each status where all parameters vary at once, a bar an engine."""
    engines = list(dict.fromkeys(row[0] for row in rows if row[1] == DRAWS))
    for height, engine in enumerate(engines):
        count = Counter(row[3] for row in rows if row[0] == engine and row[1] == DRAWS)
        left, total = 0.0, sum(count.values())
        for status, (colour, _, _) in MARKS.items():
            axes.barh(height, count[status] / total, left=left, color=colour, height=0.6)
            left += count[status] / total
    counts = Counter(row[0] for row in rows if row[1] == DRAWS)
    axes.set_yticks(range(len(engines)), [f"{engine}\n{counts[engine]} draws" for engine in engines])
    axes.set_ylim(max(len(engines), 6) - 0.4, -0.6)
    axes.set_xlim(0.0, 1.0)
    axes.set_xlabel("share of the draws [1]")
    style.panel_label(axes, "b")
