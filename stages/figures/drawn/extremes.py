"""The map of extremes: a row for every model and parameter, a mark for every value tried."""

from __future__ import annotations

import dataclasses
from collections import Counter

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

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
from stages.twin.parameters import Settings as Twin

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


def draw(given: Given) -> Figure:
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


def caption(given: Given) -> str:
    return f"What every model answers far from the usual parameters: {given.extremes.summary()}."


FIGURE = Entry("The extremes", 60, ("extremes",), draw, caption)
