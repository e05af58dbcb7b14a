"""What the sensors of a calibrated run showed beside what the fit says they should have, and residuals by phase."""

from __future__ import annotations

import math
from collections.abc import Iterator

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.calibration.result import FittedRun, Trace
from stages.calibration.result import Result as Calibration
from stages.drawing import style
from stages.figures.inputs import Given

TITLE = "Calibration: a run as its sensors showed it and as the fit has it"
PLACE = 41
CLAIMS = ("prototype_is_model",)
INPUTS = ("calibration",)
PANELS = (("hip", 1, "hip, up the leg", "m/s²"), ("hip", 2, "hip, angular velocity", "rad/s"),
          ("foot", 0, "foot, forward", "m/s²"), ("foot", 1, "foot, up the leg", "m/s²"))
#: Steps that are shown, and parts of a step that residuals are told by.
STEPS, PARTS = 4, 10


def draw(given: Given) -> Figure:
    """Samples and fit over a few steps; below them residuals of all samples that count, over the step they are of."""
    calibration: Calibration = given.calibration
    figure, grid = plt.subplots(3, 2, figsize=(style.TWO_COLUMNS, 6.2))
    if not calibration.fits:
        for axes in grid.flat:
            axes.axis("off")
        grid[0, 0].text(0.0, 0.5, "no run could be fitted")
        return figure
    fit = calibration.fits[0]
    end = float(fit.strikes[min(STEPS, len(fit.strikes) - 1)])
    for (side, column, name, unit), axes, letter in zip(PANELS, grid.flat, "abcd", strict=False):
        trace: Trace = getattr(fit, side)
        shown = trace.time <= end
        counts = np.isfinite(trace.residual[:, column])
        for mask, color, label in ((counts, style.TWIN, "sample"), (~counts, style.MEASURED, "sample at an impact")):
            axes.plot(trace.time[shown & mask], trace.measured[shown & mask, column], ".", color=color, markersize=2.5,
                      label=label)
        axes.plot(trace.time[shown], trace.fitted[shown, column], color=style.ANALYTIC, linewidth=0.9, label="fit")
        axes.set_ylabel(f"{name} [{unit}]")
        style.panel_label(axes, letter)
    for axes in grid[1]:
        axes.set_xlabel("time since a heel strike [s]")
    figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    for axes, (columns, name, unit, scale), letter in zip(
            grid[2], (((0, 1), "specific force", "m/s²", 1.0), ((2,), "rate", "mrad/s", 1e3)), "ef", strict=True):
        for side, color in (("hip", style.ANALYTIC), ("foot", style.MULTIBODY)):
            phase, residual = by_phase(fit, side, columns)
            axes.plot(100 * phase, scale * residual, ".", color=color, markersize=2.0, alpha=0.5, label=side)
            middle, size = rms_by_part(phase, residual)
            axes.plot(100 * middle, scale * size, color=color, linewidth=1.0)
        axes.set_xlabel("part of the step [%]")
        axes.set_ylabel(f"residual of the {name} [{unit}]")
        style.panel_label(axes, letter)
    grid[2, 0].legend(ncols=2)
    return figure


def by_phase(fit: FittedRun, side: str, columns: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Phase in its step (n,) of each sample that counts, and its residual (n,)."""
    trace: Trace = getattr(fit, side)
    step = np.clip(np.searchsorted(fit.strikes, trace.time, side="right") - 1, 0, len(fit.strikes) - 2)
    phase = (trace.time - fit.strikes[step]) / np.diff(fit.strikes)[step]
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


def caption(given: Given) -> str:
    calibration: Calibration = given.calibration
    if not calibration.fits:
        return "No run could be fitted."
    fit = calibration.fits[0]
    words = (f"{fit.name}, {fit.kind}, {len(fit.strikes) - 1} steps fitted alone by the constraint model: residuals of "
             f"{fit.sigmas:.2f} times the sensors' noise. Lines below: root mean square by part of the step; samples at "
             f"impacts do not count. {_largest(fit)}")  # fmt: skip
    return " ".join([words, *_told(calibration)])


def _largest(fit: FittedRun) -> str:
    middle, size = rms_by_part(*by_phase(fit, "foot", (0, 1)))
    worst = int(np.argmax(size))
    return f"The foot's are largest {100 * middle[worst]:.0f} % into a step ({size[worst]:.3f} m/s²)."


def _told(calibration: Calibration) -> Iterator[str]:
    for one in calibration.held_out:
        words = (f"{one.name} was held out: with its start and sensors fitted errors are {one.fit_force:.3f} m/s² and "
                 f"{1e3 * one.fit_rate:.1f} mrad/s")  # fmt: skip
        if math.isfinite(one.foretold_force):
            words += (f"; foretold from its first {one.begun:g} s, {one.foretold_force:.2f} m/s² and "
                      f"{1e3 * one.foretold_rate:.0f} mrad/s over the rest")  # fmt: skip
        yield words + "."
    for words in calibration.not_seen:
        yield f"{words[0].upper()}{words[1:]}."
