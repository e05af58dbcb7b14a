"""Basin of attraction over stance angle and stance rate just after heel strike."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from stages.analytic.result import BACK, FORWARD, NO_START, OTHERWISE, REACHES, STILL, WALKS_ON, Basin
from stages.drawing import style

#: Light to dark in grey as well, so that kinds of ending are told apart in print.
LOOKS = {FORWARD: "#C9C9C9", BACK: "#8E8E8E", STILL: "#5E5E5E", OTHERWISE: "#2B2B2B", WALKS_ON: style.MULTIBODY,
         NO_START: "#FFFFFF"}  # fmt: skip


def draw(basin: Basin) -> Figure:
    """Starts that reach the gait by the number of their steps, in colour; others by how they end, in greys."""
    figure, axes = plt.subplots(figsize=(style.TWO_COLUMNS, 3.6))
    angles, rates = np.degrees(basin.stance_angle), basin.stance_rate
    order = [number for number in LOOKS if (basin.ending == number).any()]

    def steps_of(number: int) -> np.ndarray:
        return np.where(basin.ending == number, basin.steps, np.nan).T

    for number in order:
        axes.pcolormesh(
            angles, rates, steps_of(number), cmap=ListedColormap([LOOKS[number]]), shading="nearest", rasterized=True,
            label=f"{basin.endings[number]}, steps",
        )  # fmt: skip
    caught = steps_of(REACHES)
    few, most = (int(end) for end in (np.nanmin(caught), np.nanmax(caught))) if basin.share else (0, 1)
    limits = np.arange(few, most + 2) - 0.5
    colours = plt.get_cmap("viridis_r", len(limits) - 1)
    shades = axes.pcolormesh(
        angles, rates, caught, cmap=colours, norm=BoundaryNorm(limits, colours.N), shading="nearest",
        rasterized=True, label=f"{basin.endings[REACHES]}, steps",
    )  # fmt: skip
    gait = axes.plot(np.degrees(basin.gait_angle), basin.gait_rate, "o", color="white", markeredgecolor="black",
                     label="the gait")  # fmt: skip
    axes.set_xlabel("stance angle at heel strike [°]")
    axes.set_ylabel("stance rate after heel strike [rad/s]")
    handles = [*gait,
               *(Patch(facecolor=LOOKS[number], edgecolor="#555555", linewidth=0.4, label=basin.endings[number])
                 for number in order)]  # fmt: skip
    figure.legend(handles=handles, loc="outside upper center", ncols=3)
    bar = figure.colorbar(shades, label="steps until it reaches the gait [1]")
    whole = MaxNLocator(6, integer=True, min_n_ticks=1).tick_values(few, most)
    bar.set_ticks([tick for tick in whole if few <= tick <= most])
    bar.minorticks_off()
    axes.grid(visible=False)
    return figure
