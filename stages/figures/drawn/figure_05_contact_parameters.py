"""Figure 5: the normal force at heel strike as each contact parameter is changed alone, over the constraint model's."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from stages.biped.accuracy.scales import scales_of
from stages.biped.walk import Walk
from stages.contact_study.result import Result
from stages.drawing import style
from stages.figures.entry import Entry, Given

LANDING = 1
CHOSEN, LIMIT = style.MULTIBODY, style.SECOND
VALUES = (*style.SEQUENCE[:3], style.THIRD)  # from low to high; the last of the sequence is the chosen set's colour
CONSTRAINT = "#B8CFE8"  # the constraint model as a broad pale band behind the curves
#: Parameter, its symbol, the unit it is shown in and the factor to that unit.
ROWS = (
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
    """A row for each parameter: the impact, the force after it, and the hip difference over the value."""
    study, scales = given.contact_study, scales_of(given.parameters.biped, given.parameters.slope.gravity)
    milliseconds, weight = 1e3 * scales.time, scales.size("N")
    figure, axes = plt.subplots(4, 3, figsize=(style.TWO_COLUMNS, 8.8), sharey="col", width_ratios=(1.1, 1.1, 0.9))
    exact = constraint_force(given.analytic.walk)
    for row, (key, symbol, unit, factor) in enumerate(ROWS):
        impact, after, difference = axes[row]
        for panel in (impact, after):
            panel.plot(1e3 * exact[0], exact[1][:, 1], color=CONSTRAINT, linewidth=4)
            panel.plot(1e3 * study.time, study.default_force[:, 1], color="black", label=_value(study, key, factor))
        for variation, colour in zip(study.variations.rows(key), VALUES):
            label = f"{factor * study.variations.value[variation]:g}"
            force = study.variations.force[variation, :, 1]
            for panel in (impact, after):
                panel.plot(1e3 * study.time, force, color=colour, linewidth=0.8, label=label)
        for panel in (impact, after):
            panel.plot(1e3 * study.time, study.chosen_force[:, 1], "--", color=CHOSEN, linewidth=1.2)
        impact.legend(title=f"{symbol} [{unit}]", loc="upper right", handlelength=1.2, labelspacing=0.3)
        _differences(difference, study, key, factor)
        difference.set_xlabel(f"{symbol} [{unit}]")
        impact.set_xlim(-0.004 * milliseconds, 0.01 * milliseconds)
        after.set_xlim(0, 0.2 * milliseconds)
        impact.set_ylabel("normal force [N]")
        difference.set_ylabel("hip difference [mm]")
    style.panel_labels(axes.ravel())
    impact, after, _ = axes[0]
    impact.set(yscale="log", ylim=(0.1 * weight, 1e3 * weight))
    after.set_ylim(-0.1 * weight, 4 * weight)
    for panel, title in zip(axes[0], ("heel strike", "after it", "largest over a step")):
        panel.set_title(title)
    for panel in axes[-1, :2]:
        panel.set_xlabel("time from heel strike [ms]")
    figure.legend(
        handles=[
            Line2D([], [], color=CONSTRAINT, linewidth=4, label="constraint model, rolling feet"),
            Line2D([], [], color="black", label="starting set: Adams' defaults"),
            Line2D([], [], color=CHOSEN, linestyle="--", label="chosen set"),
            Line2D([], [], color=LIMIT, linestyle=":", label="rigid limit"),
        ],
        loc="outside upper center",
        ncols=4,
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
    """Hip difference over the value; the chosen set where its value is, and the limit that no contact set passes."""
    values, found = differences(study, key)
    axes.plot(factor * values, 1e3 * found, "o-", color=style.TWIN, markersize=3)
    chosen = factor * getattr(study.chosen.law, key), 1e3 * study.chosen.hip_position.max()
    axes.plot(*chosen, "*", color=CHOSEN, markersize=9, zorder=3)
    if study.limit is not None:
        axes.axhline(1e3 * study.limit.hard.hip_position.max(), color=LIMIT, linestyle=":")
    if key != "contact_exponent":
        axes.set_xscale("log")
    axes.set_yscale("log")
    style.round_ticks(axes.yaxis)


def _value(study: Result, key: str, factor: float) -> str:
    return f"{factor * getattr(study.default.law, key):g}"


def caption(given: Given) -> str:
    study = given.contact_study
    text = (
        "Each contact parameter changed alone. From Adams' defaults the hip differs from the constraint model's by "
        f"{1e3 * study.default.hip_position.max():.2f} mm over a step; with the set chosen from "
        f"{0 if study.candidates is None else len(study.candidates.outcome)} tried, by "
        f"{1e3 * study.chosen.hip_position.max():.2f} mm"
    )
    if study.limit is None:
        return f"{text}."
    return (
        f"{text}. The rigid limit, Coulomb's transition instead of rolling feet, differs by "
        f"{1e3 * study.limit.hard.hip_position.max():.2f} mm: a set that is nearer has errors that cancel."
    )


FIGURE = Entry(
    "Figure 5: contact parameters", 5, ("contact_study", "analytic"), draw, caption,
    claims=("contact_set", "contact_set_figure_8"),
)  # fmt: skip
