"""What the difference between the two models is made of, in one look: signed bars that add up to the total."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.drawing import style
from stages.error_budget.result import (
    CREEP,
    EFFECTS,
    IMPACT,
    INTEGRATION_CONSTRAINT,
    INTEGRATION_PENALTY,
    POSITION,
    SLIP,
    UNEXPLAINED,
    Result,
    Split,
)
from stages.figures.entry import Entry, Given

#: Rows from above: what a reader is told, the contributions that it adds up, its colour.
ROWS = (
    ("trailing foot slips", (SLIP,), style.SECOND),
    ("feet creep below $v_s$", (CREEP,), style.MULTIBODY),
    ("impact of finite stiffness", (IMPACT,), style.ANALYTIC),
    ("integration", (INTEGRATION_CONSTRAINT, INTEGRATION_PENALTY), style.THIRD),
    ("unexplained", (UNEXPLAINED,), style.MEASURED),
)
#: Bars shorter than this part of the axis get a black line, or they could not be seen.
THIN = 0.004


def along(split: Split) -> np.ndarray:
    """What each contribution has of the rms displacement in both orders, (2, 6) [m]."""
    return np.array([[split.along(part, POSITION) for part in parts] for parts in split.orders])


def measures(budget: Result) -> list[tuple[str, np.ndarray]]:
    """Label of each panel, and the contributions in both orders, (2, 6), in its unit."""
    found = []
    if budget.step is not None:
        split = budget.step.split
        found.append(("one step: hip x at its end [mm]", 1e3 * split.orders[:, :, -1, 0]))
        found.append(("one step: hip, rms [mm]", 1e3 * along(split)))
    if budget.cycle is not None:
        found.append(("cycles: period of a step [ms]", 1e3 * budget.cycle.scalar_orders[:, :, 0]))
        found.append(("cycles: length of a step [mm]", 1e3 * budget.cycle.scalar_orders[:, :, 1]))
        found.append(("cycles: hip, rms over a stride [mm]", 1e3 * along(budget.cycle.split)))
    return found


def draw(given: Given) -> Figure:
    """A panel for each measure, with a bar for each effect and one for their sum."""
    shown = measures(given.error_budget)
    figure, axes = plt.subplots(
        max(len(shown), 1), 1, figsize=(style.ONE_COLUMN, 0.3 + 1.16 * max(len(shown), 1)), squeeze=False
    )
    for panel, (label, ways), letter in zip(axes[:, 0], shown, "abcde"):
        bars(panel, ways)
        panel.set_xlabel(f"({letter}) {label}", labelpad=1.0)
    if not shown:
        axes[0, 0].set_title(given.error_budget.outcome)
    return figure


def bars(panel: Axes, ways: np.ndarray) -> None:
    """Means of both orders with their intervals; `ways` (2, 6). The values stand in a column beside the bars."""
    values = [ways[:, [EFFECTS.index(name) for name in names]].sum(axis=1) for _, names, _ in ROWS]
    values.append(ways.sum(axis=1))
    low, high = min(0.0, *map(np.min, values)), max(0.0, *map(np.max, values))
    span = max(high - low, 1e-12)
    panel.set_xlim(low - 0.05 * span, high + 0.05 * span)
    panel.axvline(0.0, color=style.TWIN, linewidth=0.6)
    colours = [colour for *_, colour in ROWS] + [style.TWIN]
    for row, (both, colour) in enumerate(zip(values, colours)):
        mean, half = float(both.mean()), 0.5 * float(np.ptp(both))
        panel.barh(row, mean, height=0.66, color=colour)
        if abs(mean) < THIN * span:
            panel.plot([mean, mean], [row - 0.33, row + 0.33], color=style.TWIN, linewidth=0.8)
        words = f"{mean:+.2f}".replace("-", "\u2212") if abs(mean) >= 5e-3 else "  0.00"
        if half >= 5e-3:
            panel.errorbar(mean, row, xerr=half, color=style.TWIN, linewidth=0.8, capsize=2.0)
            words += f" \u00b1 {half:.2f}"
        panel.text(1.02, row, words, va="center", ha="left", fontsize=6.5, transform=panel.get_yaxis_transform())
    panel.set_yticks(range(len(values)), [*(name for name, *_ in ROWS), "total"], fontsize=6.5)
    panel.get_yticklabels()[-1].set_fontweight("bold")
    panel.set_ylim(len(values) - 0.5, -0.5)
    panel.tick_params(axis="y", length=0)
    panel.tick_params(axis="x", labelsize=6.5, pad=1.5)
    panel.grid(axis="y", visible=False)


def caption(given: Given) -> str:
    said = [
        f"over {name} the hips differ by {1e3 * split.rms(split.total, POSITION):.2f} mm rms, of which "
        f"{1e3 * split.rms(split.part(UNEXPLAINED), POSITION):.3f} mm rms are left"
        for name, split in ((name, budget.split) for name, budget in given.error_budget.known())
    ]
    return (
        "Penalty model minus constraint model. Bars add up to the total; of an rms each effect has its part along the "
        "whole difference. Creep and impact act on each other: bars are the mean of both orders in which they can be "
        f"switched on, whiskers reach to each. {'; '.join(said) or given.error_budget.outcome}."
    )


FIGURE = Entry(
    "What the difference is made of", 29, ("error_budget",), draw, caption,
    claims=("hip_displacement", "integration_tolerance"),
)  # fmt: skip
