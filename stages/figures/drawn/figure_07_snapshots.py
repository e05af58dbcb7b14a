"""Figure 7: snapshots of the multibody model walking down the slope."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.biped.accuracy.scales import size
from stages.drawing import style
from stages.figures.entry import Entry, Given

SNAPSHOTS = 7
LEG_COLOURS = (style.ANALYTIC, style.MULTIBODY)
FOOT_ARC_DEG = 40  # drawn part of the round foot on either side of the leg


def rotated(points: np.ndarray, slope: float) -> np.ndarray:
    """Points (n, 2) of the slope frame turned so that gravity points down the page."""
    cos, sin = np.cos(slope), np.sin(slope)
    turned: np.ndarray = points @ np.array([[cos, -sin], [sin, cos]])
    return turned


def draw_biped(
    axes: Axes, hip: np.ndarray, angles: np.ndarray, lengths: np.ndarray, radius: float, slope: float
) -> None:
    """Hip, two legs and their round feet at one instant."""
    for leg, colour in enumerate(LEG_COLOURS):
        along = np.array([np.sin(angles[leg]), -np.cos(angles[leg])])
        centre = hip + (lengths[leg] - radius) * along
        line = rotated(np.array([hip, centre]), slope)
        axes.plot(line[:, 0], line[:, 1], color=colour, linewidth=1.4, solid_capstyle="round")
        turn = angles[leg] + np.radians(np.linspace(-FOOT_ARC_DEG, FOOT_ARC_DEG, 40))
        sole = rotated(centre + radius * np.column_stack([np.sin(turn), -np.cos(turn)]), slope)
        axes.plot(sole[:, 0], sole[:, 1], color=colour, linewidth=2.2, solid_capstyle="round")
        for end in (sole[0], sole[-1]):
            axes.plot([line[1, 0], end[0]], [line[1, 1], end[1]], color=colour, linewidth=0.7)
    top = rotated(hip[None, :], slope)[0]
    axes.plot(*top, "o", color=style.TWIN, markersize=4, zorder=4)


def draw(given: Given) -> Figure:
    """Snapshots at equal times over the last three steps of the walk."""
    walk, slope = given.multibody.walk, given.parameters.slope.angle
    strikes = walk.heel_strike_time
    times = np.linspace(strikes[-4], strikes[-1], SNAPSHOTS)
    rows = np.searchsorted(walk.time, times).clip(max=len(walk.time) - 1)
    figure, axes = plt.subplots(figsize=(style.TWO_COLUMNS, 2.3))
    large = size(given.parameters.biped)
    spread = 0.10 * large  # consecutive snapshots overlap on the page: each moves on by so much more than it walked
    origin = walk.hip_position[rows[0], 0]
    for number, row in enumerate(rows):
        hip = walk.hip_position[row] - np.array([origin, 0.0]) + np.array([number * spread, 0.0])
        draw_biped(axes, hip, walk.leg_angle[row], walk.leg_length[row], given.parameters.biped.foot_radius, slope)
        ((x, y),) = rotated(np.array([[hip[0], -0.045 * large]]), slope)
        axes.text(x, y, f"{walk.time[row] - walk.time[rows[0]]:.2f} s", ha="center", va="top", fontsize=7)
    ground = rotated(np.array([[-0.25 * large, 0.0], [hip[0] + 0.25 * large, 0.0]]), slope)
    axes.plot(ground[:, 0], ground[:, 1], color=style.GROUND, linewidth=2)
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set_axis_off()
    axes.plot([], [], color=LEG_COLOURS[0], label="inner leg")
    axes.plot([], [], color=LEG_COLOURS[1], label="outer leg")
    figure.legend(loc="outside upper right", ncols=2)
    words = f"Slope {np.degrees(slope):.3g}°, three steps; snapshots are drawn {1e3 * spread:.0f} mm further apart"
    figure.text(0.01, 0.93, f"{words} than they are", fontsize=7)
    return figure


def caption(given: Given) -> str:
    cycle = given.multibody.cycle
    return (
        f"Exudyn's model on the slope of {np.degrees(given.parameters.slope.angle):.3g}°: "
        f"{cycle.speed_m_s:.4f} m/s, a step in {cycle.period_s:.4f} s."
    )


FIGURE = Entry("Figure 7: snapshots", 7, ("multibody",), draw, caption)
