"""Figure 16: hip acceleration and angular velocity of the (synthetic) measurements, the twin and the simple model.

Beside each panel stand the numbers of the agreement; below them the leg's angle against its rate, the hip's path over a
stance, and the difference of the step frequencies.
"""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.biped.walk import SENSOR_SIGNALS
from stages.comparison.measurement import LegAgreement, MeasurementAgreement
from stages.comparison.stride import last_stride, there
from stages.drawing import style
from stages.figures.entry import Entry, Given
from stages.imu.trial.agreement import Agreement, FrequencyDifference

PANELS = (
    (0, "hip, forward", "m/s²"),
    (1, "hip, up the leg", "m/s²"),
    (2, "hip, angular velocity", "rad/s"),
)


def draw(given: Given) -> Figure:
    """Registered strides of all runs in grey, twin and simple model over them, their agreement beside; the leg below.

    The measurements' origin (measured, synthetic or mixed) stands in the picture.
    """
    measured, points = there(given.comparison.measurement), given.parameters.settings.phase_points
    strides = np.concatenate([run.strides for run in given.imu.runs])  # (s, p, 6)
    twin, simple = last_stride(given.twin.walk, points), last_stride(given.multibody.walk, points)
    calibrated = last_stride(given.calibrated_twin.walk, points) if given.calibrated_twin.walk is not None else None
    figure = plt.figure(figsize=(style.TWO_COLUMNS, 8.4))
    parts: Any = figure.subfigures(2, 1, height_ratios=(6.0, 2.4))
    above, below = parts
    grid = above.subplots(3, 2, sharex="col", gridspec_kw={"width_ratios": (1.0, 0.62)})
    phase = np.linspace(0, 100, strides.shape[1])
    for (column, name, unit), (panel, beside), letter in zip(PANELS, grid, "abc", strict=True):
        panel.plot(phase, strides[:, :, column].T, color=style.MEASURED, linewidth=0.3, alpha=0.35)
        panel.plot([], [], color=style.MEASURED, label=f"{len(strides)} strides, {measured.origin}")
        panel.plot(100 * twin.phase, twin.signals[:, column], color=style.TWIN, label="digital twin")
        panel.plot(100 * simple.phase, simple.signals[:, column], "--", color=style.MULTIBODY, label="simple model")
        if calibrated is not None:
            panel.plot(100 * calibrated.phase, calibrated.signals[:, column], ":", color=style.SECOND,
                       label="twin as calibrated")
        low, high = np.nanmin(strides[:, :, column]), np.nanmax(strides[:, :, column])
        margin = 0.15 * (high - low)
        panel.set_ylim(low - margin, high + margin)
        peak = int(np.argmax(np.abs(twin.signals[:, column])))
        if not low - margin <= twin.peaks[column] <= high + margin:
            # a spike of the models that no 100 Hz sensor shows would hide everything else
            late = twin.phase[peak] > 0.6
            panel.annotate(
                f"twin's spike: {twin.peaks[column]:.0f} m/s²", (100 * twin.phase[peak], high + 0.9 * margin),
                xytext=(-6 if late else 6, -4), textcoords="offset points", fontsize=7, va="top",
                ha="right" if late else "left",
            )  # fmt: skip
        panel.set_ylabel(f"{name}\n[{unit}]")
        style.panel_label(panel, letter)
        signal = SENSOR_SIGNALS[column]
        write(beside, agreement_rows(measured.twin[signal], measured.simple[signal], unit))
    grid[-1, 0].set_xlabel("stride of the inner leg, heel strike to heel strike [%]")
    above.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    if measured.leg is not None:
        portrait, path = below.subplots(1, 2)
        draw_leg(portrait, path, measured.leg)
    figure.supxlabel(frequency_line(measured), fontsize=7)
    if measured.origin != "measured":
        words, place = "SYNTHETIC measurements", grid[0, 0].transAxes
        grid[0, 0].text(0.99, 0.04, words, transform=place, ha="right", va="bottom", fontsize=7, color="#555555")
    return figure


def draw_leg(portrait: Axes, path: Axes, leg: LegAgreement) -> None:
    """The inner leg's angle against its rate over a stride, and the hip over the leg's stance, of runs and models."""
    for angle, rate in zip(leg.angles, leg.rates):
        portrait.plot(np.degrees(angle), np.degrees(rate), color=style.MEASURED, linewidth=0.3, alpha=0.35)
    for along, height in leg.hip_paths.transpose(0, 2, 1):
        path.plot(1e3 * along, 1e3 * height, color=style.MEASURED, linewidth=0.3, alpha=0.35)
    for model, form, color in ((leg.twin, "-", style.TWIN), (leg.simple, "--", style.MULTIBODY)):
        portrait.plot(np.degrees(model.angle), np.degrees(model.rate), form, color=color)
        path.plot(*(1e3 * model.hip_path.T), form, color=color)
    portrait.set(xlabel="leg angle [deg]", ylabel="its rate [deg/s]")
    path.set(xlabel="hip along the slope over a stance [mm]", ylabel="above it [mm]")
    style.panel_labels((portrait, path), "de")


def agreement_rows(twin: Agreement, simple: Agreement, unit: str) -> list[tuple[str, str, str]]:
    """Rows of a panel's table: measure, twin, simple model."""

    def row(name: str, field: str, form: str, scale: float = 1.0) -> tuple[str, str, str]:
        values = (scale * float(getattr(one, field)) for one in (twin, simple))
        first, second = (format(value, form) if np.isfinite(value) else "undefined" for value in values)
        return name, first, second

    return [
        ("agreement", "twin", "simple"),
        row(f"RMSE [{unit}]", "rmse", ".2f"),
        row("RMSE / range [%]", "nrmse", ".1f", 100),
        row("multiple correlation", "correlation", ".3f"),
        row("ICC(A,1)", "icc", ".3f"),
        row(f"bias [{unit}]", "bias", "+.3f"),
        row(f"upper limit of agreement [{unit}]", "upper_limit", "+.2f"),
        row(f"lower limit of agreement [{unit}]", "lower_limit", "+.2f"),
        row("inside the envelope [%]", "envelope_share", ".0f", 100),
    ]


def write(axes: Axes, rows: list[tuple[str, str, str]]) -> None:
    """Rows as text without a frame, the first one as head, numbers flush right."""
    axes.axis("off")
    for number, row in enumerate(rows):
        weight = "bold" if number == 0 else "normal"
        height = 1 - (number + 0.5) / len(rows)
        for x, text, align in zip((0.0, 0.83, 1.0), row, ("left", "right", "right"), strict=True):
            axes.text(x, height, text, transform=axes.transAxes, fontsize=6.5, ha=align, va="center", weight=weight)


def frequency_line(measured: MeasurementAgreement) -> str:
    """Difference of the step frequencies with its confidence interval, as a sentence."""

    def words(model: str, found: FrequencyDifference) -> str:
        interval = (
            f" ({1e3 * found.lower:+.1f} to {1e3 * found.upper:+.1f} at {100 * found.confidence:.0f} %)"
            if np.isfinite(found.lower)
            else ""
        )
        return f"{1e3 * found.difference:+.1f} mHz{interval} from the {model}"

    twin = words("twin over the same steps", measured.twin_frequency)
    simple = words("settled simple model", measured.simple_frequency)
    low_pass = f"; models behind the sensors' {measured.bandwidth:g} Hz low pass" if measured.bandwidth > 0 else ""
    return (
        f"Agreement with the mean of {measured.runs} {measured.origin} runs{low_pass}.\n"
        f"Step frequency of the runs: {twin},\n{simple}."
    )


def caption(given: Given) -> str:
    measured = there(given.comparison.measurement)
    leg = measured.leg
    shares = ", ".join(f"{100 * measured.twin[name].envelope_share:.0f} %" for name in list(measured.twin)[:3])
    return (
        f"{measured.runs} {measured.origin} runs at {measured.step_frequency:.4f} Hz "
        f"(± {measured.step_frequency_spread:.4f} between runs), twin {measured.twin_step_frequency:.4f} Hz over the "
        f"same steps. The envelope holds the twin over {shares} of the stride."
        + calibrated_words(given)
        + ("" if leg is None else leg_words(leg))
        + (" Synthetic runs test the method; they cannot confirm a model." if measured.origin != "measured" else "")
    )


def calibrated_words(given: Given) -> str:
    """What the twin does with the numbers that a calibration gave it."""
    walk = given.calibrated_twin.walk
    if walk is None:
        return ""
    found, settled = given.calibrated_twin.robots[0], last_stride(walk, 3).period
    return (f" The twin as calibrated has the numbers that {found.runs} of the runs gave; it walks at "
            f"{2 / settled:.4f} Hz.")


def leg_words(leg: LegAgreement) -> str:
    """What the lower panels show, in numbers."""
    runs, twin, simple = (f"{1e3 * one.step_length:.1f} mm" for one in (leg.runs, leg.twin, leg.simple))
    return (
        " Below, from one integration of the rate and the foot that rolls: the leg's angle, "
        f"{np.degrees(leg.twin_angle):.2f} and {np.degrees(leg.simple_angle):.2f} degrees rms from the twin's and the "
        f"simple model's, and the hip over a stance; steps of {runs} ± {1e3 * leg.step_length_error:.1f} mm each, "
        f"{twin} in the twin, {simple} in the simple model. The runs' hip is a rigid leg's, the models' legs give way."
    )


FIGURE = Entry(
    "Figure 16: measurements and models", 16, ("imu", "twin", "calibrated_twin", "multibody", "comparison"),
    draw, caption,
    claims=("measurement_encloses", "measurement_slower", "twin_like_simple", "sensor_range", "hip_path_drifts"),
)  # fmt: skip
