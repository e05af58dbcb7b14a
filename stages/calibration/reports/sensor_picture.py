"""A fitted run as a picture: samples and fit over a few steps, and residuals over the step they are of."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.calibration.result import Trace
from stages.drawing import style

PANELS = (("hip", 1, "hip, up the leg", "m/s²"), ("hip", 2, "hip, angular velocity", "rad/s"),
          ("foot", 0, "foot, forward", "m/s²"), ("foot", 1, "foot, up the leg", "m/s²"))
#: Steps that are shown, and parts of a step that residuals are given by.
STEPS, PARTS = 4, 10
#: Room above and below the samples that count, as a share of their range; spikes at impacts may go beyond.
MARGIN = 0.3
#: Colour, mark of a residual and line of their root mean squares: alike in grey they would be one.
SIDES = (("hip", style.ANALYTIC, ".", "-"), ("foot", style.MULTIBODY, "x", "--"))


def fit_picture(traces: Mapping[str, Trace], strikes: np.ndarray, called: str = "fit") -> Figure:
    """Both sensors' `traces` by side, what is `called` a fit among them; `strikes` (s,) [s] by the same clock.

    Lines below are root mean squares.
    """
    figure, grid = plt.subplots(3, 2, figsize=(style.TWO_COLUMNS, 6.2))
    end = float(strikes[min(STEPS, len(strikes) - 1)])
    for (side, column, name, unit), axes, letter in zip(PANELS, grid.flat, "abcd", strict=False):
        trace = traces[side]
        shown = trace.time <= end
        counts = np.isfinite(trace.residual[:, column])
        for mask, color, label in ((counts, style.TWIN, "sample"), (~counts, style.MEASURED, "sample at an impact")):
            axes.plot(trace.time[shown & mask], trace.measured[shown & mask, column], ".", color=color, markersize=2.5,
                      label=label)
        axes.plot(trace.time[shown], trace.fitted[shown, column], color=style.ANALYTIC, linewidth=0.9, label=called)
        inside = trace.measured[shown & counts, column]
        if len(inside):
            room = MARGIN * float(np.ptp(inside))
            axes.set_ylim(float(inside.min()) - room, float(inside.max()) + room)
            style.mark_beyond(axes)
        axes.set_ylabel(f"{name} [{unit}]")
        style.panel_label(axes, letter)
    for above, axes in zip(*grid[:2], strict=True):
        above.sharex(axes)
        above.tick_params(labelbottom=False)
        axes.set_xlabel("time since a heel strike [s]")
    handles, _ = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles=[*handles, style.wedge(style.ANALYTIC)], loc="outside upper center", ncols=4)
    kinds = (((0, 1), "specific force", "m/s²", 1.0, "e"), ((2,), "rate", "mrad/s", 1e3, "f"))
    for axes, (columns, name, unit, scale, letter) in zip(grid[2], kinds, strict=True):
        for side, color, mark, line in SIDES:
            phase, residual = by_phase(traces[side], strikes, columns)
            axes.plot(100 * phase, scale * residual, mark, color=color, markersize=2.0, alpha=0.5)
            middle, size = rms_by_part(phase, residual)
            axes.plot(100 * middle, scale * size, line, color=color, linewidth=1.0)
            axes.plot([], [], mark + line, color=color, linewidth=1.0, markersize=4.0, label=side)
        axes.set(xlabel="part of the step [%]", ylabel=f"residual of the {name} [{unit}]")
        style.panel_label(axes, letter)
    grid[2, 0].legend(ncols=2)
    return figure


def by_phase(trace: Trace, strikes: np.ndarray, columns: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Phase in its step (n,) of each sample that counts, and its residual (n,), of some channels."""
    step = np.clip(np.searchsorted(strikes, trace.time, side="right") - 1, 0, len(strikes) - 2)
    phase = (trace.time - strikes[step]) / np.diff(strikes)[step]
    phases = np.repeat(phase[:, None], len(columns), axis=1)
    residual = trace.residual[:, list(columns)]
    counts = np.isfinite(residual)
    return phases[counts], residual[counts]


def rms_by_part(phase: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middles of the parts of a step that have residuals, and their root mean squares."""
    part = np.clip((PARTS * phase).astype(int), 0, PARTS - 1)
    there = [number for number in range(PARTS) if (part == number).any()]
    sizes = [float(np.sqrt((residual[part == number] ** 2).mean())) for number in there]
    return (np.array(there) + 0.5) / PARTS, np.array(sizes)
