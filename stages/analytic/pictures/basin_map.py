"""Basin of attraction over stance angle and stance rate just after heel strike."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.analytic.gait.basin import Basin
from stages.analytic.model.walker import Vector
from stages.drawing import style


def draw(basin: Basin, time: float, gait: Vector, steps: int) -> Figure:
    """Steps survived by starts that fall, in grey; starts that reach the gait, in colour. `time` is sqrt(L/g) [s]."""
    figure, axes = plt.subplots(figsize=(style.TWO_COLUMNS, 4.2))
    angles, rates = np.degrees(-basin.first), basin.second / time
    survived = np.where(basin.reached >= 0, np.nan, basin.survived).T
    most = max(1, int(np.nanmax(survived, initial=0)))
    shades = axes.pcolormesh(
        angles, rates, survived, cmap="Greys", vmin=0, vmax=most, shading="nearest", rasterized=True
    )
    reached = np.where(basin.reached >= 0, 1.0, np.nan).T
    axes.pcolormesh(angles, rates, reached, cmap="winter", vmin=0, vmax=1.5, shading="nearest", rasterized=True)
    axes.plot(
        np.degrees(-gait[0]), gait[1 if len(gait) == 3 else 3] / time, "o", color=style.MULTIBODY, label="the gait"
    )
    axes.plot([], [], "s", color=plt.get_cmap("winter")(1 / 1.5), label=f"reaches the gait within {steps} steps")
    axes.set_xlabel("stance angle at heel strike [°]")
    axes.set_ylabel("stance rate after heel strike [rad/s]")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=2)
    figure.colorbar(shades, label="steps before the walk ends [-]")
    axes.grid(False)
    return figure
