"""What the difference between the two models is made of: signed contributions that add up to it."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.drawing import style
from stages.error_budget.result import CREEP, IMPACT, SLIP, UNEXPLAINED, Split
from stages.figures.entry import Entry, Given

#: Effects drawn, with colour and line; integration errors are below the width of a line and are left to the caption.
DRAWN = (
    (SLIP, style.SECOND, "-"),
    (CREEP, style.MULTIBODY, "-"),
    (IMPACT, style.ANALYTIC, "-"),
    (UNEXPLAINED, style.MEASURED, "--"),
)
ROWS = (
    ("$x_{hip}$", 0, "[mm]"),
    ("$y_{hip}$", 1, "[mm]"),
    (r"$\dot x_{hip}$", 2, "[mm/s]"),
    (r"$\dot y_{hip}$", 3, "[mm/s]"),
)


def draw(given: Given) -> Figure:
    """Left over one step from the same mid-stance state, right between cycles at equal phase."""
    budget = given.error_budget
    figure, axes = plt.subplots(4, 2, figsize=(style.TWO_COLUMNS, 6.6), sharex="col")
    sides: list[tuple[int, np.ndarray, Split, str, str]] = []
    if budget.step is not None:
        label = "time from the common mid-stance state [s]"
        sides.append((0, budget.step.time, budget.step.split, "one step, same start", label))
    if budget.cycle is not None:
        label = "phase of the stride from heel strike [1]"
        sides.append((1, budget.cycle.phase, budget.cycle.split, "settled cycles, equal phase", label))
    for side, abscissa, split, title, label in sides:
        for row, (name, column, unit) in enumerate(ROWS):
            panel = axes[row, side]
            panel.plot(abscissa, curve(split, split.total, column), color=style.TWIN, linewidth=1.8, label="total")
            for effect, colour, line in DRAWN:
                part = curve(split, split.part(effect), column)
                panel.plot(abscissa, part, line, color=colour, linewidth=1.0, label=effect.replace("v_s", "$v_s$"))
                least, most = (curve(split, end, column) for end in split.interval(effect))
                panel.fill_between(abscissa, least, most, color=colour, alpha=0.3, linewidth=0.0)
            panel.set_ylabel(f"{name} {unit}")
            style.panel_label(panel, "abcdefgh"[2 * row + side])
        axes[0, side].set_title(title)
        axes[-1, side].set_xlabel(label)
    if not sides:
        axes[0, 0].set_title(budget.outcome)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=5)
    return figure


def curve(split: Split, part: np.ndarray, column: int) -> np.ndarray:
    """One component of a part in mm or mm/s; velocities are not drawn where they are not compared."""
    values = 1e3 * part[:, column]
    return values if column < 2 else np.where(split.compared, values, np.nan)


def caption(given: Given) -> str:
    return (
        "Penalty model minus constraint model, split into signed contributions that add up to it; bands reach from one "
        "order to the other in which creep and impact can be switched on; integration errors are too small to draw. "
        f"{given.error_budget.summary()}."
    )


FIGURE = Entry(
    "Error budget", 30, ("error_budget",), draw, caption,
    claims=("hip_displacement", "hip_velocity", "integration_tolerance"),
)  # fmt: skip
