"""Figure 8: hip motion of both models from the same mid-stance state, with their difference on its own axis."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.biped.walk import Walk
from stages.comparison.hip_motion import overlay
from stages.drawing import style

NAME = "figure_08_hip_motion"
PANELS = (
    ("hip_position", 0, "$x_{hip}$ [m]", 1e3, "[mm]"),
    ("hip_position", 1, "$y_{hip}$ [m]", 1e3, "[mm]"),
    ("hip_velocity", 0, r"$\dot x_{hip}$ [m/s]", 1e3, "[mm/s]"),
    ("hip_velocity", 1, r"$\dot y_{hip}$ [m/s]", 1e3, "[mm/s]"),
)


def draw(analytic: Walk, multibody: Walk, duration: float, limits: tuple[float, float]) -> Figure:
    """Both models over `duration` [s]; grey bands are the paper's largest differences (m, m/s)."""
    laid = overlay(analytic, multibody, duration)
    count = len(laid.time)
    figure, axes = plt.subplots(4, 2, figsize=(style.TWO_COLUMNS, 5.6), sharex=True, height_ratios=(2, 1, 2, 1))
    for index, (name, column, label, scale, unit) in enumerate(PANELS):
        row, side = 2 * (index // 2), index % 2
        curve, difference = axes[row, side], axes[row + 1, side]
        curve.plot(laid.time, getattr(analytic, name)[:count, column], color=style.ANALYTIC, label="constraint model")
        shown = multibody.time <= laid.time[-1]
        curve.plot(
            multibody.time[shown],
            getattr(multibody, name)[shown, column],
            "--",
            color=style.MULTIBODY,
            label="penalty contact (Exudyn)",
        )
        values = laid.position if name == "hip_position" else laid.velocity
        limit = limits[0] if name == "hip_position" else limits[1]
        difference.axhspan(-scale * limit, scale * limit, color="#EEEEEE", zorder=0)
        difference.plot(laid.time, scale * values[:, column], color=style.TWIN, linewidth=0.9)
        # impact instants differ by a fraction of a millisecond: those spikes would hide the rest
        extent = np.percentile(np.abs(scale * values[:, column]), 98)
        difference.set_ylim(*(np.array([-1.3, 1.3]) * max(extent, 1.2 * scale * limit)))
        curve.set_ylabel(label)
        difference.set_ylabel(f"difference\n{unit}")
        style.panel_label(curve, "abcd"[index])
    for side in (0, 1):
        axes[3, side].set_xlabel("time from the common mid-stance state [s]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    axes[1, 0].text(0.02, 0.06, "grey: the paper's largest difference", transform=axes[1, 0].transAxes, fontsize=6)
    return figure
