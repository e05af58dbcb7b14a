"""The basin of attraction of the gait, over angle and rate of the stance leg."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.analytic.pictures import families
from stages.analytic.result import NO_START, REACHES
from stages.drawing import style
from stages.figures.entry import Entry, Given


def draw(given: Given) -> Figure:
    """The picture that `bipedstudy basin` draws; of an unstable gait none."""
    if given.stability.basin is not None:
        return families.draw_basin(given.stability.basin)
    figure, axes = plt.subplots(figsize=(style.TWO_COLUMNS, 1.0))
    axes.set_axis_off()
    axes.text(0.5, 0.5, "the gait is unstable: it has no basin", ha="center")
    return figure


def caption(given: Given) -> str:
    basin = given.stability.basin
    if basin is None:
        return "The gait is unstable; no start stays with it."
    share = {number: 100 * float((basin.ending == number).mean()) for number in range(len(basin.endings))}
    others = ", ".join(f"{words}: {share[number]:.1f} %" for number, words in enumerate(basin.endings)
                       if share[number] and number not in (REACHES, NO_START))  # fmt: skip
    steps = basin.steps[basin.ending == REACHES]
    text = (
        f"Walks of the constraint model from {basin.ending.size} starts just after heel strike: angle and rate of the "
        f"stance leg as on the axes, all else as in the gait. {share[REACHES]:.1f} % come within {basin.near:g} of it "
        f"in all coordinates of the section"
    )
    if steps.size:
        text = f"{text}, after {steps.min()} to {steps.max()} steps, half of them after {np.median(steps):.0f}"
    text = f"{text}; of the others, {others}." if others else f"{text}."
    if share[NO_START]:
        text = f"{text} In {share[NO_START]:.1f} % the trailing leg, as long as in the gait, reaches no ground."
    return text


FIGURE = Entry("Basin of attraction", 23, ("stability",), draw, caption, claims=("stable_gait",))
