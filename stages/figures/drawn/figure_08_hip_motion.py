"""Figure 8: hip motion of both models from the same mid-stance state, with their difference on its own axis."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.comparison.agreement import overlay
from stages.comparison.claims.verdict import DOES_NOT_APPLY
from stages.comparison.stride import there
from stages.drawing import style
from stages.figures.entry import Entry, Given

CLAIMS = ("hip_displacement", "hip_velocity", "integration_tolerance")
PANELS = (
    ("hip_position", 0, "$x_{hip}$ [m]", 1e3, "[mm]"),
    ("hip_position", 1, "$y_{hip}$ [m]", 1e3, "[mm]"),
    ("hip_velocity", 0, r"$\dot x_{hip}$ [m/s]", 1e3, "[mm/s]"),
    ("hip_velocity", 1, r"$\dot y_{hip}$ [m/s]", 1e3, "[mm/s]"),
)


def draw(given: Given) -> Figure:
    """Both models over two steps; grey bands are the paper's largest differences, for its own biped, bars the ones
    measured here, drawn over the span that they are measured over: the first step."""
    analytic, multibody = given.analytic.walk, given.multibody.walk
    limits = stated(given)
    laid = overlay(analytic, multibody, 2 * given.analytic.gait.period_s)
    count = len(laid.time)
    figure, axes = plt.subplots(4, 2, figsize=(style.TWO_COLUMNS, 5.6), sharex=True, height_ratios=(2, 1, 2, 1))
    for index, (name, column, label, scale, unit) in enumerate(PANELS):
        row, side = 2 * (index // 2), index % 2
        curve, difference = axes[row, side], axes[row + 1, side]
        curve.plot(laid.time, getattr(analytic, name)[:count, column], color=style.ANALYTIC, label="constraint model")
        shown = multibody.time <= laid.time[-1]
        theirs = getattr(multibody, name)[shown, column]
        curve.plot(multibody.time[shown], theirs, "--", color=style.MULTIBODY, label="penalty contact (Exudyn)")
        values = laid.position if name == "hip_position" else laid.velocity
        limit = limits[name]
        difference.axhspan(-scale * limit, scale * limit, color="#EEEEEE", zorder=0)
        difference.plot(laid.time, scale * values[:, column], color=style.TWIN, linewidth=0.9)
        # impact instants differ by a fraction of a millisecond: those spikes would hide the rest
        extent = np.percentile(np.abs(scale * values[:, column]), 98)
        difference.set_ylim(*(np.array([-1.3, 1.3]) * max(extent, 1.2 * scale * limit)))
        mark_one_step(difference, given.analytic.gait.period_s, largest_of(given, name)[column] * scale)
        curve.set_ylabel(label)
        difference.set_ylabel(f"difference\n{unit}")
    style.panel_labels(axes[::2].ravel())
    for side in (0, 1):
        axes[3, side].set_xlabel("time from the common mid-stance state [s]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    words = "grey: the paper's; " * any(limits.values()) + "dotted: largest over one step"
    axes[1, 0].text(0.02, 0.04, words, transform=axes[1, 0].transAxes, fontsize=6)
    return figure


def stated(given: Given) -> dict[str, float]:
    """The largest differences [m, m/s] that the paper states of its biped; 0 for another one."""
    settings = given.parameters.settings
    its_own = (CLAIMS[0], DOES_NOT_APPLY) not in {(claim.id, claim.verdict) for claim in given.comparison.claims}
    return {"hip_position": its_own * settings.position_limit, "hip_velocity": its_own * settings.velocity_limit}


def largest_of(given: Given, name: str) -> np.ndarray:
    """The largest differences over one step that the comparison found, x and y."""
    same = there(given.comparison.models).same_start
    return same.position if name == "hip_position" else same.velocity


def mark_one_step(axes: Axes, period: float, size: float) -> None:
    """Dotted lines at the largest difference over the first step, as long as that step, which ends at the tick."""
    axes.hlines([-size, size], 0.0, period, color=style.TWIN, linestyle=":", linewidth=0.9)
    axes.axvline(period, color="#888888", linewidth=0.6)


def caption(given: Given) -> str:
    same, (position, velocity) = there(given.comparison.models).same_start, stated(given).values()
    laid = overlay(given.analytic.walk, given.multibody.walk, 2 * given.analytic.gait.period_s)
    later = 1e3 * np.abs(laid.position).max(axis=0)
    paper = f"; the paper states {1e3 * position:g} mm and {1e3 * velocity:g} mm/s" if position else ""
    return (
        "The same mid-stance state walks on in both models. Over the first step, up to the grey line, the hips differ "
        "by at most "
        f"{1e3 * same.position[0]:.2f} mm in x and {1e3 * same.position[1]:.2f} mm in y, "
        f"{1e3 * same.velocity[0]:.1f} mm/s and {1e3 * same.velocity[1]:.1f} mm/s outside the impacts{paper}. Over "
        f"both steps drawn they come to {later[0]:.2f} mm in x and {later[1]:.2f} mm in y: each model's cycle has its "
        "own period."
    )


FIGURE = Entry(
    "Figure 8: hip motion of both models", 8, ("analytic", "multibody", "comparison"), draw, caption,
    claims=CLAIMS,
)  # fmt: skip
