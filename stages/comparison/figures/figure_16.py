"""Figure 16: hip acceleration and angular velocity of the (synthetic) measurements, the twin and the simple model."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.comparison.figures import style
from stages.comparison.stride import Stride

NAME = "figure_16_measurement"
PANELS = ((0, "hip, forward\n[m/s²]"), (1, "hip, up the leg\n[m/s²]"), (2, "hip, angular\nvelocity [rad/s]"))


def draw(strides: np.ndarray, origin: str, twin: Stride, simple: Stride) -> Figure:
    """Registered strides of all runs (s, p, 6) in grey, twin and simple model over them.

    `origin` says what the measurements are: measured, synthetic or mixed; it stands in the picture.
    """
    figure, axes = plt.subplots(3, 1, figsize=(style.TWO_COLUMNS, 5.4), sharex=True)
    phase = np.linspace(0, 100, strides.shape[1])
    for (column, label), panel, letter in zip(PANELS, axes, "abc", strict=True):
        panel.plot(phase, strides[:, :, column].T, color=style.MEASURED, linewidth=0.3, alpha=0.35)
        panel.plot([], [], color=style.MEASURED, label=f"{len(strides)} strides, {origin}")
        panel.plot(100 * twin.phase, twin.signals[:, column], color=style.TWIN, label="digital twin")
        panel.plot(100 * simple.phase, simple.signals[:, column], "--", color=style.MULTIBODY, label="simple model")
        low, high = np.nanmin(strides[:, :, column]), np.nanmax(strides[:, :, column])
        margin = 0.15 * (high - low)
        panel.set_ylim(low - margin, high + margin)
        peak = int(np.argmax(np.abs(twin.signals[:, column])))
        if not low - margin <= twin.peaks[column] <= high + margin:
            # a spike of the models that no 100 Hz sensor shows would hide everything else
            panel.annotate(
                f"twin's spike: {twin.peaks[column]:.0f} m/s²",
                (100 * twin.phase[peak], high + 0.9 * margin),
                xytext=(6, -4),
                textcoords="offset points",
                fontsize=7,
                va="top",
            )
        panel.set_ylabel(label)
        style.panel_label(panel, letter)
    axes[-1].set_xlabel("stride of the inner leg, heel strike to heel strike [%]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    if origin != "measured":
        axes[0].text(
            0.99,
            0.95,
            "SYNTHETIC measurements",
            transform=axes[0].transAxes,
            ha="right",
            va="top",
            fontsize=7,
            color="#555555",
        )
    return figure
