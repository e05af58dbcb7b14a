"""Walks on blocks of drawn heights: steps to a fall, the chance to pass the ramp, and what the design does to both."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.drawing import style
from stages.figures.entry import Entry, Given
from stages.rough_ground.result import CONSTRAINT, MODELS, PENALTY, TWIN

LOOKS = {CONSTRAINT: (style.ANALYTIC, "o"), PENALTY: (style.MULTIBODY, "s"), TWIN: (style.TWIN, "^")}
#: Models are drawn beside each other, apart by this factor of the height.
APART = 1.03
LINES = ("-", "--", ":")


def draw(given: Given) -> Figure:
    """Steps and chance over the height with their intervals, and the norm over factors on the design."""
    found = given.rough_ground
    figure, (falls, ramp, norms) = plt.subplots(1, 3, figsize=(style.TWO_COLUMNS, 2.6))
    for number, model in enumerate(MODELS):
        colour, mark = LOOKS[model]
        rows = found.of(model)
        heights = np.array([1e3 * row.block_height_rms for row in rows]) * APART ** (number - 1)
        for axes, middle, low, high in (
            (falls, [row.steps_to_fall for row in rows], [row.steps_low for row in rows],
             [row.steps_high for row in rows]),
            (ramp, [row.ramp_chance for row in rows], [row.ramp_low for row in rows], [row.ramp_high for row in rows]),
        ):  # fmt: skip
            ends = np.where(np.isfinite(high), high, 1e3 * np.array(low))
            axes.vlines(heights, low, ends, color=colour, linewidth=1.0)
            axes.plot(heights, middle, mark, color=colour, markersize=4, markerfacecolor="none", label=model)
    seen = [row.steps_to_fall for row in found.passages if np.isfinite(row.steps_to_fall)]
    lows = [row.steps_low for row in found.passages]
    falls.set(xscale="log", yscale="log", xlabel="rms height of blocks [mm]", ylabel="mean steps to a fall [1]",
              ylim=(0.7 * min(lows), 3.0 * max([*seen, *lows])))  # fmt: skip
    steps = found.passages[0].ramp_steps
    ramp.set(xscale="log", ylim=(-0.03, 1.03), xlabel="rms height of blocks [mm]",
             ylabel=f"chance of {steps} steps [1]")  # fmt: skip
    falls.legend(loc="upper right", handlelength=1.0)
    for line, colour, name in zip(LINES, (style.ANALYTIC, style.MULTIBODY, style.TWIN), changed(given), strict=False):
        own = [row for row in found.norms if row.parameter == name]
        norms.plot([row.share for row in own], [row.sensitivity_norm for row in own], line, color=colour,
                   label=name.partition(".")[2].replace("_", " "))  # fmt: skip
    norms.set(xlabel="factor on the parameter [1]", ylabel="gait sensitivity norm [s/m]")
    norms.legend(loc="best")
    for axes in (falls, ramp):
        ticks = [height for height in (0.1, 0.2, 0.3, 0.5, 1, 2, 3, 5, 10)
                 if axes.get_xlim()[0] <= height <= axes.get_xlim()[1]]  # fmt: skip
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
    style.panel_labels((falls, ramp, norms))
    return figure


def changed(given: Given) -> list[str]:
    """The parameters that are changed."""
    return list(dict.fromkeys(row.parameter for row in given.rough_ground.norms))


def caption(given: Given) -> str:
    found = given.rough_ground
    first = found.of(CONSTRAINT)[0]
    text = (
        "Blocks of independent normal heights, the same for every model. (a) Mean steps to a fall with intervals of "
        "95 %; open at the top where none was seen. (b) Chance to walk over the ramp, "
        f"{first.ramp_steps + 1} sets of blocks."
    )
    twins = found.of(TWIN)
    if twins:
        text = f"{text} The twin's are {', '.join(str(row.falls) for row in twins)} falls, from the least height."
    best = min((row for row in found.norms if np.isfinite(row.sensitivity_norm)),
               key=lambda row: row.sensitivity_norm, default=None)  # fmt: skip
    if best is not None:
        text = (f"{text} (c) The spread of a step's duration over the rms height, {found.sensitivity_norm:.3g} s/m for "
                f"the design, is least with {best.parameter} times {best.share:.3g}: {best.sensitivity_norm:.3g} s/m.")
    return text


FIGURES = {
    "rough_ground": Entry("On blocks of drawn heights", 24, ("rough_ground",), draw, caption, claims=("ramp_passed",)),
}
