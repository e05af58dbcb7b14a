"""Figure 10: the twin walking, drawn in oblique projection, and its legs' phase portrait with the transient."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.biped.walk import Walk
from stages.comparison.figures import style

NAME = "figure_10_twin"
LEG_COLOURS = (style.SECOND, style.MULTIBODY)  # the paper's green inner and red outer legs
LEG_NAMES = ("inner legs", "outer legs")


def on_page(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Oblique projection of the slope frame: x to the right, y up, z out of the page towards lower left."""
    return x - 0.55 * z, y - 0.30 * z


def draw_machine(
    axes: Axes, hip: np.ndarray, angles: np.ndarray, lengths: np.ndarray, lanes: tuple[float, float], radius: float
) -> None:
    """Hip axis, four legs and four feet at one instant, the far side first."""
    reach = max(lanes)
    turn = np.linspace(0, 2 * np.pi, 60)
    for side in (-1, 1):
        for pair, colour in enumerate(LEG_COLOURS):
            centre = hip + (lengths[pair] - radius) * np.array([np.sin(angles[pair]), -np.cos(angles[pair])])
            lateral = side * lanes[pair]
            near = side > 0
            axes.plot(*on_page(np.array([hip[0], centre[0]]), np.array([hip[1], centre[1]]), lateral),
                      color=colour, linewidth=1.6 if near else 1.0, alpha=1.0 if near else 0.55)
            rim = on_page(centre[0] + radius * np.sin(turn), centre[1] + radius * np.cos(turn), lateral)
            axes.fill(*rim, facecolor=colour, edgecolor=colour, alpha=0.20 if near else 0.08, linewidth=0)
            axes.plot(*rim, color=colour, linewidth=0.9, alpha=1.0 if near else 0.55)
    axes.plot(*on_page(np.full(2, hip[0]), np.full(2, hip[1]), np.array([-reach, reach])), color=style.TWIN, linewidth=2.4)


def draw_snapshots(axes: Axes, walk: Walk, lanes: tuple[float, float], radius: float, count: int = 5) -> None:
    """Snapshots over the last two steps, moved apart."""
    strikes = walk.heel_strike_time
    rows = np.searchsorted(walk.time, np.linspace(strikes[-3], strikes[-1], count)).clip(max=len(walk.time) - 1)
    spread, edge = 0.30, 1.5 * max(lanes)
    hips = [walk.hip_position[row] - np.array([walk.hip_position[rows[0], 0] - number * spread, 0.0])
            for number, row in enumerate(rows)]
    corners_x = np.array([hips[0][0] - 0.22, hips[-1][0] + 0.22, hips[-1][0] + 0.22, hips[0][0] - 0.22])
    axes.fill(*on_page(corners_x, np.zeros(4), np.array([-edge, -edge, edge, edge])), color=style.GROUND, alpha=0.25)
    for hip, row in zip(hips, rows, strict=True):
        draw_machine(axes, hip, walk.leg_angle[row], walk.leg_length[row], lanes, radius)
        axes.text(*on_page(hip[0], 0.0, edge + 0.03), f"{walk.time[row] - walk.time[rows[0]]:.2f} s",
                  ha="center", va="top", fontsize=7)
    axes.set_aspect("equal")
    axes.set_axis_off()
    for colour, name in zip(LEG_COLOURS, LEG_NAMES, strict=True):
        axes.plot([], [], color=colour, label=name)


def draw(walk: Walk, lanes: tuple[float, float], radius: float) -> Figure:
    """Snapshots and phase portrait; `lanes` are the distances [m] of inner and outer feet from the mid-plane."""
    figure = plt.figure(figsize=(style.TWO_COLUMNS, 5.4))
    upper, lower = figure.subfigures(2, 1, height_ratios=(1.0, 1.35))
    scene = upper.subplots()
    draw_snapshots(scene, walk, lanes, radius)
    style.panel_label(scene, "a")
    upper.legend(loc="outside upper right", ncols=2)
    portraits = lower.subplots(1, 2, sharey=True)
    strikes = walk.heel_strike_time[walk.heel_strike_leg == 0]
    settled = walk.time >= strikes[-2]
    settled &= walk.time <= strikes[-1]
    for pair, (axes, name) in enumerate(zip(portraits, LEG_NAMES, strict=True)):
        angle, rate = np.degrees(walk.leg_angle[:, pair]), walk.leg_rate[:, pair]
        axes.plot(angle, rate, color="#BBBBBB", linewidth=0.6, label="transient")
        axes.plot(angle[settled], rate[settled], color=LEG_COLOURS[pair], linewidth=1.4, label="last stride")
        axes.plot(angle[0], rate[0], "o", color=style.ANALYTIC, markersize=4, label="start: simple model's gait")
        axes.set_xlabel(f"angle of the {name} [°]")
        if pair == 0:
            axes.legend(loc="lower right")
        style.panel_label(axes, "bc"[pair])
    portraits[0].set_ylabel("rate [rad/s]")
    return figure
