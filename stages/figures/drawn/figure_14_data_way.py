"""Figure 14: the way of a sensor's samples, from the robot to the curves that are compared."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from stages.drawing import style
from stages.figures.entry import Entry, Given

#: Size of a box, and of the drawing, in units of the drawing.
WIDTH, HEIGHT, ACROSS, DOWN = 2.1, 0.9, 10.4, 4.15
DEVICE, STEP = "#E8EEF4", "#F3ECE0"


def box(axes: Axes, x: float, y: float, title: str, words: str, colour: str) -> None:
    """A box around a middle, with a title and what happens there."""
    look: dict[str, Any] = {"boxstyle": "round,pad=0.02,rounding_size=0.08", "edgecolor": "#333333", "linewidth": 0.7}
    axes.add_patch(FancyBboxPatch((x - WIDTH / 2, y - HEIGHT / 2), WIDTH, HEIGHT, facecolor=colour, **look))
    axes.text(x, y + 0.24, title, ha="center", va="center", fontsize=7.5, fontweight="bold")
    axes.text(x, y - 0.13, words, ha="center", va="center", fontsize=6.5, linespacing=1.15)


def arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], words: str = "") -> None:
    """From box to box, with what carries the data."""
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "linewidth": 0.9, "color": "black",
                                              "shrinkA": 0, "shrinkB": 0})  # fmt: skip
    if words:
        axes.text(0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1]) + 0.13, words, ha="center", fontsize=6.5)


def draw(given: Given) -> Figure:
    """Devices above, steps of the ingest below."""
    imu = given.imu
    rates = [report.rate_hz for report in imu.reports]
    lost, batch = sum(max(0, report.lost_packets) for report in imu.reports), imu.reports[0].batch_size
    figure, axes = plt.subplots(figsize=(style.TWO_COLUMNS, 2.9))
    axes.set(xlim=(0.0, ACROSS), ylim=(0.0, DOWN))
    axes.set_axis_off()
    upper, lower, half = 3.0, 0.7, WIDTH / 2
    columns = (1.15, 3.85, 6.55, 9.25)
    sampled = f"{sum(rates) / len(rates):.1f} Hz\n{batch} samples a packet"
    for y, name in ((upper + 0.52, "hip sensor"), (upper - 0.52, "foot sensor")):
        box(axes, columns[0], y, name, sampled, DEVICE)
    box(axes, columns[1], upper, "phone", "stamps packets\nas they arrive", DEVICE)
    box(axes, columns[2], upper, "computer", "rows with packet\nnumber and stamp", DEVICE)
    box(axes, columns[3], upper, "database", f"{len(imu.runs) + len(imu.rejected)} runs, {imu.origin}\n"
        f"{sum(report.rows for report in imu.reports)} rows, {lost} packets lost", DEVICE)  # fmt: skip
    for y in (upper + 0.52, upper - 0.52):
        arrow(axes, (columns[0] + half, y), (columns[1] - half, upper + 0.5 * (y - upper)), "BLE")
    arrow(axes, (columns[1] + half, upper), (columns[2] - half, upper), "WiFi")
    arrow(axes, (columns[2] + half, upper), (columns[3] - half, upper))
    off = 1e3 * max(abs(report.clock_error_s) for report in imu.reports)
    steps = (
        ("clock", f"fitted to stamps,\noff by {off:.2f} ms at most"),
        ("frames", "gravity at rest and\nthe axis of swing"),
        ("heel strikes", f"{sum(len(run.heel_strike_time) for run in imu.runs)} in "
                         f"{len(imu.runs)} runs"),
        ("strides", f"{sum(len(run.strides) for run in imu.runs)} registered,\n{imu.step_frequency:.3f} Hz"),
    )  # fmt: skip
    for x, (title, words) in zip(reversed(columns), steps, strict=True):
        box(axes, x, lower, title, words, STEP)
    arrow(axes, (columns[3], upper - HEIGHT / 2), (columns[3], lower + HEIGHT / 2))
    for right, left in zip(columns[:0:-1], columns[-2::-1]):
        arrow(axes, (right - half, lower), (left + half, lower))
    axes.text(0.5 * (columns[0] + columns[3]), upper + 0.95, "measurement", ha="center", fontsize=8, style="italic")
    axes.text(0.5 * (columns[0] + columns[3]), lower + 0.62, "ingest", ha="center", fontsize=8, style="italic")
    return figure


def caption(given: Given) -> str:
    imu = given.imu
    used = f"{len(imu.runs)} of {len(imu.runs) + len(imu.rejected)} runs were used"
    made = " The phone and its radio are a model; the ingest does not know that." if imu.origin == "synthetic" else ""
    return f"From the sensors' samples to strides that can be compared with the models' ({imu.origin}): {used}.{made}"


FIGURE = Entry("Figure 14: the way of the data", 14, ("imu",), draw, caption)
