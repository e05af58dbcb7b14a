"""Figure 10: the twin walking, in three dimensions, and its legs' phase portrait with the transient."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.axes3d import Axes3D

from stages.biped.walk import Walk
from stages.comparison.figures import style

NAME = "figure_10_twin"
LEG_COLOURS = (style.SECOND, style.MULTIBODY)  # the paper's green inner and red outer legs
LEG_NAMES = ("inner legs", "outer legs")


def foot_disc(centre: np.ndarray, radius: float, lateral: float) -> np.ndarray:
    """Points (n, 3) of a foot's rim in the plane z = lateral."""
    turn = np.linspace(0, 2 * np.pi, 40)
    return np.column_stack([
        centre[0] + radius * np.sin(turn), centre[1] + radius * np.cos(turn), np.full(turn.size, lateral)])


def draw_machine(
    axes: Axes3D, hip: np.ndarray, angles: np.ndarray, lengths: np.ndarray, lanes: tuple[float, float], radius: float
) -> None:
    """Hip axis, four legs and four feet at one instant; the page's axes are x, z, y."""
    for pair, colour in enumerate(LEG_COLOURS):
        centre = hip + (lengths[pair] - radius) * np.array([np.sin(angles[pair]), -np.cos(angles[pair])])
        for side in (-1, 1):
            lateral = side * lanes[pair]
            axes.plot([hip[0], centre[0]], [lateral, lateral], [hip[1], centre[1]], color=colour, linewidth=1.1)
            rim = foot_disc(centre, radius, lateral)
            axes.plot(rim[:, 0], rim[:, 2], rim[:, 1], color=colour, linewidth=0.8)
    reach = max(lanes)
    axes.plot([hip[0], hip[0]], [-reach, reach], [hip[1], hip[1]], color=style.TWIN, linewidth=2)


def draw_snapshots(axes: Axes3D, walk: Walk, lanes: tuple[float, float], radius: float, count: int = 4) -> None:
    """Snapshots over the last two steps, moved apart."""
    strikes = walk.heel_strike_time
    rows = np.searchsorted(walk.time, np.linspace(strikes[-3], strikes[-1], count)).clip(max=len(walk.time) - 1)
    spread, last = 0.22, 0.0
    for number, row in enumerate(rows):
        hip = walk.hip_position[row] - np.array([walk.hip_position[rows[0], 0] - number * spread, 0.0])
        draw_machine(axes, hip, walk.leg_angle[row], walk.leg_length[row], lanes, radius)
        last = hip[0]
    ground_x, ground_z = np.meshgrid([-0.2, last + 0.2], [-1.6 * max(lanes), 1.6 * max(lanes)])
    axes.plot_surface(ground_x, ground_z, np.zeros_like(ground_x), color=style.GROUND, alpha=0.25)
    axes.set_zlim(0, 0.36)
    axes.set_box_aspect((last + 0.4, 3.2 * max(lanes), 0.36), zoom=1.45)
    axes.view_init(elev=14, azim=-68)
    axes.set_axis_off()
    for colour, name in zip(LEG_COLOURS, LEG_NAMES, strict=True):
        axes.plot([], [], [], color=colour, label=name)
    axes.legend(loc="upper left", ncols=2)


def draw(walk: Walk, lanes: tuple[float, float], radius: float) -> Figure:
    """Snapshots and phase portrait; `lanes` are the distances [m] of inner and outer feet from the mid-plane."""
    figure = plt.figure(figsize=(style.TWO_COLUMNS, 5.8))
    upper, lower = figure.subfigures(2, 1, height_ratios=(1.0, 1.25))
    scene = upper.add_axes((-0.1, -0.2, 1.2, 1.35), projection="3d")
    draw_snapshots(scene, walk, lanes, radius)
    upper.text(0.02, 0.9, "(a)", fontweight="bold")
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
        axes.legend(loc="upper left" if pair else "lower right")
        style.panel_label(axes, "bc"[pair])
    portraits[0].set_ylabel("rate [rad/s]")
    return figure
