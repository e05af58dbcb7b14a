"""After a push to the side: roll dies out, yaw and drift stay, and a hard push ends in a fall."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.drawing import style
from stages.figures.entry import Entry, Given


def draw(given: Given) -> Figure:
    """Histories of roll, yaw and drift after the pushes of the first kind; a cross marks a fall."""
    pushes = given.twin_pushes
    kind = pushes.walks[0].kind
    walks = [walk for walk in pushes.walks if walk.kind == kind]
    figure, panels = plt.subplots(1, 3, figsize=(style.TWO_COLUMNS, 2.8), sharex=True)
    shades = plt.get_cmap("cividis")(np.linspace(0.0, 0.85, len(walks)))
    for walk, colour in zip(walks, shades, strict=True):
        name = f"{walk.size:g} {walk.unit}" + ("" if walk.survived else ", falls")
        for axes, values in zip(
            panels, (np.degrees(walk.roll), np.degrees(walk.yaw), 1e3 * (walk.lateral - walk.lateral[0])), strict=True
        ):
            axes.plot(walk.time, values, color=colour, linewidth=1.0, label=name)
            if not walk.survived:
                axes.plot(walk.time[-1], values[-1], "x", color=colour, markersize=6, markeredgewidth=1.6)
    for axes, label, letter in zip(panels, ("roll [°]", "yaw [°]", "drift of the hip [mm]"), "abc", strict=True):
        axes.set(xlabel="time since the push [s]", ylabel=label)
        style.panel_label(axes, letter)
    named = panels[0].get_legend_handles_labels()
    figure.legend(*named, loc="outside upper center", ncols=len(walks), title=f"push: {kind}")
    return figure


def caption(given: Given) -> str:
    return f"{given.twin_pushes.summary()}."


FIGURE = Entry("Pushes to the side", 40, ("twin_pushes",), draw, caption, claims=("push_converges",))
