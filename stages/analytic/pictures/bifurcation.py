"""A family of gaits over a design parameter: stance angle at heel strike, period and largest multiplier."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.analytic.gait.continuation import Branch
from stages.drawing import style

COLOURS = (style.ANALYTIC, style.MULTIBODY, style.SECOND, style.THIRD, style.TWIN)
MARKS = {"turning point": "s", "period doubling": "D", "torus": "^"}


def draw(branches: Sequence[Branch], parameter: str, unit: str) -> Figure:
    """One colour a cycle; full lines are stable, dashed ones unstable; marks are special points."""
    figure, axes = plt.subplots(3, 1, figsize=(style.TWO_COLUMNS, 5.6), sharex=True)
    cycles = sorted({branch.cycle for branch in branches})
    for branch in branches:
        colour = COLOURS[cycles.index(branch.cycle) % len(COLOURS)]
        values = np.array([point.value for point in branch.points])
        stable = np.array([point.stable for point in branch.points])
        curves = (
            np.degrees([-point.z[0] for point in branch.points]),
            np.array([point.period / branch.cycle for point in branch.points]),
            np.array([np.abs(point.floquet_multipliers).max() for point in branch.points]),
        )
        for panel, curve in zip(axes, curves, strict=True):
            panel.plot(values, np.where(stable, curve, np.nan), color=colour)
            panel.plot(values, np.where(stable, np.nan, curve), color=colour, linestyle=(0, (2, 2)))
        for special in branch.special:
            axes[0].plot(
                special.point.value, np.degrees(-special.point.z[0]), MARKS[special.kind], color=colour, markersize=5
            )
    for cycle, colour in zip(cycles, COLOURS, strict=False):
        axes[0].plot([], [], color=colour, label=f"cycle of {cycle} step{'s' if cycle > 1 else ''}")
    for kind in sorted({special.kind for branch in branches for special in branch.special}):
        axes[0].plot([], [], MARKS[kind], color="#555555", label=kind)
    axes[0].plot([], [], color="#555555", linestyle=(0, (2, 2)), label="unstable")
    axes[2].axhline(1, color="#555555", linewidth=0.6)
    axes[2].set_ylim(0, 3)
    axes[0].set_ylabel("stance angle at\nheel strike [°]")
    axes[1].set_ylabel("mean step\nperiod [s]")
    axes[2].set_ylabel("largest multiplier\n[-]")
    axes[2].set_xlabel(f"{parameter} [{unit}]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure
