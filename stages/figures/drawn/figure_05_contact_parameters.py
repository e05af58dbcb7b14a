"""Figure 5: the normal force at heel strike as each contact parameter is changed alone, over the constraint model's."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from stages.biped.walk import Walk
from stages.contact_study.result import Result
from stages.drawing import style
from stages.figures.inputs import Given

TITLE = "Figure 5: contact parameters"
PLACE = 5
INPUTS = ("contact_study", "analytic")
LANDING = 1
CONSTRAINT = "#B8CFE8"  # the constraint model as a broad pale band behind the curves
#: Parameter, its symbol, the unit it is shown in and the factor to that unit.
COLUMNS = (
    ("contact_stiffness", "$k_c$", "$10^5$ N/mm$^e$", 1e-5),
    ("contact_exponent", "$e$", "1", 1.0),
    ("contact_damping", "$c_{max}$", "N s/mm", 1e-3),
    ("damping_depth", "$d$", "mm", 1e3),
)


def constraint_force(walk: Walk) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] from the first heel strike and the force (n, 2) [N] on the foot that lands there; NaN at the jump."""
    strike = float(walk.heel_strike_time[0])
    after = int(np.searchsorted(walk.time, strike, side="right"))
    time = np.insert(walk.time - strike, after, 0.0)
    return time, np.insert(walk.ground_reaction[:, LANDING], after, np.nan, axis=0)


def draw(given: Given) -> Figure:
    """A column for each parameter: the impact, the force after it, and the hip difference over the value."""
    study = given.contact_study
    figure, axes = plt.subplots(
        3, 4, figsize=(style.TWO_COLUMNS, 5.2), sharey="row", height_ratios=(1.2, 1.2, 1.0)
    )
    exact = constraint_force(given.analytic.walk)
    for column, (key, symbol, unit, factor) in enumerate(COLUMNS):
        impact, after, difference = axes[:, column]
        for panel in (impact, after):
            panel.plot(1e3 * exact[0], exact[1][:, 1], color=CONSTRAINT, linewidth=4, label="constraint model")
            panel.plot(1e3 * study.time, study.default_force[:, 1], color="black", label=_value(study, key, factor))
        for row, colour in zip(study.variations.rows(key), style.SEQUENCE):
            label = f"{factor * study.variations.value[row]:g}"
            for panel in (impact, after):
                panel.plot(
                    1e3 * study.time, study.variations.force[row, :, 1], color=colour, linewidth=0.8, label=label
                )
        impact.set_yscale("log")
        impact.set_ylim(1, 1e4)
        impact.set_xlim(-0.8, 1.5)
        after.set_ylim(-1, 40)
        after.set_xlim(0, 40)
        handles, labels = impact.get_legend_handles_labels()
        impact.legend(
            handles[1:], labels[1:], title=f"{symbol} [{unit}]", loc="upper right", ncols=2, fontsize=5.5,
            title_fontsize=6.5, handlelength=0.9, columnspacing=0.6, labelspacing=0.2, borderaxespad=0.1,
        )  # fmt: skip
        _differences(difference, study, key, factor)
        impact.set_xlabel("time from heel strike [ms]")
        after.set_xlabel("time from heel strike [ms]")
        difference.set_xlabel(f"{symbol} [{unit}]")
        for row, panel in enumerate((impact, after, difference)):
            style.panel_label(panel, "abcdefghijkl"[4 * row + column])
    axes[0, 0].set_ylabel("normal force,\nheel strike [N]")
    axes[1, 0].set_ylabel("normal force,\nafter it [N]")
    axes[2, 0].set_ylabel("largest hip\ndifference [mm]")
    figure.legend(
        handles=[
            Line2D([], [], color=CONSTRAINT, linewidth=4, label="constraint model"),
            Line2D([], [], color="black", label="starting set: Adams' defaults"),
        ],
        loc="outside upper center",
        ncols=2,
    )
    return figure


def differences(study: Result, key: str) -> tuple[np.ndarray, np.ndarray]:
    """Values of a parameter, rising, the starting set's among them, and the largest hip differences [m] or NaN."""
    rows = study.variations.rows(key)
    values = np.array([getattr(study.default.law, key), *study.variations.value[rows]])
    found = np.array([study.default.hip_position.max(), *study.variations.hip_position[rows].max(axis=1)])
    order = np.argsort(values)
    return values[order], found[order]


def _differences(axes: Axes, study: Result, key: str, factor: float) -> None:
    values, found = differences(study, key)
    axes.plot(factor * values, 1e3 * found, "o-", color=style.TWIN, markersize=3)
    if key != "contact_exponent":
        axes.set_xscale("log")
    axes.set_yscale("log")
    style.round_ticks(axes.yaxis)


def _value(study: Result, key: str, factor: float) -> str:
    return f"{factor * getattr(study.default.law, key):g}"


def caption(given: Given) -> str:
    study = given.contact_study
    return (
        "Each contact parameter changed alone. From Adams' defaults the hip differs from the constraint model's by "
        f"{1e3 * study.default.hip_position.max():.2f} mm over a step; with the set chosen from "
        f"{len(study.candidates.outcome)} tried, by {1e3 * study.chosen.hip_position.max():.2f} mm."
    )
