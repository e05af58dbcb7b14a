"""Measurements: the way of their data, and their agreement with the models (figures 14 and 16)."""

import textwrap
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from stages.biped.quantity import count_of
from stages.biped.walk import SENSOR_SIGNALS
from stages.comparison.measurement import LegAgreement, MeasurementAgreement
from stages.comparison.stride import last_stride, there, through_low_pass
from stages.drawing import style
from stages.figures.entry import Entry, Given
from stages.imu.trial.agreement import Agreement, FrequencyDifference

# Figure 14: the way of a sensor's samples, from the robot to the curves that are compared.

#: Size of a box, and of the drawing, in units of the drawing.
WIDTH, HEIGHT, ACROSS, DOWN = 2.3, 1.05, 5.1, 6.2
DEVICE, STEP = "#E8EEF4", "#F3ECE0"


def box(axes: Axes, x: float, y: float, title: str, words: str, colour: str) -> None:
    """A box around a middle, with a title and what happens there."""
    look: dict[str, Any] = {"boxstyle": "round,pad=0.02,rounding_size=0.08", "edgecolor": "#333333", "linewidth": 0.7}
    axes.add_patch(FancyBboxPatch((x - WIDTH / 2, y - HEIGHT / 2), WIDTH, HEIGHT, facecolor=colour, **look))
    axes.text(x, y + 0.32, title, ha="center", va="center", fontsize=7.5, fontweight="bold")
    axes.text(x, y - 0.1, words, ha="center", va="center", fontsize=7, linespacing=1.15)


def arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], words: str = "") -> None:
    """From box to box, with what carries the data."""
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "linewidth": 0.9, "color": "black",
                                              "shrinkA": 0, "shrinkB": 0})  # fmt: skip
    if words:
        axes.text(start[0] + 0.1, 0.5 * (start[1] + end[1]), words, va="center", fontsize=7)


def draw_data_way(given: Given) -> Figure:
    """Devices on the left, downwards; steps of the ingest on the right, upwards."""
    imu = given.imu
    rates = [report.rate_hz for report in imu.reports]
    lost, batch = sum(max(0, report.lost_packets) for report in imu.reports), imu.reports[0].batch_size
    figure, axes = plt.subplots(figsize=(style.ONE_COLUMN, 4.2))
    axes.set(xlim=(0.0, ACROSS), ylim=(0.0, DOWN))
    axes.set_axis_off()
    (left, right), half, levels = (1.2, 3.9), HEIGHT / 2, (5.1, 3.6, 2.1, 0.6)
    devices = (
        ("hip and foot sensor", f"{sum(rates) / len(rates):.1f} Hz\n{batch} samples a packet", "BLE"),
        ("phone", "stamps packets\nas they arrive", "WiFi"),
        ("computer", "rows with packet\nnumber and stamp", ""),
        ("database", f"{count_of(len(imu.runs) + len(imu.rejected), 'run')}, {imu.origin}\n"
                     f"{sum(report.rows for report in imu.reports)} rows\n{lost} packets lost", ""),
    )  # fmt: skip
    for y, (name, words, carrier) in zip(levels, devices, strict=True):
        box(axes, left, y, name, words, DEVICE)
        if y > levels[-1]:
            arrow(axes, (left, y - half), (left, y - 1.5 + half), carrier)
    off = 1e3 * max(abs(report.clock_error_s) for report in imu.reports)
    steps = (
        ("clock", f"fitted to stamps,\noff by {off:.2f} ms at most"),
        ("frames", "gravity at rest and\nthe axis of swing"),
        ("heel strikes", f"{sum(len(run.heel_strike_time) for run in imu.runs)} in "
                         f"{count_of(len(imu.runs), 'run')}"),
        ("strides", f"{sum(len(run.strides) for run in imu.runs)} registered,\n{imu.step_frequency:.3f} Hz"),
    )  # fmt: skip
    arrow(axes, (left + WIDTH / 2, levels[-1]), (right - WIDTH / 2, levels[-1]))
    for y, (title, words) in zip(reversed(levels), steps, strict=True):
        box(axes, right, y, title, words, STEP)
        if y < levels[0]:
            arrow(axes, (right, y + half), (right, y + 1.5 - half))
    for x, words in ((left, "measurement"), (right, "ingest")):
        axes.text(x, levels[0] + 0.7, words, ha="center", fontsize=8, style="italic")
    return figure


def caption_data_way(given: Given) -> str:
    imu = given.imu
    used = f"{len(imu.runs)} of {len(imu.runs) + len(imu.rejected)} runs were used"
    made = " The phone and its radio are a model; the ingest does not know that." if imu.origin == "synthetic" else ""
    return f"From the sensors' samples to strides that can be compared with the models' ({imu.origin}): {used}.{made}"


# Figure 16: hip acceleration and angular velocity of the (synthetic) measurements, the twin and the simple model.

PANELS = (
    (0, "hip, forward", "m/s²"),
    (1, "hip, up the leg", "m/s²"),
    (2, "hip, angular velocity", "rad/s"),
)


def draw_agreement(given: Given) -> Figure:
    """Registered strides of all runs in grey, twin and simple model over them, their agreement beside; the leg below.

    The measurements' origin (measured, synthetic or mixed) stands in the picture.
    """
    measured, points = there(given.comparison.measurement), given.parameters.settings.phase_points
    strides = np.concatenate([run.strides for run in given.imu.runs])  # (s, p, 6)
    twin = last_stride(given.twin.walk, points)
    models = [("digital twin", twin, "-", style.TWIN),
              ("simple model", last_stride(given.multibody.walk, points), "--", style.MULTIBODY)]  # fmt: skip
    if given.calibrated_twin.walk is not None:
        models.append(("twin as calibrated", last_stride(given.calibrated_twin.walk, points), ":", style.SECOND))
    shown = [(name, through_low_pass(stride, measured.bandwidth), form, color) for name, stride, form, color in models]
    figure = plt.figure(figsize=(style.TWO_COLUMNS, 8.4))
    parts: Any = figure.subfigures(2, 1, height_ratios=(6.0, 2.4))
    above, below = parts
    grid = above.subplots(3, 2, sharex="col", gridspec_kw={"width_ratios": (1.0, 1.2)})
    phase = np.linspace(0, 100, strides.shape[1])
    for (column, title, unit), (panel, beside), letter in zip(PANELS, grid, "abc", strict=True):
        panel.plot(phase, strides[:, :, column].T, color=style.MEASURED, linewidth=0.3, alpha=0.35)
        panel.plot([], [], color=style.MEASURED, label=f"{len(strides)} strides, {measured.origin}")
        for name, signals, form, color in shown:
            panel.plot(100 * twin.phase, signals[:, column], form, color=color, label=name)
        low, high = np.nanmin(strides[:, :, column]), np.nanmax(strides[:, :, column])
        margin = 0.15 * (high - low)
        panel.set_ylim(low - margin, high + margin)
        if not low - margin <= twin.peaks[column] <= high + margin:
            # a spike of the models that no 100 Hz sensor shows would hide everything else
            words = " before the low pass" if measured.bandwidth > 0 else ""
            panel.set_title(f"twin's spike{words}: {twin.peaks[column]:.4g} {unit}", loc="right", fontsize=7)
        style.mark_beyond(panel)
        panel.set_ylabel(f"{title}\n[{unit}]")
        style.panel_label(panel, letter)
        signal = SENSOR_SIGNALS[column]
        write(beside, agreement_rows(measured.twin[signal], measured.simple[signal], unit))
    grid[-1, 0].set_xlabel("stride of the inner leg, heel strike to heel strike [%]")
    above.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    if measured.leg is not None:
        portrait, path = below.subplots(1, 2)
        draw_leg(portrait, path, measured.leg)
    said = f"{agreement_line(measured)}. {frequency_line(measured)}"
    figure.supxlabel("\n".join(textwrap.wrap(said, 60)), fontsize=7)
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
        row(f"RMSE [{unit}]", "rmse", ".3g"),
        row("RMSE / range [%]", "nrmse", ".1f", 100),
        row("multiple correlation", "correlation", ".3f"),
        row("ICC(A,1)", "icc", ".3f"),
        row(f"bias [{unit}]", "bias", "+.2g"),
        row(f"upper limit of agreement [{unit}]", "upper_limit", "+.3g"),
        row(f"lower limit of agreement [{unit}]", "lower_limit", "+.3g"),
        row("inside the envelope [%]", "envelope_share", ".0f", 100),
    ]


def write(axes: Axes, rows: list[tuple[str, str, str]]) -> None:
    """Rows as text without a frame, the first one as head, numbers flush right."""
    axes.axis("off")
    for number, row in enumerate(rows):
        weight = "bold" if number == 0 else "normal"
        height = 1 - (number + 0.5) / len(rows)
        for x, text, align in zip((0.0, 0.85, 1.0), row, ("left", "right", "right"), strict=True):
            axes.text(x, height, text, transform=axes.transAxes, fontsize=7, ha=align, va="center", weight=weight)


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
    return f"Step frequency of the runs: {twin}, {simple}."


def agreement_line(measured: MeasurementAgreement) -> str:
    """What the runs are compared with: models as the sensors show them, or with their spikes."""
    how = (f"models behind the sensors' {measured.bandwidth:.4g} Hz low pass" if measured.bandwidth > 0 else
           "the sensors' bandwidth is not known: the models' spikes at impacts, which they cannot show, count in RMSE, "
           "ICC and limits")  # fmt: skip
    return f"Agreement with the mean of {count_of(measured.runs, f'{measured.origin} run')}; {how}"


#: Said where models cannot be shown as the sensors would.
UNKNOWN_BANDWIDTH = (" The sensors' bandwidth is not declared, so that the table counts the models' spikes at impacts: "
                     "give bandwidth_hz of the devices.")  # fmt: skip


def caption_agreement(given: Given) -> str:
    measured = there(given.comparison.measurement)
    leg = measured.leg
    shares = ", ".join(f"{100 * measured.twin[name].envelope_share:.0f} %" for name in list(measured.twin)[:3])
    spread = measured.step_frequency_spread
    apart = f" (standard deviation {spread:.2g} between runs)" * (spread >= 0.0)
    return (
        f"{count_of(measured.runs, f'{measured.origin} run')} at {measured.step_frequency:.4f} Hz{apart}, twin "
        f"{measured.twin_step_frequency:.4f} Hz over the same steps. The envelope holds the twin over {shares} "
        "of the stride."
        + ("" if measured.bandwidth > 0 else UNKNOWN_BANDWIDTH)
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
    return (
        f" The twin as calibrated has the numbers that {found.runs} of the runs gave; it walks at {2 / settled:.4f} Hz."
    )


def leg_words(leg: LegAgreement) -> str:
    """What the lower panels show, in numbers."""
    runs, twin, simple = (f"{1e3 * one.step_length:.1f} mm" for one in (leg.runs, leg.twin, leg.simple))
    return (
        " Below, from one integration of the rate and the foot that rolls: the leg's angle, "
        f"{np.degrees(leg.twin_angle):.2f} and {np.degrees(leg.simple_angle):.2f} degrees rms from the twin's and the "
        f"simple model's, and the hip over a stance; steps of {runs}, each with a "
        f"standard error of {1e3 * leg.step_length_error:.1f} mm, {twin} in the twin, {simple} in the simple model. "
        "The runs' hip is a rigid leg's."
    )


FIGURES = {
    "figure_14_data_way": Entry("Figure 14: the way of the data", 14, ("imu",), draw_data_way, caption_data_way),
    "figure_16_measurement": Entry(
        "Figure 16: measurements and models",
        16,
        ("imu", "twin", "calibrated_twin", "multibody", "comparison"),
        draw_agreement,
        caption_agreement,
        claims=("measurement_encloses", "measurement_slower", "twin_like_simple", "sensor_range", "hip_path_drifts"),
    ),
}
