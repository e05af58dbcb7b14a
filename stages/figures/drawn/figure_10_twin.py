"""Figure 10: the twin walking, drawn in oblique projection, and its legs' phase portrait with the transient."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.drawing import style
from stages.figures.inputs import Given
from stages.twin.walking.snapshots import Snapshots

TITLE = "Figure 10: the digital twin"
PLACE = 10
CLAIMS = ("twin_settles",)
INPUTS = ("twin",)
LEG_COLOURS = (style.SECOND, style.MULTIBODY)  # the paper's green inner and red outer legs
LEG_NAMES = ("inner legs", "outer legs")


def on_page(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Oblique projection of the slope frame: x to the right, y up, z out of the page towards lower left."""
    return x - 0.55 * z, y - 0.30 * z


def draw_machine(axes: Axes, poses: Snapshots, row: int, shift: np.ndarray) -> None:
    """Hip axis, four legs and four feet of one pose, the far ones first; feet are discs square to the hip axis."""
    turn = np.linspace(0, 2 * np.pi, 60)[:, None]
    order = np.argsort(poses.leg_top[row, :, 2])
    for leg in order:
        colour, near = LEG_COLOURS[leg // 2], poses.leg_top[row, leg, 2] > 0
        strength = 1.0 if near else 0.55
        top, centre, up = (points[row, leg] for points in (poses.leg_top, poses.foot_centre, poses.leg_up))
        forward = np.cross(up, poses.hip_axis[row])
        rim = centre + shift + poses.foot_radius[leg] * (np.cos(turn) * up + np.sin(turn) * forward)
        leg_line = on_page(*np.array([top + shift, centre + shift]).T)
        axes.plot(*leg_line, color=colour, linewidth=1.6 if near else 1.0, alpha=strength)
        axes.fill(*on_page(*rim.T), facecolor=colour, alpha=0.20 if near else 0.08, linewidth=0)
        axes.plot(*on_page(*rim.T), color=colour, linewidth=0.9, alpha=strength)
    ends = poses.leg_top[row][order[[0, -1]]] + shift
    axes.plot(*on_page(*ends.T), color=style.TWIN, linewidth=2.4)


def draw_snapshots(axes: Axes, poses: Snapshots, count: int = 5) -> None:
    """The first poses, moved apart."""
    rows = np.arange(min(count, len(poses.time)))
    spread, edge = 0.30, 1.5 * np.abs(poses.leg_top[:, :, 2]).max()
    shifts = [np.array([number * spread - poses.hip[rows[0], 0], 0.0, 0.0]) for number in range(len(rows))]
    start, end = poses.hip[rows[0], 0] + shifts[0][0] - 0.22, poses.hip[rows[-1], 0] + shifts[-1][0] + 0.22
    corners = np.array([[start, 0, -edge], [end, 0, -edge], [end, 0, edge], [start, 0, edge]])
    axes.fill(*on_page(*corners.T), color=style.GROUND, alpha=0.25)
    for row, shift in zip(rows.tolist(), shifts, strict=True):
        draw_machine(axes, poses, row, shift)
        foot = poses.hip[row] * np.array([1, 0, 0]) + shift + np.array([0, 0, edge + 0.03])
        x, y = on_page(*foot)
        axes.text(float(x), float(y), f"{poses.time[row] - poses.time[0]:.2f} s", ha="center", va="top", fontsize=7)
    axes.set_aspect("equal")
    axes.set_axis_off()
    for colour, name in zip(LEG_COLOURS, LEG_NAMES, strict=True):
        axes.plot([], [], color=colour, label=name)


def draw(given: Given) -> Figure:
    """Poses of the settled gait, and the phase portrait of the whole walk."""
    walk = given.twin.walk
    figure = plt.figure(figsize=(style.TWO_COLUMNS, 5.4))
    parts: Any = figure.subfigures(2, 1, height_ratios=(1.0, 1.35))
    upper, lower = parts
    scene = upper.subplots()
    draw_snapshots(scene, given.twin.snapshots)
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
            axes.legend(loc="center", bbox_to_anchor=(0.5, 0.66))
        style.panel_label(axes, "bc"[pair])
    portraits[0].set_ylabel("rate [rad/s]")
    return figure


def caption(given: Given) -> str:
    settling = given.twin.settling
    settled = settling.steps_to_settle >= 0
    when = f"settles after step {settling.steps_to_settle}" if settled else "does not settle"
    return (
        f"Four feet, paired legs, bodies with inertia from an assumed bill of parts. From the simple model's gait the "
        f"twin {when} and walks at {settling.step_frequency_hz:.4f} Hz."
    )
