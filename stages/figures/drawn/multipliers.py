"""What a step leaves of a disturbance in each model, and how the gait answers to its parameters."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.drawing import style
from stages.figures.entry import Entry, Given

#: Multipliers smaller than this are not told from zero.
NONE = 1e-6
MEASURES = (("period", style.MULTIBODY), ("step_length", style.SECOND), ("speed", style.ANALYTIC))


def multipliers(given: Given) -> list[tuple[str, np.ndarray, str, str]]:
    """Model, its multipliers (k, 2) [1], and colour and marker."""
    found = [
        ("constraint model", given.analytic.gait.floquet_multipliers, style.ANALYTIC, "o"),
        ("penalty contact", given.multibody.cycle.floquet_multipliers, style.MULTIBODY, "s"),
    ]
    twin = next((rung for rung in given.twin_ladder.rungs if rung.is_twin and rung.found), None)
    if twin is not None:
        found.append(("twin, in the plane", twin.plane_multipliers, style.TWIN, "^"))
        found.append(("twin, across it", twin.side_multipliers, style.MEASURED, "v"))
    return [(name, values[np.hypot(*values.T) > NONE], *look) for name, values, *look in found]


def draw(given: Given) -> Figure:
    """The unit circle with the multipliers of a step, and bars for the elasticities."""
    figure, (circle, bars) = plt.subplots(1, 2, figsize=(style.TWO_COLUMNS, 3.0), width_ratios=(1.0, 1.25))
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    circle.plot(np.cos(turn), np.sin(turn), color="black", linewidth=0.8, label="limit of stability")
    for name, values, colour, mark in multipliers(given):
        circle.plot(values[:, 0], values[:, 1], mark, color=colour, markersize=4.5, markerfacecolor="none", label=name)
    circle.set(aspect="equal", xlabel="real part [1]", ylabel="imaginary part [1]", ylim=(-1.1, 1.65),
               yticks=(-1.0, -0.5, 0.0, 0.5, 1.0))
    circle.legend(loc="upper center", ncols=2, columnspacing=1.0, handlelength=1.2)
    elasticities(bars, given)
    style.panel_labels((circle, bars))
    return figure


def elasticities(axes: Axes, given: Given) -> None:
    """Elasticities of the constraint model's gait, a group of bars for each parameter that is not zero."""
    rows = [row for row in given.analytic.elasticities if row.value]
    places = np.arange(len(rows))
    for number, (measure, colour) in enumerate(MEASURES):
        values = [getattr(row, measure) for row in rows]
        axes.barh(places + 0.26 * (number - 1), values, height=0.24, color=colour, label=measure.replace("_", " "))
    axes.axvline(0.0, color="black", linewidth=0.6)
    axes.set_yticks(places, [row.parameter.partition(".")[2].removesuffix("_deg").replace("_", " ") for row in rows])
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("change for 1 % of the parameter [%]")
    axes.legend(loc="best")


def caption(given: Given) -> str:
    largest = [(name, float(np.hypot(*values.T).max())) for name, values, *_ in multipliers(given)
               if len(values) and not name.endswith("across it")]  # fmt: skip
    told = ", ".join(f"{value:.3f} ({name})" for name, value in largest)
    text = f"Floquet multipliers of a step; the largest: {told}. Inside the circle a disturbance dies out."
    rows = [row for row in given.analytic.elasticities if row.value]
    if not rows:
        return text
    most = max(rows, key=lambda row: abs(row.speed))
    return (
        f"{text} Elasticities of the constraint model are exact derivatives; its speed answers most to "
        f"{most.parameter}, by {most.speed:+.2f} % for 1 %."
    )


FIGURE = Entry(
    "Multipliers and elasticities", 21, ("analytic", "multibody", "twin_ladder"), draw, caption,
    claims=("stable_gait", "multipliers_minimised", "chaos_amplifies"),
)  # fmt: skip
