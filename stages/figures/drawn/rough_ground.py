"""Walks on blocks of drawn heights: steps to a fall, the chance to pass the ramp, and what the design does to both."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.biped.quantity import written_out
from stages.drawing import style
from stages.figures.entry import Entry, Given
from stages.rough_ground.result import CONSTRAINT, MODELS, PENALTY, TWIN, OnHeight

LOOKS = {CONSTRAINT: (style.ANALYTIC, "o"), PENALTY: (style.MULTIBODY, "s"), TWIN: (style.TWIN, "^")}
#: Models are drawn beside each other, apart by this factor of the height.
APART = 1.03
LINES = ("-", "--", ":")


def draw(given: Given) -> Figure:
    """Steps and chance over the height with their intervals, the norm over factors on the design, and what a search of
    designs reaches.
    """
    found = given.rough_ground
    figure, ((falls, ramp), (norms, reached)) = plt.subplots(2, 2, figsize=(style.TWO_COLUMNS, 4.8))
    for number, model in enumerate(MODELS):
        colour, mark = LOOKS[model]
        rows = found.of(model)
        heights = np.array([1e3 * row.block_height_rms for row in rows]) * APART ** (number - 1)
        for axes, middle, low, high in (
            (falls, [row.steps_to_fall for row in rows], [row.steps_low for row in rows],
             [row.steps_high for row in rows]),
            (ramp, [row.ramp_chance for row in rows], [row.ramp_low for row in rows], [row.ramp_high for row in rows]),
        ):  # fmt: skip
            bars(axes, heights, middle, low, high, colour=colour, mark=mark, label=model)
    seen = [row.steps_to_fall for row in found.passages if np.isfinite(row.steps_to_fall)]
    lows = [row.steps_low for row in found.passages]
    falls.set(xscale="log", yscale="log", xlabel="rms height of blocks [mm]", ylabel="mean steps to a fall [1]",
              ylim=(0.7 * min(lows), 3.0 * max([*seen, *lows])))  # fmt: skip
    steps = found.passages[0].ramp_steps
    ramp.set(xscale="log", ylim=(-0.03, 1.03), xlabel="rms height of blocks [mm]",
             ylabel=f"chance of {steps} steps [1]")  # fmt: skip
    figure.legend(*falls.get_legend_handles_labels(), loc="outside upper center", ncols=len(MODELS), handlelength=1.0)
    for line, colour, name in zip(LINES, (style.ANALYTIC, style.MULTIBODY, style.TWIN), changed(given), strict=False):
        own = [row for row in found.norms if row.parameter == name]
        norms.plot([row.share for row in own], [row.sensitivity_norm for row in own], line, color=colour, marker=".",
                   label=name.partition(".")[2].replace("_", " "))  # fmt: skip
    norms.set(xlabel="factor on the parameter [1]", ylabel="gait sensitivity norm [s/m]")
    norms.legend(loc="best")
    for axes in (falls, ramp):
        ticks = [height for height in np.outer(10.0 ** np.arange(-4, 4), (1, 2, 3, 5)).ravel()
                 if axes.get_xlim()[0] <= height <= axes.get_xlim()[1]]  # fmt: skip
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
    draw_front(reached, given)
    for axis in (falls.yaxis, reached.yaxis):
        style.few_ticks(axis, axis.get_view_interval(), narrow=100.0)
    style.panel_labels((falls, ramp, norms, reached))
    return figure


def bars(
    axes: Axes, at: Sequence[float] | np.ndarray, middle: Sequence[float], low: Sequence[float],
    high: Sequence[float], *, colour: str, mark: str, label: str
) -> None:  # fmt: skip
    """Values with their intervals; open at the top where these have no end."""
    ends = np.where(np.isfinite(high), high, 1e3 * np.array(low))
    axes.vlines(at, low, ends, color=colour, linewidth=1.0)
    axes.plot(at, middle, mark, color=colour, markersize=4, markerfacecolor="none", label=label)


def draw_front(axes: Axes, given: Given) -> None:
    """Steps to a fall over the bound on speed, and those of the given design."""
    rows = given.rough_ground.front
    if rows:
        bars(axes, [100 * row.speed_share for row in rows], [row.steps_to_fall for row in rows],
             [row.steps_low for row in rows], [row.steps_high for row in rows], colour=style.ANALYTIC, mark="o",
             label="least norm")  # fmt: skip
        own, lows = given_row(given), [row.steps_low for row in rows]
        fell = np.isfinite(own.steps_to_fall)
        line, label = (own.steps_to_fall, "given design") if fell else (own.steps_low, "given design, at least")
        axes.axhline(line, color=style.MULTIBODY, linestyle="--", linewidth=1.0, label=label)
        seen = [row.steps_to_fall for row in rows if np.isfinite(row.steps_to_fall)]
        axes.set_ylim(0.5 * min([line, *lows]), 3.0 * max([line, *seen, *lows]))
        axes.legend(loc="upper left")
    axes.set(yscale="log", xlabel="bound on the change of speed [%]", ylabel="mean steps to a fall [1]")


def given_row(given: Given) -> OnHeight:
    """The given design on the blocks of the front."""
    found = given.rough_ground
    return next(row for row in found.of(CONSTRAINT) if row.block_height_rms == found.front[0].block_height_rms)


def changed(given: Given) -> list[str]:
    """The parameters that are changed."""
    return list(dict.fromkeys(row.parameter for row in given.rough_ground.norms))


def caption(given: Given) -> str:
    found = given.rough_ground
    first, twins = found.of(CONSTRAINT)[0], found.of(TWIN)
    best = min((row for row in found.norms if np.isfinite(row.sensitivity_norm)),
               key=lambda row: row.sensitivity_norm, default=None)  # fmt: skip
    return " ".join(filter(None, (
        "Blocks of independent normal heights, the same for every model. (a) Mean steps to a fall with intervals of "
        "95 %; open at the top where none was seen. (b) Chance to walk over the ramp, "
        f"{first.ramp_steps + 1} sets of blocks.",
        f"The twin's are {', '.join(str(row.falls) for row in twins)} falls, from the least height." if twins else "",
        f"(c) The spread of a step's duration over the rms height, {found.sensitivity_norm:.3g} s/m for the design, is "
        "least with " + ("it as it is." if best.share == 1.0 else
                         f"{best.parameter} times {best.share:.3g}: {best.sensitivity_norm:.3g} s/m.") if best else "",
        of_front(given))))


def of_front(given: Given) -> str:
    """What panel d shows, in words."""
    rows = given.rough_ground.front
    if not rows:
        return ""
    own, last = given_row(given), rows[-1]
    before, steps = (written_out(row.steps_to_fall) if np.isfinite(row.steps_to_fall) else
                     f"more than {written_out(row.steps_low)}" for row in (own, last))  # fmt: skip
    return (f"(d) On blocks of {1e3 * own.block_height_rms:.2g} mm, where the design makes {before} steps: designs of "
            "the least norm, their masses and radius searched, each with its speed within a bound. "
            f"Within {100 * last.speed_share:.3g} % it makes {steps}; bounds reached: {last.stopped_by or 'none'}.")


FIGURES = {
    "rough_ground": Entry("On blocks of drawn heights", 24, ("rough_ground",), draw, caption, claims=("ramp_passed",)),
}
