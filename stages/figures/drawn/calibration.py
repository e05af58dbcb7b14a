"""The calibration: the robots that were found, a run that was fitted, and one that was held out."""

import math
from collections.abc import Iterator

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.calibrated_twin.result import Result, Robot
from stages.calibration.reports.sensor_picture import by_phase, fit_picture, rms_by_part
from stages.calibration.result import HALF_WIDTH, FittedRun, Followed, HeldOut, Result as Calibration
from stages.comparison.stride import NoEvidence
from stages.drawing import style
from stages.figures.entry import Entry, Given

# Parameters of the calibrated robots beside the drawing's and the truth, and how their errors go together.

COLORS = (style.ANALYTIC, style.MULTIBODY, style.SECOND)
#: Percent: to scale up to one, then in tens.
TICKS = (-100, -10, -1, 0, 1, 10, 100)


def draw_robots(given: Given) -> Figure:
    """Left: found, corrected with its interval, and true, each against the drawing, whose values stand beside; on the
    right of it the first robot's values. Right: correlations."""
    result: Result = given.calibrated_twin
    if not result.robots:
        raise NoEvidence("; ".join([result.summary(), *result.reasons]))
    names = [short(one.name) for one in result.robots[0].numbers]
    height = 3.9 + 0.3 * max(0, len(names) - 7)  # two lines of text a row
    figure, (left, right) = plt.subplots(1, 2, figsize=(style.TWO_COLUMNS, height), width_ratios=(1.0, 1.2))
    for number, (robot, color) in enumerate(zip(result.robots, COLORS, strict=False)):
        draw_robot(left, robot, color, 0.16 * (2 * number - (len(result.robots) - 1)))
    left.axvline(0.0, color="#555555", linewidth=0.8)
    for row, one in enumerate(result.robots[0].numbers):
        left.text(
            1.01,
            row,
            f"{one.corrected:.4g}\n± {HALF_WIDTH * one.sd:.2g}",
            transform=left.get_yaxis_transform(),
            fontsize=7,
            va="center",
            color=COLORS[0],
        )
    left.set_yticks(range(len(names)), [f"{short(one.name)}\n{one.drawn:.5g} {one.unit}".replace("^2", "²")
                                        for one in result.robots[0].numbers])  # fmt: skip
    left.invert_yaxis()
    left.set_xscale("symlog", linthresh=1.0)
    left.set_xticks(TICKS, [f"{tick:g}" for tick in TICKS])
    reach = max(1.0, 1.3 * float(np.abs(left.dataLim.intervalx).max()))
    left.set(xlim=(-reach, reach), xlabel="difference from nominal [%]")
    left.plot([], [], "o", color="#777777", markerfacecolor="none", markersize=4, label="found by the constraint model")
    left.plot([], [], "o-", color="#777777", markersize=4, label="corrected, 95 %")
    left.plot([], [], "x", color="#777777", markersize=5, label="true")
    draw_correlations(right, result.robots[0], names)
    style.panel_labels((left, right))
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def draw_robot(axes: Axes, robot: Robot, color: str, shift: float) -> None:
    """One robot's numbers in percent of the drawing's size: a larger number is on the right, also of one below zero.
    """
    rows = np.arange(len(robot.numbers)) + shift

    def share(field: str) -> np.ndarray:
        return np.array([np.sign(one.drawn) * 100 * (getattr(one, field) / one.drawn - 1) for one in robot.numbers])

    half = np.array([100 * HALF_WIDTH * one.sd / abs(one.drawn) for one in robot.numbers])
    axes.plot(share("found"), rows, "o", color=color, markerfacecolor="none", markersize=4)
    axes.errorbar(
        share("corrected"),
        rows,
        xerr=half,
        fmt="o",
        color=color,
        markersize=3,
        linewidth=1.0,
        label=f"robot {robot.kind}",
    )
    axes.plot(share("truth"), rows, "x", color=color, markersize=5)


def draw_correlations(axes: Axes, robot: Robot, names: list[str]) -> None:
    """The matrix of correlations as colours."""
    shades = axes.imshow(robot.correlations, cmap="RdBu_r", vmin=-1, vmax=1, aspect="auto")
    axes.grid(visible=False)
    axes.set_xticks(range(len(names)), names, rotation=90)
    axes.set_yticks(range(len(names)), names)
    axes.figure.colorbar(shades, ax=axes, location="top", label="correlation of errors [1]")


def short(name: str) -> str:
    """A parameter's name without its file, in words."""
    return name.partition(".")[2].replace("_", " ")


def caption_robots(given: Given) -> str:
    result: Result = given.calibrated_twin
    return " ".join([
        *map(robot_words, result.robots),
        *(f"{one.name} with and without its outsole: {1e3 * one.longer:.2f} ± {1e3 * HALF_WIDTH * one.longer_sd:.2f} "
          f"mm longer (truly {1e3 * one.true_longer:.2f}), step frequency {100 * one.slower:+.2f} ± "
          f"{100 * HALF_WIDTH * one.slower_sd:.2f} % (truly {100 * one.true_slower:+.2f})." for one in result.pairs),
        *(f"{one.name}, held out, walked by the twin with the numbers {one.numbers}: heel strikes are off by up to "
          f"{1e3 * one.late:.1f} ms." for one in result.checks)])


def robot_words(robot: Robot) -> str:
    """How a robot was found, and whether its intervals hold the truth."""
    known = [one for one in robot.numbers if math.isfinite(one.truth)]
    held = sum(one.holds_truth(HALF_WIDTH) for one in known)
    runs = "1 run" if robot.runs == 1 else f"{robot.runs} runs"
    truth = f"; {held} of {len(known)} intervals hold the truth" if known else ""
    return (
        f"The robot {robot.kind}, from {runs}, {robot.corrected_runs} of them corrected by the Exudyn twin{truth}. "
        f"Intervals follow from {robot.by_what}. "
        f"It walks at {robot.frequency:.4f} ± {HALF_WIDTH * robot.frequency_sd:.4f} Hz on the nominal ramp."
    )


# What the sensors of a calibrated run showed beside what the fit says they should have, and residuals by phase.


def draw_fit(given: Given) -> Figure:
    """The first run that was fitted."""
    calibration: Calibration = given.calibration
    if not calibration.fits:
        raise NoEvidence("; ".join(["no run could be fitted", *_why(given)]))
    fit = calibration.fits[0]
    return fit_picture({"hip": fit.hip, "foot": fit.foot}, fit.strikes)


def _why(given: Given) -> list[str]:
    """Why runs could not be fitted."""
    return [f"{one.name}: {one.why}" for one in given.calibration.failed]


def caption_fit(given: Given) -> str:
    calibration: Calibration = given.calibration
    fit = calibration.fits[0]
    words = (f"{fit.name}, {fit.kind}, {len(fit.strikes) - 1} steps fitted alone by the constraint model: residuals "
             f"of {fit.sigmas:.2f} times the sensors' noise. Lines below: root mean square by part of the step; what "
             f"is sampled at impacts does not count. {_largest(fit)}")  # fmt: skip
    words += "" if fit.converged else f" It did not come to rest: {fit.why}."
    return " ".join([words, *_remarks(calibration)])


def _largest(fit: FittedRun) -> str:
    middle, size = rms_by_part(*by_phase(fit.foot, fit.strikes, (0, 1)))
    worst = int(np.argmax(size))
    return f"The foot's are largest {100 * middle[worst]:.0f} % into a step ({size[worst]:.3f} m/s²)."


def _remarks(calibration: Calibration) -> Iterator[str]:
    for one in calibration.held_out:
        words = (f"{one.name} was held out: with its start and sensors fitted errors are {one.fit_force:.3f} m/s² and "
                 f"{1e3 * one.fit_rate:.1f} mrad/s")  # fmt: skip
        if math.isfinite(one.foretold_force):
            words += (f"; predicted from its first {one.begun:.3g} s, {one.foretold_force:.2f} m/s² and "
                      f"{1e3 * one.foretold_rate:.0f} mrad/s over the rest")  # fmt: skip
        yield words + "."
    for words in calibration.not_seen:
        yield f"{words[0].upper()}{words[1:]}."


# A run that was not fitted beside what the robot found predicts of it from its beginning alone.


def draw_held_out(given: Given) -> Figure:
    """The first run held out that is predicted, or else the first as it is fitted."""
    one, predicted = _shown(given)
    return fit_picture({"hip": one.hip, "foot": one.foot}, one.strikes, "prediction" if predicted else "fit")


def _shown(given: Given) -> tuple[HeldOut, bool]:
    for predicted in (True, False):
        for one in given.calibration.held_out:
            if math.isfinite(one.foretold_force) or not predicted:
                return one, predicted
    raise NoEvidence("; ".join(["no run was held out that the robot found by the others walks", *_why(given)]))


def caption_held_out(given: Given) -> str:
    one, predicted = _shown(given)
    force, rate = (one.foretold_force, one.foretold_rate) if predicted else (one.fit_force, one.fit_rate)
    start = (
        f"those of its first {one.begun:.3g} s"
        if predicted
        else f"fitted to all of it, as from its first {one.begun:.3g} s that robot does not walk to its end"
    )
    return (
        f"{one.name}, {one.kind}, was not fitted: its robot is that of the other runs, its ramp, start and sensors "
        f"are {start}. Over {'the rest' if predicted else 'it'} the specific force is off by "
        f"{force:.3f} m/s² and the rate by {1e3 * rate:.1f} mrad/s (rms), where sensors "
        f"have noise of {one.noise_force:.3f} and {1e3 * one.noise_rate:.2f}. Lines below: root mean square by "
        "part of the step. Where each run is of a robot of its own, their differences are in it."
    )


# What was known of a run after each of its samples, beside what was true.


def draw_followed(given: Given) -> Figure:
    """Above the inner leg's angle with the truth, then their difference in its band; below the next heel strike."""
    one = _followed(given)
    figure, (above, middle, below) = plt.subplots(3, 1, figsize=(style.ONE_COLUMN, 5.4), sharex=True)
    above.plot(one.true_time, one.true_angle, color=style.MEASURED, linewidth=2.5, label="true")
    above.plot(one.time, one.angle, color=style.ANALYTIC, linewidth=0.9, label="followed")
    low, high = np.nanpercentile(one.true_angle if len(one.true_angle) else one.angle, (1, 99))
    above.set(ylabel="inner leg's angle [rad]", ylim=(1.2 * low - 0.2 * high, 1.2 * high - 0.2 * low))
    style.mark_beyond(above)
    _band(middle, one.time, 1e3 * _off(one), 1e3 * one.angle_sd, "followed less true")
    middle.set_ylabel("angle, followed\nless true [mrad]")
    _band(below, one.time, 1e3 * _late(one), 1e3 * one.next_strike_sd, "predicted less measured")
    below.set(xlabel="time since a heel strike [s]", ylabel="next strike, predicted\nless measured [ms]")
    figure.legend(handles=[*above.get_lines()[:2], *middle.collections], loc="outside upper center", ncols=3)
    style.panel_labels((above, middle, below))
    return figure


def _followed(given: Given) -> Followed:
    if not given.calibration.followed:
        raise NoEvidence("; ".join(["no run could be followed", *_why(given)]))
    one: Followed = given.calibration.followed[0]
    return one


def _band(axes: Axes, time: np.ndarray, off: np.ndarray, sd: np.ndarray, label: str) -> None:
    """A difference, about which a 95 % interval lies."""
    half = HALF_WIDTH * sd
    axes.fill_between(time, -half, half, color=style.SECOND, alpha=0.3, linewidth=0, label="95 %")
    axes.plot(time, off, color=style.ANALYTIC, linewidth=0.9, label=label)
    room = 4.0 * float(np.nanmedian(half))
    axes.set_ylim(-room, room)
    style.mark_beyond(axes)


def _off(one: Followed) -> np.ndarray:
    """By how much the angle is off (n,), NaN where nobody knows it."""
    if not len(one.true_time):
        return np.full(len(one.time), math.nan)
    return np.asarray(one.angle - np.interp(one.time, one.true_time, one.true_angle, math.nan, math.nan))


def _late(one: Followed) -> np.ndarray:
    """By how much predicted heel strikes are later than the measured ones near them (n,); NaN where there are none."""
    nearest = np.abs(one.next_strike[:, None] - one.strikes).argmin(axis=1)
    late = one.next_strike - one.strikes[nearest]
    return np.where(one.next_strike > one.strikes[-1] + 0.25 * np.diff(one.strikes).mean(), math.nan, late)


def caption_followed(given: Given) -> str:
    one = _followed(given)
    off, late = _off(one), _late(one)
    known = late[np.isfinite(late)]
    inside = np.mean(np.abs(known) <= HALF_WIDTH * one.next_strike_sd[np.isfinite(late)])
    words = (f"{one.name}, followed with the robot that was found from it: after each sample of the hip, from those "
             f"until then. Heel strikes are predicted to {1e3 * math.sqrt(np.mean(known**2)):.1f} ms (rms), for "
             f"{100 * inside:.0f} % of the samples inside their 95 % interval; the step "
             f"length in the end to {1e3 * HALF_WIDTH * one.step_length[-1, 1]:.1f} mm.")  # fmt: skip
    if np.isfinite(off).any():
        seen = np.isfinite(off)
        inside = np.mean(np.abs(off[seen]) <= HALF_WIDTH * one.angle_sd[seen])
        words += (f" The inner leg's angle is off by {1e3 * math.sqrt(np.mean(off[seen] ** 2)):.1f} mrad (rms), and "
                  f"inside of its interval for {100 * inside:.0f} % of the samples, with clocks put together by the "
                  "heel strikes.")  # fmt: skip
    if one.strikes[-1] - one.time[-1] > np.diff(one.strikes).max():
        words += f" After {one.time[-1]:.1f} s it is lost; the run goes on to {one.strikes[-1]:.1f} s."
    return words


FIGURES = {
    "calibration_followed": Entry(
        "Calibration: a run followed, sample by sample",
        44,
        ("calibration",),
        draw_followed,
        caption_followed,
    ),
    "calibrated_robot": Entry(
        "Calibration: the robots that were found",
        42,
        ("calibrated_twin",),
        draw_robots,
        caption_robots,
        claims=("prototype_is_model", "outsole_slows"),
    ),
    "calibration_fit": Entry(
        "Calibration: a run as its sensors showed it and as the fit has it",
        41,
        ("calibration",),
        draw_fit,
        caption_fit,
        claims=("prototype_is_model",),
    ),
    "calibration_held_out": Entry(
        "Calibration: a run held out, predicted from its beginning",
        43,
        ("calibration",),
        draw_held_out,
        caption_held_out,
    ),
}
